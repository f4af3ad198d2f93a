use thiserror::Error;

use trocar_core::lane::Lane;

#[derive(Debug, Error)]
#[error("the numerical integration failed within a tick: {0}; use simulation.engine = \"exact\"")]
pub struct IntegrationError(#[from] super::integrator::Failure);

#[derive(Debug, Clone, Copy)]
pub struct MasterOutput<L> {
    /// `x_h`.
    pub position_m: L,
    /// `v_h`.
    pub velocity_m_per_s: L,
    /// `F_h`.
    pub hand_force_n: L,
}

#[derive(Debug, Clone, Copy)]
pub struct SlaveOutput<L> {
    /// `x_e`.
    pub position_m: L,
    /// `v_e`.
    pub velocity_m_per_s: L,
}

/// Positive when it resists insertion.
#[derive(Debug, Clone, Copy)]
pub struct TissueForce<L> {
    pub on_needle_n: L,
    pub measured_n: L,
}

impl<L: Lane> TissueForce<L> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { on_needle_n: L::zero(), measured_n: L::zero() }
    }
}

pub trait Plants<L> {
    fn master(&self) -> MasterOutput<L>;
    fn slave(&self) -> SlaveOutput<L>;
    /// Desired positions are linear over the tick; other inputs are held.
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
