//! The energy budget of the schemes that pass on what they receive.

use super::account::Account;
use super::force_limit::ForceLimit;
use super::reference_limit::ReferenceLimit;
use super::{Payload, RESERVE, SchemeContext, SchemeEnergies, SlavePort};
use crate::lane::Lane;
use crate::teleoperation::PassivitySettings;

/// Where a payload holds the running total of the energy sent.
pub(super) const ENERGY: usize = 0;
/// Where the slave's payload holds its shortage.
pub(super) const SHORTAGE: usize = 3;
/// Where the master's payload holds the feedback force over the last tick.
pub(super) const FELT: usize = 3;

/// The share of what a side can spare below the level that it sends each tick, so that neither starves while the other has
/// energy: within 0.2 s at a tick of 1 ms.
const SHARE: f64 = 0.005;

/// An account on each side, both with the level `budget_j` at the start, and the limits that keep them above 0:
///
/// ```text
/// sent = max(A - level, 0)             what exceeds the level goes to the other side at once,
///      + share · what can be spared    and a share of the rest
/// d    = limit · max(1 - A / level)    damping of the hand while one of the two accounts is short
/// ```
/// A slave that is short of energy, for its level or for the way to the hand, tells the master, so that the operator pays for a motion that costs energy, such as a
/// withdrawal against friction. The shortage only sets the damping: a wrong one cannot break the promise.
#[derive(Debug, Clone)]
pub(super) struct Budget<L> {
    level: L,
    inverse_level: L,
    reserve: L,
    share: L,
    max_damping: L,
    master: Account<L>,
    slave: Account<L>,
    pub(super) force: ForceLimit<L>,
    pub(super) reference: ReferenceLimit<L>,
    /// The slave's shortage as it has arrived.
    shortage: L,
}

impl<L: Lane> Budget<L> {
    /// A budget whose reference catches up with its target at a speed (m/s).
    pub(super) fn new(settings: &PassivitySettings, context: &SchemeContext<L>, speed_m_per_s: f64) -> Self {
        let level_j = settings.budget.budget_j;
        let account = Account::new(L::splat(level_j));
        let stiffness = settings.catch_up.max_stiffness_n_per_m;
        Self {
            level: L::splat(level_j),
            inverse_level: L::splat(1.0 / level_j),
            reserve: L::splat(RESERVE * level_j),
            share: L::splat(SHARE),
            max_damping: L::splat(settings.damping.damping_limit_n_s_per_m),
            master: account.clone(),
            slave: account,
            force: ForceLimit::new(context),
            reference: ReferenceLimit::new(context, stiffness, speed_m_per_s),
            shortage: L::zero(),
        }
    }

    /// The energies of a scheme with these accounts.
    pub(super) fn energies(&self) -> SchemeEnergies<L> {
        SchemeEnergies {
            promised_j: Some(self.level + self.level),
            dissipated_j: self.force.dissipated_j,
            refused_j: self.reference.refused_j,
        }
    }

    /// The running total that the master sends, after a displacement (m).
    #[inline(always)]
    pub(super) fn master_sends(&mut self, displacement_m: L) -> L {
        self.master.add(self.force.work_j(displacement_m));
        let over = (self.master.energy_j - self.level).max(L::zero());
        let spare = (self.master.energy_j - over - self.reserve).max(L::zero());
        self.master.send(over + self.share * spare)
    }

    /// What the slave receives, and the work of its port.
    #[inline(always)]
    pub(super) fn slave_receives(&mut self, payload: &Payload<L>, port: &SlavePort<L>) {
        self.slave.receive(payload[ENERGY]);
        self.slave.add(-port.work_j);
    }

    /// The slave's reference for a target, for a hand at `hand_m` on the slave's scale (m).
    #[inline(always)]
    pub(super) fn limit_reference(&mut self, target_m: L, hand_m: L, port: &SlavePort<L>) -> L {
        self.reference.follow(target_m, hand_m, port, self.slave.energy_j - self.reserve)
    }

    /// The running total and the shortage that the slave sends.
    #[inline(always)]
    pub(super) fn slave_sends(&mut self) -> (L, L) {
        // What the last command may still take stays here.
        let needed = self.reference.committed_j + self.reserve;
        let over = (self.slave.energy_j - self.level.max(needed)).max(L::zero());
        let spare = (self.slave.energy_j - over - needed).max(L::zero());
        let total = self.slave.send(over + self.share * spare);
        (total, L::splat(1.0) - (self.slave.energy_j - self.reference.missing_j) * self.inverse_level)
    }

    /// What the master receives besides the tissue force (N).
    #[inline(always)]
    pub(super) fn master_receives(&mut self, force_n: L, payload: &Payload<L>) {
        self.force.show(force_n);
        self.master.receive(payload[ENERGY]);
        self.shortage = payload[SHORTAGE];
    }

    /// The feedback force for a command (N).
    #[inline(always)]
    pub(super) fn limit_force(&mut self, command_n: L, velocity: L) -> L {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let own = one - self.master.energy_j * self.inverse_level;
        let damping = self.max_damping * own.max(self.shortage).clamp(zero, one);
        self.force.limit(command_n, damping, velocity, self.master.energy_j - self.reserve)
    }
}

crate::lane::gather!(Budget {
    level,
    inverse_level,
    reserve,
    share,
    max_damping,
    master,
    slave,
    force,
    reference,
    shortage
});
