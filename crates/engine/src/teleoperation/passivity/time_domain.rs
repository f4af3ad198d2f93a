use super::budget::{Budget, DEMAND, ENERGY, FELT};
use super::hand_yield::HandYield;
use super::{Arrived, BuiltInScheme, PAYLOAD, PassivityScheme, Payload, SchemeContext, SchemeEnergies, SlavePort};
use crate::teleoperation::{BudgetSettings, CatchUpSettings, DampingSettings, PassivitySettings};
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

/// Observer and controller (Hannaford and Ryu 2002) on each side of a delayed link (Ryu et al. 2010):
/// `E_m - E_s >= -2 budget_j` for any tissue up to `max_stiffness_n_per_m`.
///
/// Against drift (Chawda et al. 2014, Coelho et al. 2018), a slave that was held back catches up while its account
/// allows it, and damping of a moving hand pays the shortage.
#[derive(Debug, Clone)]
pub struct TimeDomain<L> {
    budget: Budget<L>,
    hand: HandYield<L>,
}

impl<L: Lane> PassivityScheme<L> for TimeDomain<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        (payload[ENERGY], payload[DEMAND]) = self.budget.master_sends(displacement_m);
        payload[FELT] = self.budget.sides.force.force_n;
        payload
    }

    #[inline(always)]
    fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
        self.budget.slave_receives(&arrived.payload, port);
        position_m - self.hand.update(port.force_n, arrived.payload[FELT])
    }

    #[inline(always)]
    fn limit_reference(&mut self, target_m: L, port: &SlavePort<L>) -> L {
        self.budget.sides.limit_reference(target_m, target_m, port)
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        (payload[ENERGY], payload[DEMAND]) = self.budget.slave_sends();
        payload
    }

    #[inline(always)]
    fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, _velocity_m_per_s: L) -> L {
        self.budget.master_receives(force_n, &arrived.payload);
        force_n
    }

    #[inline(always)]
    fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
        self.budget.limit_force(force_n, velocity_m_per_s)
    }

    fn peer_restarts(&mut self) {
        self.budget.sides.peer_restarts();
    }

    fn energies(&self) -> SchemeEnergies<L> {
        self.budget.sides.energies()
    }
}

impl<L: Lane> BuiltInScheme<L> for TimeDomain<L> {
    const KEYS: &'static [&'static [Key]] = &[BudgetSettings::KEYS, DampingSettings::KEYS, CatchUpSettings::KEYS];

    fn held_dampings(settings: &PassivitySettings) -> [Option<(&'static str, f64)>; 2] {
        [Some(settings.damping.with_key()), None]
    }

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Self {
        Self {
            budget: Budget::new(settings, context, settings.catch_up.catch_up_speed_m_per_s),
            hand: HandYield::new(context),
        }
    }
}

trocar_core::lane::gather!(TimeDomain { budget, hand });
