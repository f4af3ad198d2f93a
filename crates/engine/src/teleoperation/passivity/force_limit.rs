use super::SchemeContext;
use trocar_core::lane::Lane;

/// Limits the force on the hand to `|F| <= A / d`, with the largest displacement over the next tick along the force
///
/// ```text
/// d = max(0, -sign(F) v T + T² (|a| + |F - F_last| / m) / 2)
/// ```
/// with the acceleration `a` of the last tick and the master's mass `m`.
#[derive(Debug, Clone)]
pub(super) struct ForceLimit<L> {
    tick: L,
    inverse_tick: L,
    half_square_tick: L,
    inverse_mass: L,
    velocity: L,
    pub(super) force_n: L,
    command_n: L,
    shown_n: L,
    pub(super) dissipated_j: L,
}

impl<L: Lane> ForceLimit<L> {
    pub(super) fn new(context: &SchemeContext<L>) -> Self {
        let zero = L::zero();
        Self {
            tick: L::splat(context.tick_s),
            inverse_tick: L::splat(1.0 / context.tick_s),
            half_square_tick: L::splat(0.5 * context.tick_s * context.tick_s),
            inverse_mass: L::splat(1.0 / context.master_mass_kg),
            velocity: zero,
            force_n: zero,
            command_n: zero,
            shown_n: zero,
            dissipated_j: zero,
        }
    }

    #[inline(always)]
    pub(super) fn work_j(&mut self, displacement_m: L) -> L {
        self.dissipated_j = self.dissipated_j + (self.force_n - self.command_n) * displacement_m;
        self.force_n * displacement_m
    }

    #[inline(always)]
    pub(super) fn show(&mut self, force_n: L) {
        self.shown_n = self.shown_n.max(force_n.abs());
    }

    /// Damping never raises the force above the command or the largest tissue force so far.
    #[inline(always)]
    pub(super) fn limit(&mut self, command_n: L, damping: L, velocity: L, energy_j: L) -> L {
        let zero = L::zero();
        let shown = self.shown_n.max(command_n.abs());
        let damped = (command_n + damping * velocity).clamp(-shown, shown);
        let wanted = L::select(damping.gt(zero), damped, command_n);

        let acceleration = ((velocity - self.velocity) * self.inverse_tick).abs();
        let change = (wanted - self.force_n).abs() * self.inverse_mass;
        let along = L::select(wanted.lt(zero), velocity, -velocity) * self.tick;
        let travel = along + self.half_square_tick * (acceleration + change);
        let drives_hand = travel.gt(zero);
        let max_n = energy_j.max(zero) / L::select(drives_hand, travel, L::splat(1.0));
        let is_cut = drives_hand & wanted.abs().gt(max_n);
        self.velocity = velocity;
        self.command_n = command_n;
        self.force_n = L::select(is_cut, wanted.clamp(-max_n, max_n), wanted);
        self.force_n
    }
}

trocar_core::lane::gather!(ForceLimit {
    tick,
    inverse_tick,
    half_square_tick,
    inverse_mass,
    velocity,
    force_n,
    command_n,
    shown_n,
    dissipated_j,
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resisting_force_is_free_and_a_driving_force_must_be_paid() {
        let context = SchemeContext::<f64>::for_tests();
        let mut limit = ForceLimit::new(&context);
        limit.velocity = 0.1;
        // The hand moves in against the force, which needs no energy.
        assert_eq!(limit.limit(2.0, 0.0, 0.1, 0.0), 2.0);
        let mut limit = ForceLimit::new(&context);
        (limit.velocity, limit.force_n) = (-0.1, 2.0);
        // The hand moves out by 0.1 mm per tick, so 2 N take 0.2 mJ.
        assert!((limit.limit(2.0, 0.0, -0.1, 1e-4) - 1.0).abs() < 1e-12);
        assert_eq!(limit.limit(2.0, 0.0, -0.1, 0.0), 0.0);
    }

    #[test]
    fn damping_does_not_exceed_the_tissue_force() {
        let mut limit = ForceLimit::new(&SchemeContext::<f64>::for_tests());
        limit.velocity = 0.1;
        assert_eq!(limit.limit(0.0, 50.0, 0.1, 1.0), 0.0);
        limit.show(-1.5);
        assert_eq!(limit.limit(0.0, 50.0, 0.1, 1.0), 1.5);
        assert_eq!(limit.limit(0.0, 10.0, 0.1, 1.0), 1.0);
    }

    #[test]
    fn the_work_includes_the_damping_and_the_excess_over_the_command_is_dissipated() {
        let mut limit = ForceLimit::new(&SchemeContext::<f64>::for_tests());
        limit.show(5.0);
        limit.velocity = 0.1;
        // 1 N and a damping of 20 N·s/m at 0.1 m/s.
        assert_eq!(limit.limit(1.0, 20.0, 0.1, 1.0), 3.0);
        assert!((limit.work_j(2e-3) - 6e-3).abs() < 1e-15);
        assert!((limit.dissipated_j - 4e-3).abs() < 1e-15);
        limit.work_j(1e-3);
        assert!((limit.dissipated_j - 6e-3).abs() < 1e-15, "a running total");
    }

    #[test]
    fn a_change_of_force_or_an_acceleration_increases_the_displacement_of_the_tick() {
        let context = SchemeContext::<f64>::for_tests();
        // d = T² (|a| + |F - F_last| / m) / 2 at rest: 2 N more on 0.245 kg.
        let mut limit = ForceLimit::new(&context);
        let travel = 0.5e-6 * 2.0 / context.master_mass_kg;
        assert!((limit.limit(2.0, 0.0, 0.0, 1.5 * travel) - 1.5).abs() < 1e-9);
        // From 0 to 0.01 m/s outwards: 10 m/s², and a travel of 0.01 mm.
        let mut limit = ForceLimit::new(&context);
        limit.force_n = 2.0;
        let travel = 0.01e-3 + 0.5e-6 * 10.0;
        assert!((limit.limit(2.0, 0.0, -0.01, 1.5 * travel) - 1.5).abs() < 1e-9);
        // A force that draws the hand in must be paid when the hand moves in.
        let mut limit = ForceLimit::new(&context);
        (limit.force_n, limit.velocity) = (-2.0, 0.01);
        assert!((limit.limit(-2.0, 0.0, 0.01, 1.5 * 0.01e-3) + 1.5).abs() < 1e-9);
    }
}
