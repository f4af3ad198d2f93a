//! Schemes that keep the link from making energy, whatever its delay.
//!
//! The two ports are where hand and tissue meet the teleoperator: `(F_ed, x_h)` on the master's side, `(f_e, x_e)` on the
//! slave's, with energy counted as it enters at the master and leaves at the slave. Displacements are used, not
//! velocities, so that a force held over a tick gives the integral of force times velocity exactly. Energies of the slave
//! are compared in the master's units: scaled by force scale over position scale.

mod meter;
mod tank;
mod time_domain;
mod waves;

pub(super) use tank::Tank;
pub(super) use time_domain::TimeDomain;
pub(super) use waves::Waves;

use crate::error::{InvalidValue, non_negative, positive, require};
use crate::lane::Lane;

/// Which scheme there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// None: samples are taken as they come.
    None,
    /// Observer and controller in the time domain at both ports.
    TimeDomain,
    /// Wave variables.
    WaveVariables,
    /// A tank of energy on each side, below whatever controller there is.
    EnergyTank,
}

/// The scheme and its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassivitySettings {
    /// Which scheme there is.
    pub scheme: Scheme,
    /// Energy that each port may give before it has received any, in J, at least 0 (time domain).
    pub budget_j: f64,
    /// Greatest damping that is added at the master in N·s/m, at least 0 (time domain and tank).
    pub damping_limit_n_s_per_m: f64,
    /// `b` in N·s/m, above 0 (waves).
    pub wave_impedance_n_s_per_m: f64,
    /// Level that each tank is kept at, in J, above 0 (tank).
    pub tank_level_j: f64,
    /// Share of its energy that a tank sends to the other each tick, above 0 and below 1 (tank).
    pub tank_share: f64,
    /// Speed at which a slave that was held back catches up, in m/s, above 0 (time domain and tank).
    pub catch_up_speed_m_per_s: f64,
}

impl PassivitySettings {
    /// No scheme, beside numbers for each that are chosen here.
    pub const NONE: Self = Self {
        scheme: Scheme::None,
        budget_j: 5e-3,
        damping_limit_n_s_per_m: 50.0,
        wave_impedance_n_s_per_m: 40.0,
        tank_level_j: 0.02,
        tank_share: 0.01,
        catch_up_speed_m_per_s: 0.03,
    };

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        non_negative("passivity.budget_j", self.budget_j)?;
        non_negative("passivity.damping_limit_n_s_per_m", self.damping_limit_n_s_per_m)?;
        positive("passivity.wave_impedance_n_s_per_m", self.wave_impedance_n_s_per_m)?;
        positive("passivity.tank_level_j", self.tank_level_j)?;
        positive("passivity.tank_share", self.tank_share)?;
        require("passivity.tank_share", self.tank_share, self.tank_share < 1.0, "above 0 and below 1")?;
        positive("passivity.catch_up_speed_m_per_s", self.catch_up_speed_m_per_s)?;
        Ok(())
    }
}

/// A port at which energy is counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Port<L> {
    force: L,
    position: L,
    /// Everything that has passed, in J.
    pub(super) energy_j: L,
}

impl<L: Lane> Port<L> {
    pub(super) fn at(position: L) -> Self {
        Self { force: L::zero(), position, energy_j: L::zero() }
    }

    /// Counts what a force that was held since the last tick has done, and gives how far it has moved since.
    #[inline(always)]
    pub(super) fn moved(&mut self, position: L) -> L {
        let displacement = position - self.position;
        self.position = position;
        self.energy_j = self.energy_j + self.force * displacement;
        displacement
    }

    /// The force to hold from now on.
    #[inline(always)]
    pub(super) fn hold(&mut self, force: L) {
        self.force = force;
    }

    /// What a force that went linearly with the position has done since the last tick.
    #[inline(always)]
    pub(super) fn pushed(&mut self, position: L, force: L) -> L {
        let work = L::splat(0.5) * (force + self.force) * (position - self.position);
        (self.position, self.force) = (position, force);
        self.energy_j = self.energy_j + work;
        work
    }
}

/// What the scheme at work knows of the slave's port at a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlavePort<L> {
    /// Measured force in the master's units of energy per m of the slave.
    pub(super) scaled_force: L,
    /// Work since the last tick in the same units.
    pub(super) work_j: L,
}

crate::lane::gather!(Port { force, position, energy_j });
