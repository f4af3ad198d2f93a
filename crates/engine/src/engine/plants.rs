//! The interface of the two machines to the engine.

use thiserror::Error;

use trocar_core::lane::Lane;

/// The integrator failed, for example because the run diverges.
#[derive(Debug, Error)]
#[error("the numerical integration failed within a tick: {0}; use simulation.engine = \"exact\"")]
pub struct IntegrationError(#[from] super::integrator::Failure);

/// The outputs of the master side at a tick.
#[derive(Debug, Clone, Copy)]
pub struct MasterOutput<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// The outputs of the slave side at a tick.
#[derive(Debug, Clone, Copy)]
pub struct SlaveOutput<L> {
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
}

/// The tissue's force over a tick, positive when it resists insertion.
#[derive(Debug, Clone, Copy)]
pub struct TissueForce<L> {
    /// The true force on the needle in N, which acts on a slave with a load.
    pub on_needle_n: L,
    /// The reading of the force sensor in N, for a controller that uses it.
    pub measured_n: L,
}

impl<L: Lane> TissueForce<L> {
    /// No force.
    #[inline(always)]
    #[must_use]
    pub fn zero() -> Self {
        Self { on_needle_n: L::zero(), measured_n: L::zero() }
    }
}

/// The two machines with their controllers, stepped from tick to tick.
pub trait Plants<L> {
    /// The present outputs of the master side.
    fn master(&self) -> MasterOutput<L>;
    /// The present outputs of the slave side.
    fn slave(&self) -> SlaveOutput<L>;
    /// Steps to the next tick. The desired position is linear from `desired` to `desired_next` (m); the feedback force
    /// (N) and the slave's reference (m) are held. The tissue deflects the slave from its reference by `deflection` (m)
    /// for the whole tick. The tissue's force is held; the slave of the appendix does not use it.
    ///
    /// # Errors
    /// [`IntegrationError`] if a numerical integrator fails.
    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        force: TissueForce<L>,
    ) -> Result<(), IntegrationError>;
}

impl<L, P: Plants<L> + ?Sized> Plants<L> for Box<P> {
    fn master(&self) -> MasterOutput<L> {
        (**self).master()
    }

    fn slave(&self) -> SlaveOutput<L> {
        (**self).slave()
    }

    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        force: TissueForce<L>,
    ) -> Result<(), IntegrationError> {
        (**self).step(desired, desired_next, feedback, reference, deflection, force)
    }
}
