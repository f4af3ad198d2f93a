use trocar_core::lane::Lane;

/// A standard linear solid with a stiffening spring; `d_v` is the viscous deflection of the Maxwell branch:
///
/// ```text
/// f = k∞ d + a₂ d² + k₁ (d - d_v),   τ d_v' = d - d_v,   k∞ = relaxed_share · k₀,  k₁ = k₀ - k∞
/// ```
/// The deflection is linear within a tick, so the update has no discretisation error:
///
/// ```text
/// d_v ← e d_v + (c - e) d_before + (1 - c) d,   e = exp(-T/τ),  c = (1 - e) τ/T
/// ```
#[derive(Debug, Clone, Copy)]
pub(super) struct Viscoelastic<L> {
    /// `k∞ + k₁ c`: slope at the end of a tick, at `d = 0`.
    tick_stiffness: L,
    stiffening: L,
    /// `k₁`.
    branch_stiffness: L,
    decay: L,
    /// `c`.
    ramp_share: L,
    deflection_m: L,
    viscous_m: L,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct TickEnd<L> {
    inherited_m: L,
}

impl<L: Lane> Viscoelastic<L> {
    pub(super) fn new(
        stiffness_n_per_m: f64,
        stiffening_n_per_m2: f64,
        relaxed_share: f64,
        relaxation_time_s: f64,
        tick_s: f64,
    ) -> Self {
        let ratio = tick_s / relaxation_time_s;
        let ramp_share = -libm::expm1(-ratio) / ratio;
        let branch = stiffness_n_per_m * (1.0 - relaxed_share);
        Self {
            tick_stiffness: L::splat(stiffness_n_per_m * relaxed_share + branch * ramp_share),
            stiffening: L::splat(stiffening_n_per_m2),
            branch_stiffness: L::splat(branch),
            decay: L::splat(libm::exp(-ratio)),
            ramp_share: L::splat(ramp_share),
            deflection_m: L::zero(),
            viscous_m: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn tick_end(&self) -> TickEnd<L> {
        let inherited_m = self.decay * self.viscous_m + (self.ramp_share - self.decay) * self.deflection_m;
        TickEnd { inherited_m }
    }

    /// At a force of 0 it is the free surface's.
    #[inline(always)]
    pub(super) fn deflection_at(&self, end: TickEnd<L>, force_n: L) -> L {
        let load = force_n + self.branch_stiffness * end.inherited_m;
        let root = (self.tick_stiffness * self.tick_stiffness + L::splat(4.0) * self.stiffening * load).sqrt();
        L::splat(2.0) * load / (self.tick_stiffness + root)
    }

    #[inline(always)]
    pub(super) fn deflect(&mut self, end: TickEnd<L>, deflection_m: L) -> (L, L) {
        let force_n = (self.tick_stiffness + self.stiffening * deflection_m) * deflection_m
            - self.branch_stiffness * end.inherited_m;
        self.viscous_m = end.inherited_m + (L::splat(1.0) - self.ramp_share) * deflection_m;
        self.deflection_m = deflection_m;
        (force_n, self.branch_stiffness * (deflection_m - self.viscous_m))
    }
}

trocar_core::lane::gather!(Viscoelastic {
    tick_stiffness,
    stiffening,
    branch_stiffness,
    decay,
    ramp_share,
    deflection_m,
    viscous_m,
});

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 1e-3;
    const K0: f64 = 300.0;
    const SHARE: f64 = 0.4;
    const TAU_S: f64 = 0.8;

    fn solid(stiffening: f64) -> Viscoelastic<f64> {
        Viscoelastic::new(K0, stiffening, SHARE, TAU_S, TICK_S)
    }

    #[test]
    fn oracle_a_held_deflection_relaxes_as_the_standard_linear_solid() {
        let (d, a2) = (8e-3, 4e3);
        let mut solid = solid(a2);
        let k1 = K0 * (1.0 - SHARE);
        // The deflection rises within the first tick; the closed form is for a ramp of this length.
        let from = k1 * d * TAU_S / TICK_S * -(-TICK_S / TAU_S).exp_m1();
        for tick in 0..5000 {
            let (force, _) = solid.deflect(solid.tick_end(), d);
            let expected = SHARE * K0 * d + a2 * d * d + from * (-TICK_S * f64::from(tick) / TAU_S).exp();
            assert!((force / expected - 1.0).abs() < 1e-12, "{tick}: {force} instead of {expected}");
        }
    }

    #[test]
    fn oracle_under_a_held_force_the_deflection_creeps_as_the_standard_linear_solid() {
        let force = 1.3;
        let mut solid = solid(0.0);
        let relaxed = force / (SHARE * K0);
        let mut at_first = None;
        for tick in 0..8000 {
            let end = solid.tick_end();
            let d = solid.deflection_at(end, force);
            let (exerted, _) = solid.deflect(end, d);
            assert!((exerted - force).abs() < 1e-12, "{exerted}");
            // Without force at the start, the immediate deflection is F/k₀ apart from the creep in the first tick.
            let first = *at_first.get_or_insert(d);
            let creep = (-TICK_S * f64::from(tick) * SHARE / TAU_S).exp();
            let expected = relaxed + (first - relaxed) * creep;
            assert!((d / expected - 1.0).abs() < 1e-6, "{tick}: {d} instead of {expected}");
        }
        let at_once = force / K0;
        assert!((at_first.expect("a tick") / at_once - 1.0).abs() < 1e-3);
        assert!((solid.deflection_m / relaxed - 1.0).abs() < 0.03, "crept by k₀/k∞");
    }

    #[test]
    fn a_free_surface_recovers_and_never_pulls() {
        let mut solid = solid(2e3);
        for _ in 0..1000 {
            solid.deflect(solid.tick_end(), 0.01);
        }
        let mut before = 0.01;
        for _ in 0..3000 {
            let end = solid.tick_end();
            let free = solid.deflection_at(end, 0.0);
            assert!(free >= 0.0 && free < before);
            let (force, branch) = solid.deflect(end, free);
            assert!(force.abs() < 1e-12 && branch <= 0.0);
            before = free;
        }
    }
}
