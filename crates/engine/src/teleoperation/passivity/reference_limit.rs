use super::SchemeContext;
use super::port::SlavePort;
use trocar_core::lane::Lane;

const CATCH_UP_S: f64 = 0.2;

/// The account must pay for the motion to which a command commits the slave. With a force `f` and a tissue stiffness up
/// to `K`, a travel `d` takes at most
///
/// ```text
/// W(d) = f d + K d² / 2 <= A    d in [(-f - √(f² + 2 K A)) / K, (-f + √(f² + 2 K A)) / K]
/// ```
/// Over a delayed link the reference moves against the force only at `|f v| β <= A` with the brake's time constant `β`:
/// a slave short of energy does not hit its brake repeatedly.
#[derive(Debug, Clone)]
pub(super) struct ReferenceLimit<L> {
    step: L,
    spending_ticks: L,
    share: L,
    tissue: L,
    per_velocity: L,
    per_state: L,
    per_lead: L,
    inverse_per_lead: L,
    brake: L,
    gain: L,
    inverse_gain: L,
    resting_state: L,
    next_state: [L; 4],
    state: L,
    target: L,
    reference: L,
    pub(super) committed_j: L,
    pub(super) missing_j: L,
    /// `∫ f d(target - reference)`
    pub(super) refused_j: L,
}

impl<L: Lane> ReferenceLimit<L> {
    pub(super) fn new(context: &SchemeContext<L>, stiffness_n_per_m: f64, speed_m_per_s: f64) -> Self {
        let motion = &context.motion;
        let start = context.reference_m;
        Self {
            step: L::splat(speed_m_per_s * context.tick_s),
            spending_ticks: L::splat(if context.is_immediate { 0.0 } else { motion.brake_s / context.tick_s }),
            share: L::splat(if speed_m_per_s.is_finite() { context.tick_s / CATCH_UP_S } else { 1.0 }.min(1.0)),
            tissue: L::splat(stiffness_n_per_m) * context.energy_scale,
            per_velocity: L::splat(motion.per_velocity_s),
            per_state: L::splat(motion.per_state),
            per_lead: L::splat(motion.per_lead),
            inverse_per_lead: L::splat(1.0 / motion.per_lead),
            brake: L::splat(motion.brake_s),
            gain: L::splat(motion.gain),
            inverse_gain: L::splat(1.0 / motion.gain),
            resting_state: L::splat(motion.resting_state),
            next_state: motion.next_state.map(L::splat),
            state: L::zero(),
            target: start,
            reference: start,
            committed_j: L::zero(),
            missing_j: L::zero(),
            refused_j: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn follow(&mut self, target: L, hand: L, port: &SlavePort<L>, energy_j: L) -> L {
        let zero = L::zero();
        let gap = target - self.reference;
        let reach = (target - self.target).abs() + (gap.abs() * self.share).min(self.step);
        let (position, velocity, force) = (port.position_m, port.velocity_m_per_s, port.cost_j_per_m);
        let affordable = energy_j.max(zero);
        let costs = (gap * force).gt(zero) & self.spending_ticks.gt(zero);
        let paid = affordable / L::select(costs, force.abs() * self.spending_ticks, L::splat(1.0));
        let reach = L::select(costs, reach.min(paid), reach);
        let wanted = L::select(gap.abs().le(reach), target, self.reference + gap.clamp(-reach, reach));

        let root = (force * force + (affordable + affordable) * self.tissue).sqrt();
        let (farthest, nearest) = ((root - force) / self.tissue, (-root - force) / self.tissue);
        let committed = self.per_velocity * velocity + self.per_state * self.state;
        let braking = -self.brake * velocity;
        let max_lead = ((farthest - committed) * self.inverse_per_lead).max(braking);
        let min_lead = ((nearest - committed) * self.inverse_per_lead).min(braking);
        let (max, min) = ((position + max_lead) * self.inverse_gain, (position + min_lead) * self.inverse_gain);
        // An unlimited reference equals the target, bit for bit.
        let reference = L::select(wanted.gt(max), max, L::select(wanted.lt(min), min, wanted));

        self.missing_j = (force * (hand - reference)).max(zero);
        let refused = (target - self.target) - (reference - self.reference);
        self.refused_j = self.refused_j + force * refused;
        (self.target, self.reference) = (target, reference);
        let lead = self.gain * reference - position;
        let travel = committed + self.per_lead * lead;
        self.committed_j = (travel * (force + L::splat(0.5) * self.tissue * travel)).max(zero);
        let [of_velocity, of_state, of_lead, _] = self.next_state;
        self.state = of_velocity * velocity + of_state * self.state + of_lead * lead;
        reference
    }
}

trocar_core::lane::gather!(ReferenceLimit {
    step,
    spending_ticks,
    share,
    tissue,
    per_velocity,
    per_state,
    per_lead,
    inverse_per_lead,
    brake,
    gain,
    inverse_gain,
    resting_state,
    next_state,
    state,
    target,
    reference,
    committed_j,
    missing_j,
    refused_j,
});

#[cfg(test)]
mod tests {
    use super::*;

    const STIFFNESS_N_PER_M: f64 = 2e4;

    fn limit(is_immediate: bool, speed_m_per_s: f64) -> ReferenceLimit<f64> {
        let context = SchemeContext { is_immediate, ..SchemeContext::<f64>::for_tests() };
        ReferenceLimit::new(&context, STIFFNESS_N_PER_M, speed_m_per_s)
    }

    fn port(position_m: f64, velocity_m_per_s: f64, cost_j_per_m: f64) -> SlavePort<f64> {
        SlavePort { force_n: cost_j_per_m, cost_j_per_m, work_j: 0.0, position_m, velocity_m_per_s }
    }

    #[test]
    fn with_enough_energy_the_reference_equals_the_target_to_the_last_bit() {
        let mut limit = limit(false, 0.03);
        for tick in 1..100 {
            let target = 1e-5 * f64::from(tick);
            assert_eq!(limit.follow(target, target, &port(target, 0.01, 2.0), 1.0), target);
        }
        assert_eq!((limit.refused_j, limit.missing_j), (0.0, 0.0));
    }

    #[test]
    fn a_slave_at_rest_goes_no_further_than_its_account_allows() {
        for (force, energy) in [(0.0, 1e-3), (2.0, 1e-3), (5.0, 4e-3), (-2.0, 1e-3)] {
            let mut limit = limit(true, f64::INFINITY);
            let reference = limit.follow(0.5, 0.5, &port(0.0, 0.0, force), energy);
            // f d + K d² / 2 = A for the travel of the command.
            let travel = limit.per_lead * limit.gain * reference;
            let work = force * travel + 0.5 * STIFFNESS_N_PER_M * travel * travel;
            assert!((work - energy).abs() < 1e-12 && travel > 0.0, "{force}: {work} {energy}");
            assert!((limit.committed_j - energy).abs() < 1e-12, "all of it is committed");
            assert!((limit.refused_j - force * (0.5 - reference)).abs() < 1e-12, "{}", limit.refused_j);
            let hand = force * (0.5 - reference);
            assert!((limit.missing_j - hand.max(0.0)).abs() < 1e-12, "the way to the hand");
        }
    }

    #[test]
    fn a_retreat_is_limited_in_the_same_way_and_paid_by_the_tissue() {
        let mut limit = limit(true, f64::INFINITY);
        let reference = limit.follow(-0.5, -0.5, &port(0.0, 0.0, 2.0), 1e-3);
        let travel = limit.per_lead * limit.gain * reference;
        let work = 2.0 * travel + 0.5 * STIFFNESS_N_PER_M * travel * travel;
        // Back by 2 f / K without cost, and further as the account allows.
        assert!((work - 1e-3).abs() < 1e-12 && travel < -2.0 * 2.0 / STIFFNESS_N_PER_M, "{travel}");
    }

    #[test]
    fn without_energy_a_moving_slave_is_braked() {
        let mut limit = limit(true, f64::INFINITY);
        let reference = limit.follow(0.5, 0.5, &port(0.01, 0.05, 0.0), 0.0);
        let brake = limit.brake;
        assert!((limit.gain * reference - 0.01 + brake * 0.05).abs() < 1e-12, "{reference}");
        let mut limit = self::limit(true, f64::INFINITY);
        let reference = limit.follow(-0.5, -0.5, &port(0.01, -0.05, 0.0), -1.0);
        assert!((limit.gain * reference - 0.01 - brake * 0.05).abs() < 1e-12, "from the other side: {reference}");
    }

    #[test]
    fn a_slave_that_was_held_back_catches_up_at_its_speed_and_then_with_its_time_constant() {
        let mut limit = limit(false, 0.03);
        limit.reference = -0.02;
        limit.target = 0.0;
        let mut expected = -0.02_f64;
        for tick in 1..=300 {
            let target = 1e-5 * f64::from(tick);
            let gap = target - expected;
            // 30 mm/s or the gap over 0.2 s, plus the target's 10 mm/s.
            let reach = 1e-5 + (gap / 200.0).min(3e-5);
            expected = if gap <= reach { target } else { expected + reach };
            let reference = limit.follow(target, target, &port(limit.reference, 0.0, 0.0), 10.0);
            assert!((reference - expected).abs() < 1e-12, "{tick}: {reference} instead of {expected}");
        }
    }

    #[test]
    fn over_a_delay_the_reference_moves_against_the_force_while_the_account_lasts() {
        let mut limit = limit(false, 0.03);
        // |f v| β <= A, with the time constant β of the brake.
        let energy = 1e-6;
        let reference = limit.follow(1e-4, 1e-4, &port(0.0, 0.0, 4.0), energy);
        let paid = energy / (4.0 * limit.brake / 1e-3);
        assert!((reference - paid).abs() < 1e-15, "{reference} {paid}");
        let mut with = self::limit(false, 0.03);
        assert_eq!(with.follow(1e-4, 1e-4, &port(0.0, 0.0, -4.0), energy), 1e-4, "along the force it costs nothing");
    }

    #[test]
    fn over_a_delay_a_retreat_costs_energy_only_where_the_tissue_pulls() {
        let energy = 1e-6;
        let retreat = |force| {
            let mut limit = limit(false, 0.03);
            (limit.follow(-1e-4, -1e-4, &port(0.0, 0.0, force), energy), energy / (4.0 * limit.brake / 1e-3))
        };
        assert_eq!(retreat(4.0).0, -1e-4);
        let (reference, paid) = retreat(-4.0);
        assert!((reference + paid).abs() < 1e-15, "{reference} {paid}");
    }

    #[test]
    fn the_committed_energy_is_the_work_of_the_remaining_travel() {
        use crate::plant::{ControlTiming, SlaveParameters, SlaveStep};
        let step = SlaveStep::new(&SlaveParameters::default(), ControlTiming::Continuous, 1e-3).expect("valid");
        let mut limit = limit(true, f64::INFINITY);
        let advance = |state: [f64; 3], reference: f64| -> [f64; 3] {
            std::array::from_fn(|i| {
                (0..3).map(|j| step.transition[i][j] * state[j]).sum::<f64>() + step.reference[i] * reference
            })
        };
        let mut state = [0.0; 3];
        for tick in 0..60 {
            let target = 4e-5 * f64::from(tick) + 1e-3 * (0.3 * f64::from(tick)).sin();
            let reference = limit.follow(target, target, &port(state[0], state[1], 2.0), 100.0);
            // The command acts for one tick, then the brake.
            let mut braked = advance(state, reference);
            for _ in 0..3000 {
                braked = advance(braked, (braked[0] - limit.brake * braked[1]) / limit.gain);
            }
            let travel = braked[0] - state[0];
            let work = 2.0 * travel + 0.5 * STIFFNESS_N_PER_M * travel * travel;
            assert!(
                (limit.committed_j - work.max(0.0)).abs() < 1e-7,
                "{tick}: {} instead of {work}",
                limit.committed_j
            );
            state = advance(state, reference);
        }
    }
}
