use trocar_core::lane::Lane;
use trocar_core::time::nearest_ticks;

trocar_core::settings! {
    /// Delays typical of the wrist (Schuurmans et al. 2009, <https://doi.org/10.1007/s00221-008-1647-7>); the
    /// long-latency gain varies by a factor of 4 to 10, hence its default of 0. Chosen here: the short latency responds
    /// to velocity, the long one to displacement.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StretchSettings in "operator.stretch_" {
        /// Force per speed of the stretch, at the short latency.
        short_gain_n_s_per_m: f64 [NON_NEGATIVE] = 0.0,
        /// Delay of the short latency, at most 1 s.
        short_delay_s: f64 [SHARE] = 0.025,
        /// Force per stretch, at the long latency.
        long_gain_n_per_m: f64 [NON_NEGATIVE] = 0.0,
        /// Delay of the long latency, at most 1 s.
        long_delay_s: f64 [SHARE] = 0.06,
        /// Time constant with which the muscle follows the reflex.
        activation_s: f64 [NON_NEGATIVE] = 0.03,
    }
}

impl StretchSettings {
    pub fn acts(&self) -> bool {
        self.short_gain_n_s_per_m > 0.0 || self.long_gain_n_per_m > 0.0
    }
}

/// Shifts the position towards which an arm of static stiffness `K` pulls by `u`:
///
/// ```text
/// e = x_h - x_intended
/// K w = G_s (e(t - τ_s) - e(t - τ_s - T)) / T + G_l e(t - τ_l)
/// u_k = -a_k,   a_k = w + exp(-T/τ_a) (a_{k-1} - w)
/// ```
#[derive(Debug, Clone)]
pub(super) struct Stretch<L> {
    /// `G_s / (K T)` and `G_l / K`.
    short: L,
    long: L,
    keep: L,
    history_m: Box<[L]>,
    at: usize,
    short_ticks: usize,
    long_ticks: usize,
    activation_m: L,
}

impl<L: Lane> Stretch<L> {
    pub(super) fn new(settings: &StretchSettings, stiffness_n_per_m: f64, tick_s: f64) -> Option<Self> {
        if !settings.acts() || stiffness_n_per_m <= 0.0 {
            return None;
        }
        let ticks = |delay_s: f64| nearest_ticks(delay_s, tick_s) as usize;
        let (short_ticks, long_ticks) = (ticks(settings.short_delay_s), ticks(settings.long_delay_s));
        let keep = if settings.activation_s > 0.0 { libm::exp(-tick_s / settings.activation_s) } else { 0.0 };
        Some(Self {
            short: L::splat(settings.short_gain_n_s_per_m / (stiffness_n_per_m * tick_s)),
            long: L::splat(settings.long_gain_n_per_m / stiffness_n_per_m),
            keep: L::splat(keep),
            history_m: vec![L::zero(); short_ticks.max(long_ticks) + 2].into(),
            at: 0,
            short_ticks,
            long_ticks,
            activation_m: L::zero(),
        })
    }

    #[inline(always)]
    fn ago(&self, ticks: usize) -> L {
        let length = self.history_m.len();
        self.history_m[(self.at + length - ticks) % length]
    }

    #[inline(always)]
    pub(super) fn step(&mut self, stretch_m: L) -> L {
        self.at = (self.at + 1) % self.history_m.len();
        self.history_m[self.at] = stretch_m;
        let change_m = self.ago(self.short_ticks) - self.ago(self.short_ticks + 1);
        let wanted_m = self.short * change_m + self.long * self.ago(self.long_ticks);
        self.activation_m = wanted_m + self.keep * (self.activation_m - wanted_m);
        -self.activation_m
    }
}

trocar_core::lane::gather!(Stretch { short, long, keep, history_m, activation_m } same { at, short_ticks, long_ticks });

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;
    const STIFFNESS_N_PER_M: f64 = 500.0;

    fn shifts(settings: &StretchSettings, stretch: impl Fn(u64) -> f64) -> Vec<f64> {
        let mut reflex = Stretch::<f64>::new(settings, STIFFNESS_N_PER_M, TICK_S).expect("a reflex");
        (0..1000).map(|tick| reflex.step(stretch(tick))).collect()
    }

    #[test]
    fn without_a_gain_there_is_no_reflex() {
        assert!(Stretch::<f64>::new(&StretchSettings::default(), STIFFNESS_N_PER_M, TICK_S).is_none());
    }

    #[test]
    fn a_ramp_is_answered_after_the_delays_as_in_the_closed_form() {
        let settings =
            StretchSettings { short_gain_n_s_per_m: 20.0, long_gain_n_per_m: 100.0, ..StretchSettings::default() };
        // A stretch of 0.1 m/s from tick 100 on.
        let speed = 0.1;
        let shifts = shifts(&settings, |tick| speed * TICK_S * tick.saturating_sub(100) as f64);
        assert!(shifts[..126].iter().all(|shift| *shift == 0.0), "no answer within 25 ms");
        assert!(shifts[126] < 0.0, "pulls back");
        // The lag of a step that is felt from tick 126 on, after n + 1 ticks: 1 - exp(-(n + 1) T / τ).
        for n in 0..30 {
            let expected = -20.0 * speed / STIFFNESS_N_PER_M * (1.0 - (-(n as f64 + 1.0) * TICK_S / 0.03).exp());
            assert!((shifts[126 + n] - expected).abs() < 1e-15, "{n}");
        }
        // Much later the long latency follows the ramp, late by its delay and about the lag of the muscle.
        let slope = (shifts[900] - shifts[800]) / 0.1;
        assert!((slope + 100.0 * speed / STIFFNESS_N_PER_M).abs() < 1e-6, "{slope}");
    }

    #[test]
    fn a_constant_stretch_is_answered_only_by_the_long_latency() {
        let settings = StretchSettings { short_gain_n_s_per_m: 20.0, ..StretchSettings::default() };
        let short = shifts(&settings, |tick| if tick < 10 { 0.0 } else { 0.01 });
        assert!(short[999].abs() < 1e-12 && short[36] < 0.0);
        let settings = StretchSettings { long_gain_n_per_m: 100.0, activation_s: 0.0, ..StretchSettings::default() };
        let long = shifts(&settings, |tick| if tick < 10 { 0.0 } else { 0.01 });
        assert_eq!((long[69], long[70]), (0.0, -0.01 * 100.0 / STIFFNESS_N_PER_M));
    }
}
