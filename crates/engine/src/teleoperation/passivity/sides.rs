use super::account::Account;
use super::force_limit::ForceLimit;
use super::reference_limit::ReferenceLimit;
use super::{RESERVE, SchemeContext, SchemeEnergies, SlavePort};
use crate::teleoperation::PassivitySettings;
use trocar_core::lane::Lane;

/// Damping of the hand while an account is short: `d = limit · max(short / wanted)`, at most the limit.
#[derive(Debug, Clone)]
pub(super) struct Sides<L> {
    promised: L,
    /// Without a delay, the fifth of `E_0` above the reserve.
    pub(super) wanted: L,
    inverse_wanted: L,
    pub(super) reserve: L,
    max_damping: L,
    pub(super) master: Account<L>,
    pub(super) slave: Account<L>,
    pub(super) force: ForceLimit<L>,
    pub(super) reference: ReferenceLimit<L>,
}

impl<L: Lane> Sides<L> {
    pub(super) fn new(
        settings: &PassivitySettings,
        context: &SchemeContext<L>,
        level_j: f64,
        speed_m_per_s: f64,
    ) -> Self {
        let reserve_j = RESERVE * level_j;
        let wanted_j = if context.is_immediate { 2.0 * reserve_j } else { level_j };
        let account = Account::new(L::splat(level_j));
        Self {
            promised: L::splat(2.0 * level_j),
            wanted: L::splat(wanted_j),
            inverse_wanted: L::splat(1.0 / wanted_j),
            reserve: L::splat(reserve_j),
            max_damping: L::splat(settings.damping.damping_limit_n_s_per_m),
            master: account.clone(),
            slave: account,
            force: ForceLimit::new(context),
            reference: ReferenceLimit::new(context, settings.catch_up.max_stiffness_n_per_m, speed_m_per_s),
        }
    }

    pub(super) fn energies(&self) -> SchemeEnergies<L> {
        SchemeEnergies {
            promised_j: Some(self.promised),
            dissipated_j: self.force.dissipated_j,
            refused_j: self.reference.refused_j,
        }
    }

    pub(super) fn peer_restarts(&mut self) {
        let level = L::splat(0.5) * self.promised;
        self.master.peer_restarts(level);
        self.slave.peer_restarts(level);
    }

    #[inline(always)]
    pub(super) fn master_moves(&mut self, displacement_m: L) {
        self.master.add(self.force.work_j(displacement_m));
    }

    #[inline(always)]
    pub(super) fn slave_receives(&mut self, total_j: L, port: &SlavePort<L>) {
        self.slave.receive(total_j);
        self.slave.add(-port.work_j);
    }

    #[inline(always)]
    pub(super) fn master_receives(&mut self, force_n: L, total_j: L) {
        self.force.show(force_n);
        self.master.receive(total_j);
    }

    #[inline(always)]
    pub(super) fn limit_reference(&mut self, target_m: L, hand_m: L, port: &SlavePort<L>) -> L {
        self.reference.follow(target_m, hand_m, port, self.slave.energy_j - self.reserve)
    }

    #[inline(always)]
    pub(super) fn limit_force(&mut self, command_n: L, velocity_m_per_s: L, unpaid_j: L) -> L {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let from_energy = one - self.master.energy_j * self.inverse_wanted;
        let damping = self.max_damping * from_energy.max(unpaid_j * self.inverse_wanted).clamp(zero, one);
        self.force.limit(command_n, damping, velocity_m_per_s, self.master.energy_j - self.reserve)
    }
}

trocar_core::lane::gather!(Sides {
    promised,
    wanted,
    inverse_wanted,
    reserve,
    max_damping,
    master,
    slave,
    force,
    reference
});

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(is_immediate: bool) -> Sides<f64> {
        let context = SchemeContext { is_immediate, ..SchemeContext::<f64>::for_tests() };
        let mut settings = PassivitySettings::DEFAULT;
        settings.damping.damping_limit_n_s_per_m = 40.0;
        Sides::new(&settings, &context, 0.01, 0.03)
    }

    #[test]
    fn both_accounts_begin_with_the_level_and_promise_their_sum() {
        let sides = sides(false);
        assert_eq!(
            (sides.master.energy_j, sides.slave.energy_j, sides.energies().promised_j),
            (0.01, 0.01, Some(0.02))
        );
        assert_eq!(sides.reserve, 0.002);
        assert_eq!((sides.wanted, self::sides(true).wanted), (0.01, 0.004), "two fifths without a delay");
    }

    #[test]
    fn work_and_received_energy_enter_the_accounts() {
        let mut sides = sides(false);
        let port = SlavePort { force_n: 0.0, cost_j_per_m: 0.0, work_j: 0.004, position_m: 0.0, velocity_m_per_s: 0.0 };
        sides.slave_receives(0.003, &port);
        assert!((sides.slave.energy_j - 0.009).abs() < 1e-15, "the needle's work is spent");
        sides.force.force_n = 2.0;
        sides.master_moves(0.001);
        assert!((sides.master.energy_j - 0.012).abs() < 1e-15, "the hand's work is received");
        sides.master_receives(1.5, 0.005);
        assert!((sides.master.energy_j - 0.017).abs() < 1e-15);
    }

    #[test]
    fn the_hand_is_damped_by_the_larger_shortage_up_to_the_limit() {
        // The received tissue force is 10 N, so only the damping limits the force.
        let force = |master_j: f64, unpaid_j: f64| {
            let mut sides = sides(false);
            sides.force.show(10.0);
            sides.master.energy_j = master_j;
            sides.limit_force(1.0, 0.05, unpaid_j)
        };
        assert_eq!(force(0.01, 0.0), 1.0, "nothing is short");
        assert!((force(0.0075, 0.0) - (1.0 + 0.25 * 40.0 * 0.05)).abs() < 1e-12, "a quarter is short at the master");
        assert!((force(0.0075, 0.005) - (1.0 + 0.5 * 40.0 * 0.05)).abs() < 1e-12, "a half is unpaid at the slave");
        assert!((force(0.02, 0.05) - (1.0 + 40.0 * 0.05)).abs() < 1e-12, "at most the limit");
    }
}
