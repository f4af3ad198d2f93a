//! The interface of the two machines to the engine.

use thiserror::Error;

/// The integrator failed, for example because the run diverges.
#[derive(Debug, Error)]
#[error("the numerical integration failed within a tick: {0}; use simulation.engine = \"exact\"")]
pub struct IntegrationError(#[from] ode_solvers::dop_shared::IntegrationError);

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

/// The two machines with their controllers, stepped from tick to tick.
pub trait Plants<L> {
    /// The present outputs of the master side.
    fn master(&self) -> MasterOutput<L>;
    /// The present outputs of the slave side.
    fn slave(&self) -> SlaveOutput<L>;
    /// Steps to the next tick. The desired position is linear from `desired` to `desired_next` (m); the feedback force
    /// (N) and the slave's reference (m) are held. The tissue deflects the slave from its reference by `deflection` (m)
    /// for the whole tick.
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
    ) -> Result<(), IntegrationError> {
        (**self).step(desired, desired_next, feedback, reference, deflection)
    }
}
