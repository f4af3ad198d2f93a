//! An energy tank on each side.

use super::meter::Meter;
use super::{BuiltInScheme, PassivityScheme, SchemeContext, SlavePort};
use crate::lane::Lane;
use crate::teleoperation::{CatchUpSettings, DampingSettings, PassivitySettings};
use trocar_core::settings::Key;

trocar_core::settings! {
    /// The tanks' own settings.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TankSettings in "passivity." {
        /// Desired level of each tank (energy-tank).
        tank_level_j: f64 [POSITIVE] = 0.02,
        /// Fraction of its energy that a tank sends to the other each tick, below 1 (energy-tank).
        tank_share: f64 [POSITIVE_SHARE] = 0.01,
    }
    where tank_share: |s| s.tank_share < 1.0, "above 0 and below 1";
}

/// Capacity of a tank as a multiple of its level; the excess is discarded.
const MAX_LEVELS: f64 = 10.0;

/// After Franken, Stramigioli, Misra, Secchi and Macchelli (2011, *Bilateral telemanipulation with time delays: a
/// two-layer approach combining passivity and transparency*): the transparency layer sets the command, the passivity
/// layer limits it to the energy in the side's tank.
///
/// ```text
/// H_m += F_ed Δx_h + received - sent      F_ed = F + d v_h,  d = limit · max(1 - H_m / level, 0)
///                                         |F| <= H_m / |T v_h| where it drives the hand
/// H_s -= f_e Δx_e - received + sent       H_s limits the steps of the reference
/// ```
/// At each tick each tank sends a fraction of its energy, as a running total, so that a lost sample loses no energy.
#[derive(Debug, Clone)]
pub struct Tank<L> {
    inverse_level: L,
    max: L,
    share: L,
    max_damping: L,
    tick_s: L,
    meter: Meter<L>,
    master: L,
    slave: L,
    master_sent: L,
    slave_sent: L,
    master_received: L,
    slave_received: L,
    fed_back: L,
    /// The passivity layer's change of the force command, in N.
    changed: L,
    /// Energy in J that the damping took from the hand for the tank, or that was withheld from the hand.
    dissipated_j: L,
}

impl<L: Lane> PassivityScheme<L> for Tank<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> L {
        self.master = self.master + self.fed_back * displacement_m;
        self.dissipated_j = self.dissipated_j + self.changed * displacement_m;
        self.master = self.master.min(self.max);
        let sent = self.share * self.master.max(L::zero());
        self.master = self.master - sent;
        self.master_sent = self.master_sent + sent;
        self.master_sent
    }

    #[inline(always)]
    fn limit_reference(&mut self, target_m: L, energy: L, port: &SlavePort<L>) -> L {
        self.slave = self.slave + (energy - self.slave_received) - port.work_j;
        self.slave_received = energy;
        self.slave = self.slave.min(self.max);
        self.meter.follow(target_m, port.cost_j_per_m, self.slave)
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> L {
        let sent = self.share * self.slave.max(L::zero());
        self.slave = self.slave - sent;
        self.slave_sent = self.slave_sent + sent;
        self.slave_sent
    }

    #[inline(always)]
    fn limit_force(&mut self, force: L, energy: L, velocity: L) -> L {
        let zero = L::zero();
        self.master = self.master + (energy - self.master_received);
        self.master_received = energy;
        let drives_hand = (force * velocity).lt(zero);
        let travel = (self.tick_s * velocity).abs();
        let max_n = self.master.max(zero) / L::select(drives_hand, travel, L::splat(1.0));
        let limited = L::select(drives_hand, force.clamp(-max_n, max_n), force);
        let damping = self.max_damping * (L::splat(1.0) - self.master * self.inverse_level).clamp(zero, L::splat(1.0));
        self.fed_back = limited + damping * velocity;
        self.changed = self.fed_back - force;
        self.fed_back
    }

    fn dissipated_j(&self) -> L {
        self.dissipated_j
    }

    fn refused_j(&self) -> L {
        self.meter.refused_j
    }
}

impl<L: Lane> BuiltInScheme<L> for Tank<L> {
    const KEYS: &'static [&'static [Key]] = &[TankSettings::KEYS, DampingSettings::KEYS, CatchUpSettings::KEYS];

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Option<Self> {
        let (numbers, zero) = (&settings.tank, L::zero());
        let level = L::splat(numbers.tank_level_j);
        Some(Self {
            inverse_level: L::splat(1.0 / numbers.tank_level_j),
            max: L::splat(MAX_LEVELS * numbers.tank_level_j),
            share: L::splat(numbers.tank_share),
            max_damping: L::splat(settings.damping.damping_limit_n_s_per_m),
            tick_s: L::splat(context.tick_s),
            meter: Meter::new(settings.catch_up.catch_up_speed_m_per_s, context.tick_s, context.reference_m),
            master: level,
            slave: level,
            master_sent: zero,
            slave_sent: zero,
            master_received: zero,
            slave_received: zero,
            fed_back: zero,
            changed: zero,
            dissipated_j: zero,
        })
    }
}

crate::lane::gather!(Tank {
    inverse_level,
    max,
    share,
    max_damping,
    tick_s,
    meter,
    master,
    slave,
    master_sent,
    slave_sent,
    master_received,
    slave_received,
    fed_back,
    changed,
    dissipated_j,
});
