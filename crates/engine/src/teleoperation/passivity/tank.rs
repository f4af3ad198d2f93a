use super::account::Account;
use super::budget::{ENERGY, FELT};
use super::hand_yield::HandYield;
use super::sides::Sides;
use super::{Arrived, BuiltInScheme, PAYLOAD, PassivityScheme, Payload, SchemeContext, SchemeEnergies, SlavePort};
use crate::teleoperation::{CatchUpSettings, DampingSettings, PassivitySettings};
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TankSettings in "passivity." {
        /// Desired level of each tank (energy-tank).
        tank_level_j: f64 [POSITIVE] = 0.02,
        /// Fraction of its energy that a tank sends to the other each tick, below 1 (energy-tank).
        tank_share: f64 [POSITIVE_SHARE] = 0.01,
    }
    where tank_share: |s| s.tank_share < 1.0, "above 0 and below 1";
}

/// Capacity of a tank as a multiple of its level.
const MAX_LEVELS: f64 = 10.0;

/// Limits the command to the energy in the tank (Franken et al. 2011):
///
/// ```text
/// H_m += F_ed Δx_h + received - sent      F_ed = F + d v_h,  d = limit · max(1 - H_m / level, 0)
/// H_s -= f_e Δx_e - received + sent       H_s limits the steps of the reference
/// E_m - E_s >= -2 tank_level_j            at every tick
/// ```
/// A tank pays for the motion to which a command commits the slave: the promise holds at the physical ports.
#[derive(Debug, Clone)]
pub struct Tank<L> {
    sides: Sides<L>,
    kept: L,
    max: L,
    share: L,
    hand: HandYield<L>,
}

impl<L: Lane> Tank<L> {
    #[inline(always)]
    fn share(tank: &mut Account<L>, max: L, share: L, kept_j: L) -> L {
        tank.energy_j = tank.energy_j.min(max);
        tank.send(share * (tank.energy_j - kept_j).max(L::zero()))
    }
}

impl<L: Lane> PassivityScheme<L> for Tank<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        self.sides.master_moves(displacement_m);
        payload[ENERGY] = Self::share(&mut self.sides.master, self.max, self.share, L::zero());
        payload[FELT] = self.sides.force.force_n;
        payload
    }

    #[inline(always)]
    fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
        self.sides.slave_receives(arrived.payload[ENERGY], port);
        position_m - self.hand.update(port.force_n, arrived.payload[FELT])
    }

    #[inline(always)]
    fn limit_reference(&mut self, target_m: L, port: &SlavePort<L>) -> L {
        self.sides.slave.energy_j = self.sides.slave.energy_j.min(self.max);
        self.sides.limit_reference(target_m, target_m, port)
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        let kept_j = self.kept + self.sides.reference.committed_j;
        payload[ENERGY] = Self::share(&mut self.sides.slave, self.max, self.share, kept_j);
        payload
    }

    #[inline(always)]
    fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, _velocity_m_per_s: L) -> L {
        self.sides.master_receives(force_n, arrived.payload[ENERGY]);
        force_n
    }

    #[inline(always)]
    fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
        self.sides.limit_force(force_n, velocity_m_per_s, L::zero())
    }

    fn peer_restarts(&mut self) {
        self.sides.peer_restarts();
    }

    fn energies(&self) -> SchemeEnergies<L> {
        self.sides.energies()
    }
}

impl<L: Lane> BuiltInScheme<L> for Tank<L> {
    const KEYS: &'static [&'static [Key]] = &[TankSettings::KEYS, DampingSettings::KEYS, CatchUpSettings::KEYS];

    fn held_dampings(settings: &PassivitySettings) -> [Option<(&'static str, f64)>; 2] {
        [Some(settings.damping.with_key()), None]
    }

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Self {
        let TankSettings { tank_level_j, tank_share } = settings.tank;
        let sides = Sides::new(settings, context, tank_level_j, settings.catch_up.catch_up_speed_m_per_s);
        let (kept, share) = if context.is_immediate { (sides.reserve, 1.0) } else { (L::zero(), tank_share) };
        Self {
            sides,
            kept,
            max: L::splat(MAX_LEVELS * tank_level_j),
            share: L::splat(share),
            hand: HandYield::new(context),
        }
    }
}

trocar_core::lane::gather!(Tank { sides, kept, max, share, hand });
