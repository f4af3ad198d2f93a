//! Passivity observer and controller in the time domain, at both ports.

use super::meter::Meter;
use super::{PassivitySettings, SlavePort};
use crate::lane::Lane;

/// After Hannaford and Ryu (2002, *Time-domain passivity control of haptic interfaces*), with the energies of the two
/// directions observed apart, so that it holds with a delay (Ryu, Artigas and Preusche 2010).
///
/// ```text
/// master   E_out(t) - E_pc(t) <= E_in of the slave, as it has arrived, + budget, else F_ed += α v_h
/// slave    E_out(t)           <= E_in of the master, as it has arrived, + budget, else the reference waits
/// ```
/// with `α` such that the excess is gone within a tick, as far as the damping limit lets it.
#[derive(Debug, Clone)]
pub(in crate::teleoperation) struct TimeDomain<L> {
    budget: L,
    max_damping: L,
    inverse_tick: L,
    meter: Meter<L>,
    master_in: L,
    master_out: L,
    slave_in: L,
    slave_out: L,
    /// As they have arrived at the other side.
    known_master_in: L,
    known_slave_in: L,
    law_force: L,
    added_force: L,
    /// Energy dissipated at the master in J.
    pub(in crate::teleoperation) dissipated_j: L,
}

impl<L: Lane> TimeDomain<L> {
    pub(in crate::teleoperation) fn new(settings: &PassivitySettings, tick_s: f64, reference: L) -> Self {
        let zero = L::zero();
        Self {
            budget: L::splat(settings.budget_j),
            max_damping: L::splat(settings.damping_limit_n_s_per_m),
            inverse_tick: L::splat(1.0 / tick_s),
            meter: Meter::new(settings.catch_up_speed_m_per_s, tick_s, reference),
            master_in: zero,
            master_out: zero,
            slave_in: zero,
            slave_out: zero,
            known_master_in: zero,
            known_slave_in: zero,
            law_force: zero,
            added_force: zero,
            dissipated_j: zero,
        }
    }

    /// The master has moved by `displacement` (m) since the last tick; gives what to send.
    #[inline(always)]
    pub(in crate::teleoperation) fn master_moved(&mut self, displacement: L) -> L {
        let zero = L::zero();
        let work = self.law_force * displacement;
        self.master_in = self.master_in + work.max(zero);
        self.master_out = self.master_out + (-work).max(zero);
        self.dissipated_j = self.dissipated_j + self.added_force * displacement;
        self.master_in
    }

    /// The slave's reference, given what the master has sent.
    #[inline(always)]
    pub(in crate::teleoperation) fn meter(&mut self, target: L, energy: L, port: &SlavePort<L>) -> L {
        self.known_master_in = self.known_master_in.max(energy);
        self.slave_out = self.slave_out + port.work_j.max(L::zero());
        self.slave_in = self.slave_in + (-port.work_j).max(L::zero());
        let left = self.known_master_in + self.budget - self.slave_out;
        self.meter.follow(target, port.scaled_force, left)
    }

    /// What the slave sends.
    #[inline(always)]
    pub(in crate::teleoperation) fn slave_sends(&self) -> L {
        self.slave_in
    }

    /// The force to feed back, given what the slave has sent.
    #[inline(always)]
    pub(in crate::teleoperation) fn limit(&mut self, force: L, energy: L, velocity: L) -> L {
        let zero = L::zero();
        self.known_slave_in = self.known_slave_in.max(energy);
        let left = self.known_slave_in + self.budget + self.dissipated_j - self.master_out;
        let power = velocity * velocity;
        let moves = power.gt(zero);
        let wanted = (-left).max(zero) * self.inverse_tick / L::select(moves, power, L::splat(1.0));
        let damping = L::select(moves, wanted.min(self.max_damping), zero);
        self.law_force = force;
        self.added_force = damping * velocity;
        force + self.added_force
    }

    /// Work that was refused at the slave in J.
    #[inline(always)]
    pub(in crate::teleoperation) fn refused_j(&self) -> L {
        self.meter.refused_j
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
    known_master_in,
    known_slave_in,
    law_force,
    added_force,
    dissipated_j,
});
