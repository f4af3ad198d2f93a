use super::sides::Sides;
use super::{Payload, SchemeContext, SlavePort};
use crate::teleoperation::PassivitySettings;
use trocar_core::lane::Lane;

/// In a payload: running total of the sent energy.
pub(super) const ENERGY: usize = 0;
/// In a payload: running total of the demanded energy.
pub(super) const DEMAND: usize = 3;
/// In a payload: feedback force over the last tick.
pub(super) const FELT: usize = 1;

/// Share of the spare energy sent each tick.
const SHARE: f64 = 0.005;

/// An account on each side, with the level `budget_j` at the start:
///
/// ```text
/// short   = level - A                    shortage of a side; the slave's includes the energy for its way to the hand
/// open    = max(short of the other - in transit to it, 0)
/// sent   += max(A - level, 0) + max(open - short, 0) / 2
/// d       = limit · max(short of the master, open) / level    damping of the hand, at most the limit
/// ```
/// Demands are running totals (received energy plus shortage), so no energy is sent twice. A wrong shortage cannot
/// break the promise.
#[derive(Debug, Clone)]
pub(super) struct Budget<L> {
    pub(super) sides: Sides<L>,
    kept: L,
    share: L,
    counts_under_way: bool,
    open_at_master: L,
    open_at_slave: L,
}

impl<L: Lane> Budget<L> {
    pub(super) fn new(settings: &PassivitySettings, context: &SchemeContext<L>, speed_m_per_s: f64) -> Self {
        let level_j = settings.budget.budget_j;
        Self {
            sides: Sides::new(settings, context, level_j, speed_m_per_s),
            kept: L::splat(if context.is_immediate { 0.0 } else { level_j }),
            share: L::splat(SHARE),
            counts_under_way: true,
            open_at_master: L::zero(),
            open_at_slave: L::zero(),
        }
    }

    pub(super) fn without_energy_under_way(self) -> Self {
        Self { counts_under_way: false, ..self }
    }

    #[inline(always)]
    fn sent_j(&self, account_j: L, needed_j: L, open_j: L) -> L {
        let zero = L::zero();
        let over = (account_j - self.kept.max(needed_j)).max(zero);
        let spare = (account_j - over - needed_j).max(zero);
        let even = L::splat(0.5) * (open_j - (self.sides.wanted - account_j)).max(zero);
        let max = if self.counts_under_way { (spare - self.sides.reserve).max(zero) } else { self.share * spare };
        over + even.min(max)
    }

    #[inline(always)]
    pub(super) fn master_sends(&mut self, displacement_m: L) -> (L, L) {
        self.sides.master_moves(displacement_m);
        let demand = self.sides.master.demand(self.sides.wanted, self.counts_under_way);
        // Only a driving force needs the reserve.
        let needed = self.sides.reserve.min(self.kept);
        let sent = self.sent_j(self.sides.master.energy_j, needed, self.open_at_master);
        (self.sides.master.send(sent), demand)
    }

    #[inline(always)]
    pub(super) fn slave_receives(&mut self, payload: &Payload<L>, port: &SlavePort<L>) {
        self.sides.slave_receives(payload[ENERGY], port);
        self.open_at_slave = self.sides.slave.open(payload[DEMAND], self.counts_under_way);
    }

    #[inline(always)]
    pub(super) fn slave_sends(&mut self) -> (L, L) {
        let Sides { wanted, reserve, reference, slave, .. } = &self.sides;
        let demand = slave.demand(*wanted + reference.missing_j, self.counts_under_way);
        let needed = reference.committed_j + *reserve;
        let sent = self.sent_j(slave.energy_j, needed, self.open_at_slave);
        (self.sides.slave.send(sent), demand)
    }

    #[inline(always)]
    pub(super) fn master_receives(&mut self, force_n: L, payload: &Payload<L>) {
        self.sides.master_receives(force_n, payload[ENERGY]);
        self.open_at_master = self.sides.master.open(payload[DEMAND], self.counts_under_way);
    }

    #[inline(always)]
    pub(super) fn limit_force(&mut self, command_n: L, velocity_m_per_s: L) -> L {
        self.sides.limit_force(command_n, velocity_m_per_s, self.open_at_master)
    }
}

trocar_core::lane::gather!(Budget { sides, kept, share, open_at_master, open_at_slave } same { counts_under_way });

#[cfg(test)]
mod tests {
    use super::*;

    fn budget(is_immediate: bool) -> Budget<f64> {
        let context = SchemeContext { is_immediate, ..SchemeContext::<f64>::for_tests() };
        Budget::new(&PassivitySettings::DEFAULT, &context, 0.03)
    }

    fn port(work_j: f64) -> SlavePort<f64> {
        SlavePort { force_n: 0.0, cost_j_per_m: 0.0, work_j, position_m: 0.0, velocity_m_per_s: 0.0 }
    }

    fn payload(energy_j: f64, demand_j: f64) -> Payload<f64> {
        let mut payload = [0.0; 4];
        (payload[ENERGY], payload[DEMAND]) = (energy_j, demand_j);
        payload
    }

    fn assert_close(value: (f64, f64), expected: (f64, f64)) {
        assert!((value.0 - expected.0).abs() < 1e-15 && (value.1 - expected.1).abs() < 1e-15, "{value:?} {expected:?}");
    }

    #[test]
    fn the_excess_over_the_level_is_sent_at_once_and_half_of_it_again() {
        let mut budget = budget(false);
        budget.sides.force.force_n = 3.0;
        // 3 N over 1 mm are 3 mJ above the level of 10 mJ: the shortage is -3 mJ. Nothing is demanded, so (0 - short) /
        // 2 more.
        assert_close(budget.master_sends(1e-3), (4.5e-3, -3e-3));
        assert!((budget.sides.master.energy_j - 8.5e-3).abs() < 1e-15);
    }

    #[test]
    fn a_side_that_demands_energy_gets_half_of_its_additional_shortage() {
        let mut budget = budget(false);
        // The slave has demanded 4 mJ, of which nothing is in transit.
        budget.master_receives(0.0, &payload(0.0, 4e-3));
        assert_close(budget.master_sends(0.0), (2e-3, 0.0));
        // 2 mJ are in transit: the slave demands 2 mJ more, and the master also lacks 2 mJ.
        budget.master_receives(0.0, &payload(0.0, 4e-3));
        assert_close(budget.master_sends(0.0), (2e-3, 2e-3));
    }

    #[test]
    fn a_side_keeps_its_reserve() {
        let mut budget = budget(false);
        budget.sides.master.energy_j = 4.5e-3;
        budget.master_receives(0.0, &payload(0.0, 0.1));
        // The reserve is kept twice: for the known need, and for unforeseen needs.
        assert_close(budget.master_sends(0.0), (0.5e-3, 5.5e-3));
    }

    #[test]
    fn without_counting_energy_in_transit_a_share_is_sent_each_tick() {
        let mut budget = budget(false).without_energy_under_way();
        budget.master_receives(0.0, &payload(0.0, 0.1));
        // 0.5 % of the energy above the reserve.
        assert_close(budget.master_sends(0.0), (0.005 * 8e-3, 0.0));
    }

    #[test]
    fn the_slave_demands_the_way_to_the_hand_and_keeps_what_its_command_may_take() {
        let mut budget = budget(false);
        budget.slave_receives(&payload(1e-3, 2e-3), &port(4e-3));
        assert!((budget.sides.slave.energy_j - 7e-3).abs() < 1e-15);
        budget.sides.reference.missing_j = 5e-3;
        budget.sides.reference.committed_j = 3e-3;
        // Received 1, short 3, and 5 for the way to the hand. The slave lacks 3 and the master only 2: nothing is
        // evened out.
        assert_close(budget.slave_sends(), (0.0, 9e-3));
        budget.slave_receives(&payload(1e-3, 8e-3), &port(0.0));
        // 5 of 7 are needed, which includes the reserve of 2, and the reserve is kept again: nothing to spare.
        assert_close(budget.slave_sends(), (0.0, 9e-3));
        budget.sides.reference.committed_j = 0.0;
        // Half of 8 - 3 would even it out.
        assert_close(budget.slave_sends(), (2.5e-3, 9e-3));
    }

    #[test]
    fn without_a_delay_all_but_the_reserve_is_sent() {
        let mut budget = budget(true);
        let (sent, _) = budget.master_sends(0.0);
        // The need of a force that drives the hand counts only with a level that is kept.
        assert!((sent - 0.01).abs() < 1e-15, "{sent}");
        let (sent, _) = budget.slave_sends();
        assert!((sent - 8e-3).abs() < 1e-15, "the slave keeps its reserve: {sent}");
    }

    #[test]
    fn unpaid_energy_damps_the_hand() {
        let mut budget = budget(false);
        budget.sides.force.show(10.0);
        budget.master_receives(0.0, &payload(0.0, 5e-3));
        let damping = PassivitySettings::DEFAULT.damping.damping_limit_n_s_per_m;
        assert!((budget.limit_force(1.0, 0.02) - (1.0 + 0.5 * damping * 0.02)).abs() < 1e-12);
    }
}
