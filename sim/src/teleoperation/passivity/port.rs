//! A port at which energy is counted.

use crate::lane::Lane;

/// A port at which energy is counted.
#[derive(Debug, Clone, Copy)]
pub(in crate::teleoperation) struct Port<L> {
    force: L,
    position: L,
    /// Everything that has passed, in J.
    pub(in crate::teleoperation) energy_j: L,
}

impl<L: Lane> Port<L> {
    pub(in crate::teleoperation) fn at(position: L) -> Self {
        Self { force: L::zero(), position, energy_j: L::zero() }
    }

    /// Counts what a force that was held since the last tick has done, and gives how far it has moved since.
    #[inline(always)]
    pub(in crate::teleoperation) fn moved(&mut self, position: L) -> L {
        let displacement = position - self.position;
        self.position = position;
        self.energy_j = self.energy_j + self.force * displacement;
        displacement
    }

    /// The force to hold from now on.
    #[inline(always)]
    pub(in crate::teleoperation) fn hold(&mut self, force: L) {
        self.force = force;
    }

    /// What a force that went linearly with the position has done since the last tick.
    #[inline(always)]
    pub(in crate::teleoperation) fn pushed(&mut self, position: L, force: L) -> L {
        let work = L::splat(0.5) * (force + self.force) * (position - self.position);
        (self.position, self.force) = (position, force);
        self.energy_j = self.energy_j + work;
        work
    }
}

/// What a scheme knows of the slave's port at a tick.
#[derive(Debug, Clone, Copy)]
pub struct SlavePort<L> {
    /// Measured force scaled to the master, in N.
    pub force_n: L,
    /// What a metre of the slave costs against the measured force, in the master's units of energy: J/m.
    pub cost_j_per_m: L,
    /// Work since the last tick in the same units, in J.
    pub work_j: L,
}

crate::lane::gather!(Port { force, position, energy_j });
