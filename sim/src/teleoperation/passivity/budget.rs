//! The energy budget of the schemes that pass on what they receive.

use super::account::Account;
use super::force_limit::ForceLimit;
use super::reference_limit::ReferenceLimit;
use super::{Payload, RESERVE, SchemeContext, SchemeEnergies, SlavePort};
use crate::lane::Lane;
use crate::teleoperation::PassivitySettings;

/// Where a payload holds the running total of the energy sent.
pub(super) const ENERGY: usize = 0;
/// Where a payload of the budget holds the running total of the energy that a side asks for.
pub(super) const DEMAND: usize = 3;
/// Where the master's payload holds the feedback force over the last tick.
pub(super) const FELT: usize = 1;

/// The share of what a side can spare that it sends each tick where energy under way does not count: within 0.2 s at a tick of
/// 1 ms.
const SHARE: f64 = 0.005;

/// An account on each side, both with the level `budget_j` at the start, and the limits that keep them above 0:
///
/// ```text
/// short   = level - A                    what a side lacks; the slave also lacks the energy for its way to the hand
/// open    = max(short of the other - under way to it, 0)
/// sent   += max(A - level, 0)            what exceeds the level goes to the other side at once,
///         + max(open - short, 0) / 2     and the rest so that both lack the same
/// d       = limit · max(short of the master, open) / level    damping of the hand, at most the limit
/// ```
/// A side sends its shortage as a running total of what it asks for: what it has received and its shortage. So energy under way
/// is known to the sender, and is not sent twice: while the hand pays for what the needle spends, it is not damped,
/// however long the energy takes to arrive. It is damped for what nobody has paid, so that the operator pays for a motion that
/// costs energy, such as a withdrawal against friction. A shortage only sets damping and sharing: a wrong one cannot break the
/// promise.
///
/// Without a delay each side sends all that it has at each tick, so that the two accounts are one. The hand is damped only over
/// the fifth of `E_0` above what is kept back.
#[derive(Debug, Clone)]
pub(super) struct Budget<L> {
    promised: L,
    /// What a side keeps when it sends what exceeds it, and what it wants: with less it is short.
    kept: L,
    wanted: L,
    inverse_wanted: L,
    reserve: L,
    share: L,
    counts_under_way: bool,
    max_damping: L,
    master: Account<L>,
    slave: Account<L>,
    pub(super) force: ForceLimit<L>,
    pub(super) reference: ReferenceLimit<L>,
    /// What the slave asks of the master and the master of the slave, beyond what is under way, in J.
    open_at_master: L,
    open_at_slave: L,
}

impl<L: Lane> Budget<L> {
    /// A budget whose reference catches up with its target at a speed (m/s).
    pub(super) fn new(settings: &PassivitySettings, context: &SchemeContext<L>, speed_m_per_s: f64) -> Self {
        let level_j = settings.budget.budget_j;
        let reserve_j = RESERVE * level_j;
        let (kept_j, wanted_j) = if context.is_immediate { (0.0, 2.0 * reserve_j) } else { (level_j, level_j) };
        let account = Account::new(L::splat(level_j));
        let stiffness = settings.catch_up.max_stiffness_n_per_m;
        Self {
            promised: L::splat(2.0 * level_j),
            kept: L::splat(kept_j),
            wanted: L::splat(wanted_j),
            inverse_wanted: L::splat(1.0 / wanted_j),
            reserve: L::splat(reserve_j),
            share: L::splat(SHARE),
            counts_under_way: true,
            max_damping: L::splat(settings.damping.damping_limit_n_s_per_m),
            master: account.clone(),
            slave: account,
            force: ForceLimit::new(context),
            reference: ReferenceLimit::new(context, stiffness, speed_m_per_s),
            open_at_master: L::zero(),
            open_at_slave: L::zero(),
        }
    }

    /// This budget, with a hand that is damped as if no energy were under way, and accounts that are evened out slowly.
    pub(super) fn without_energy_under_way(self) -> Self {
        Self { counts_under_way: false, ..self }
    }

    /// The energies of a scheme with these accounts.
    pub(super) fn energies(&self) -> SchemeEnergies<L> {
        SchemeEnergies {
            promised_j: Some(self.promised),
            dissipated_j: self.force.dissipated_j,
            refused_j: self.reference.refused_j,
        }
    }

    /// What a side sends of an account, of which it needs `needed_j`, to a side that asks for `open_j` (J).
    #[inline(always)]
    fn sent_j(&self, account_j: L, needed_j: L, open_j: L) -> L {
        let zero = L::zero();
        let over = (account_j - self.kept.max(needed_j)).max(zero);
        let spare = (account_j - over - needed_j).max(zero);
        let even = L::splat(0.5) * (open_j - (self.wanted - account_j)).max(zero);
        let max = if self.counts_under_way { (spare - self.reserve).max(zero) } else { self.share * spare };
        over + even.min(max)
    }

    /// What the master sends, after a displacement (m): the running totals of its energy and of what it asks for.
    #[inline(always)]
    pub(super) fn master_sends(&mut self, displacement_m: L) -> (L, L) {
        self.master.add(self.force.work_j(displacement_m));
        let demand = self.master.demand(self.wanted, self.counts_under_way);
        // A force that resists the hand needs nothing: the reserve is for one that drives it.
        let needed = self.reserve.min(self.kept);
        let sent = self.sent_j(self.master.energy_j, needed, self.open_at_master);
        (self.master.send(sent), demand)
    }

    /// What the slave receives, and the work of its port.
    #[inline(always)]
    pub(super) fn slave_receives(&mut self, payload: &Payload<L>, port: &SlavePort<L>) {
        self.slave.receive(payload[ENERGY]);
        self.slave.add(-port.work_j);
        self.open_at_slave = self.slave.open(payload[DEMAND], self.counts_under_way);
    }

    /// The slave's reference for a target, for a hand at `hand_m` on the slave's scale (m).
    #[inline(always)]
    pub(super) fn limit_reference(&mut self, target_m: L, hand_m: L, port: &SlavePort<L>) -> L {
        self.reference.follow(target_m, hand_m, port, self.slave.energy_j - self.reserve)
    }

    /// What the slave sends: the running totals of its energy and of what it asks for.
    #[inline(always)]
    pub(super) fn slave_sends(&mut self) -> (L, L) {
        let demand = self.slave.demand(self.wanted + self.reference.missing_j, self.counts_under_way);
        // What the last command may still take stays here.
        let needed = self.reference.committed_j + self.reserve;
        let sent = self.sent_j(self.slave.energy_j, needed, self.open_at_slave);
        (self.slave.send(sent), demand)
    }

    /// What the master receives besides the tissue force (N).
    #[inline(always)]
    pub(super) fn master_receives(&mut self, force_n: L, payload: &Payload<L>) {
        self.force.show(force_n);
        self.master.receive(payload[ENERGY]);
        self.open_at_master = self.master.open(payload[DEMAND], self.counts_under_way);
    }

    /// The feedback force for a command (N).
    #[inline(always)]
    pub(super) fn limit_force(&mut self, command_n: L, velocity: L) -> L {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let own = one - self.master.energy_j * self.inverse_wanted;
        let damping = self.max_damping * own.max(self.open_at_master * self.inverse_wanted).clamp(zero, one);
        self.force.limit(command_n, damping, velocity, self.master.energy_j - self.reserve)
    }
}

crate::lane::gather!(Budget {
    promised,
    kept,
    wanted,
    inverse_wanted,
    reserve,
    share,
    max_damping,
    master,
    slave,
    force,
    reference,
    open_at_master,
    open_at_slave,
} same { counts_under_way });
