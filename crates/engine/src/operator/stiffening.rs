use trocar_core::lane::Lane;

trocar_core::settings! {
    /// The stiffness of a hand rises with its grip force (Hasser and Cutkosky 2002). The values are chosen here.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StiffeningSettings in "operator.stiffening_" {
        /// Share by which the static stiffness of the arm rises per newton of the felt force.
        per_n: f64 [NON_NEGATIVE] = 0.0,
        /// Largest share by which the stiffness rises.
        limit: f64 [NON_NEGATIVE] = 1.0,
        /// Time constant with which the stiffness follows the force.
        time_s: f64 [NON_NEGATIVE] = 0.1,
    }
}

impl StiffeningSettings {
    pub fn acts(&self) -> bool {
        self.per_n > 0.0 && self.limit > 0.0
    }
}

/// `σ` follows `min(limit, rate |F_h|)`: a resting master meets `1 + σ` times the arm's static stiffness.
#[derive(Debug, Clone)]
pub(super) struct Stiffening<L> {
    per_n: L,
    limit: L,
    keep: L,
    share: L,
}

impl<L: Lane> Stiffening<L> {
    pub(super) fn new(settings: &StiffeningSettings, tick_s: f64) -> Option<Self> {
        let keep = if settings.time_s > 0.0 { libm::exp(-tick_s / settings.time_s) } else { 0.0 };
        settings.acts().then(|| Self {
            per_n: L::splat(settings.per_n),
            limit: L::splat(settings.limit),
            keep: L::splat(keep),
            share: L::zero(),
        })
    }

    #[inline(always)]
    pub(super) fn step(&mut self, felt: L, stretch_m: L) -> L {
        let wanted = (self.per_n * felt.abs()).min(self.limit);
        self.share = wanted + self.keep * (self.share - wanted);
        -(self.share * stretch_m)
    }
}

trocar_core::lane::gather!(Stiffening { per_n, limit, keep, share });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_follows_the_force_up_to_its_limit() {
        let settings = StiffeningSettings { per_n: 0.2, limit: 0.5, time_s: 0.1 };
        let mut grip = Stiffening::<f64>::new(&settings, 1e-3).expect("it stiffens");
        // 1 N: a share of 0.2, reached with the lag; here after 50 ms.
        let shifts: Vec<f64> = (0..50).map(|_| grip.step(-1.0, 0.01)).collect();
        assert!((shifts[49] + 0.01 * 0.2 * (1.0 - (-0.5_f64).exp())).abs() < 1e-15, "{}", shifts[49]);
        for _ in 0..5000 {
            grip.step(40.0, 0.01);
        }
        assert!((grip.step(40.0, -0.01) - 0.005).abs() < 1e-12);
        assert!(Stiffening::<f64>::new(&StiffeningSettings::default(), 1e-3).is_none());
    }
}
