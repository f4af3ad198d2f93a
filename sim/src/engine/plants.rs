//! What the engine asks of the two machines.

use thiserror::Error;

/// The integrator gave up, as it does where a run diverges.
#[derive(Debug, Error)]
#[error("the numerical integration gave up within a tick: {0}; use simulation.engine = \"exact\"")]
pub struct IntegrationError(#[from] ode_solvers::dop_shared::IntegrationError);

/// What the master side shows at a tick.
#[derive(Debug, Clone, Copy)]
pub struct MasterReading<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// What the slave side shows at a tick.
#[derive(Debug, Clone, Copy)]
pub struct SlaveReading<L> {
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
}

/// The two machines with their controllers, from tick to tick.
pub trait Plants<L> {
    /// The master side now.
    fn master(&self) -> MasterReading<L>;
    /// The slave side now.
    fn slave(&self) -> SlaveReading<L>;
    /// To the next tick: the desired position goes from `desired` to `desired_next` (m) in a straight line, the fed-back
    /// force (N) and the slave's reference (m) are held.
    ///
    /// # Errors
    /// [`IntegrationError`] where a numerical integrator gives up.
    fn step(&mut self, desired: L, desired_next: L, feedback: L, reference: L) -> Result<(), IntegrationError>;
}

impl<L, P: Plants<L> + ?Sized> Plants<L> for Box<P> {
    fn master(&self) -> MasterReading<L> {
        (**self).master()
    }

    fn slave(&self) -> SlaveReading<L> {
        (**self).slave()
    }

    fn step(&mut self, desired: L, desired_next: L, feedback: L, reference: L) -> Result<(), IntegrationError> {
        (**self).step(desired, desired_next, feedback, reference)
    }
}
