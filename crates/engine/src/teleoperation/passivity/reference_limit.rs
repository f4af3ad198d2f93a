//! The slave's reference, limited so that the energy account pays for the motion.

use super::SchemeContext;
use super::port::SlavePort;
use trocar_core::lane::Lane;

/// Time constant in s with which a slave that was held back catches up, at no more than the catch-up speed.
const CATCH_UP_S: f64 = 0.2;

/// Follows a target at no more than the target's own speed and a catch-up speed, as far as the account pays for the
/// motion that the command commits the slave to.
///
/// With a force `f` and a tissue of stiffness up to `K`, a further travel `d` takes at most the work
///
/// ```text
/// W(d) = f d + K d² / 2 <= A    d in [(-f - √(f² + 2 K A)) / K, (-f + √(f² + 2 K A)) / K]
/// ```
/// and `d` is known from the command and the slave's state, the lag of the slave included
/// ([`SlaveMotion`](super::slave_motion::SlaveMotion)). A retreat that the tissue pays for is always possible.
///
/// Over a delayed link the reference also moves against the force only as fast as the account lasts for the time constant `β` of
/// the brake, `|f v| β <= A`: a slave that is short of energy slows down and does not run into its brake again and again.
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
    /// The slave's third state.
    state: L,
    target: L,
    reference: L,
    /// Maximum work in J of the motion to which the slave is committed: the account must keep it.
    pub(super) committed_j: L,
    /// Work in J that the way to the hand takes against the present force.
    pub(super) missing_j: L,
    /// `∫ f d(target - reference)` in J: the work withheld from the slave, less what was recovered.
    pub(super) refused_j: L,
}

impl<L: Lane> ReferenceLimit<L> {
    /// A limit for tissues up to a stiffness (N/m), with a catch-up speed (m/s).
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
            // At rest, so that the state relative to that at rest is 0.
            state: L::zero(),
            target: start,
            reference: start,
            committed_j: L::zero(),
            missing_j: L::zero(),
            refused_j: L::zero(),
        }
    }

    /// The reference for a target, with an energy (J) available, for a hand at `hand` (m, on the slave's scale).
    #[inline(always)]
    pub(super) fn follow(&mut self, target: L, hand: L, port: &SlavePort<L>, energy_j: L) -> L {
        let zero = L::zero();
        // As fast as the target, and the catch-up on top.
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
        // An unlimited reference is the target, bit for bit.
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
