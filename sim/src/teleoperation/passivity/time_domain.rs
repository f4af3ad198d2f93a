//! Passivity observer and controller in the time domain, at both ports.

use super::meter::Meter;
use super::{BuiltInScheme, PassivityScheme, SchemeContext, SlavePort};
use crate::lane::Lane;
use crate::teleoperation::{CatchUpSettings, DampingSettings, PassivitySettings};
use trocar_core::settings::Key;

trocar_core::settings! {
    /// The scheme's own settings.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TimeDomainSettings in "passivity." {
        /// Energy that each port may deliver before it receives any (time-domain).
        budget_j: f64 [NON_NEGATIVE] = 5e-3,
    }
}

/// After Hannaford and Ryu (2002, *Time-domain passivity control of haptic interfaces*), with a separate energy
/// observer per direction, so that it is valid under delay (Ryu, Artigas and Preusche 2010).
///
/// ```text
/// master   E_out(t) - E_pc(t) <= E_in of the slave, as received, + budget, else F_ed += α v_h
/// slave    E_out(t)           <= E_in of the master, as received, + budget, else the reference stops
/// ```
/// `α` removes the excess within a tick, up to the damping limit.
#[derive(Debug, Clone)]
pub struct TimeDomain<L> {
    budget: L,
    max_damping: L,
    inverse_tick: L,
    meter: Meter<L>,
    master_in: L,
    master_out: L,
    slave_in: L,
    slave_out: L,
    /// The totals as received by the other side.
    received_master_in: L,
    received_slave_in: L,
    law_force: L,
    added_force: L,
    dissipated_j: L,
}

impl<L: Lane> PassivityScheme<L> for TimeDomain<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> L {
        let zero = L::zero();
        let work = self.law_force * displacement_m;
        self.master_in = self.master_in + work.max(zero);
        self.master_out = self.master_out + (-work).max(zero);
        self.dissipated_j = self.dissipated_j + self.added_force * displacement_m;
        self.master_in
    }

    #[inline(always)]
    fn limit_reference(&mut self, target_m: L, energy: L, port: &SlavePort<L>) -> L {
        self.received_master_in = self.received_master_in.max(energy);
        self.slave_out = self.slave_out + port.work_j.max(L::zero());
        self.slave_in = self.slave_in + (-port.work_j).max(L::zero());
        let left = self.received_master_in + self.budget - self.slave_out;
        self.meter.follow(target_m, port.cost_j_per_m, left)
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> L {
        self.slave_in
    }

    #[inline(always)]
    fn limit_force(&mut self, force: L, energy: L, velocity: L) -> L {
        let zero = L::zero();
        self.received_slave_in = self.received_slave_in.max(energy);
        let left = self.received_slave_in + self.budget + self.dissipated_j - self.master_out;
        let power = velocity * velocity;
        let moves = power.gt(zero);
        let needed = (-left).max(zero) * self.inverse_tick / L::select(moves, power, L::splat(1.0));
        let damping = L::select(moves, needed.min(self.max_damping), zero);
        self.law_force = force;
        self.added_force = damping * velocity;
        force + self.added_force
    }

    fn dissipated_j(&self) -> L {
        self.dissipated_j
    }

    fn refused_j(&self) -> L {
        self.meter.refused_j
    }
}

impl<L: Lane> BuiltInScheme<L> for TimeDomain<L> {
    const KEYS: &'static [&'static [Key]] = &[TimeDomainSettings::KEYS, DampingSettings::KEYS, CatchUpSettings::KEYS];

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Option<Self> {
        let zero = L::zero();
        Some(Self {
            budget: L::splat(settings.time_domain.budget_j),
            max_damping: L::splat(settings.damping.damping_limit_n_s_per_m),
            inverse_tick: L::splat(1.0 / context.tick_s),
            meter: Meter::new(settings.catch_up.catch_up_speed_m_per_s, context.tick_s, context.reference_m),
            master_in: zero,
            master_out: zero,
            slave_in: zero,
            slave_out: zero,
            received_master_in: zero,
            received_slave_in: zero,
            law_force: zero,
            added_force: zero,
            dissipated_j: zero,
        })
    }
}

crate::lane::gather!(TimeDomain {
    budget,
    max_damping,
    inverse_tick,
    meter,
    master_in,
    master_out,
    slave_in,
    slave_out,
    received_master_in,
    received_slave_in,
    law_force,
    added_force,
    dissipated_j,
});
