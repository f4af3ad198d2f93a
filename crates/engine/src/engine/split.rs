use super::exact::ForceColumn;
use super::{ExactPlants, IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::plant::{MasterStep, SLAVE_STATES, SlaveStep};
use trocar_core::lane::Lane;

/// For the fraction `f` of each tick, the plants hold the last inputs, then the present ones:
///
/// ```text
/// x_{k+1} = Φ x_k + Γ(T) u_{k-1} + Γ((1-f) T) (u_k - u_{k-1}),   Γ(τ) = ∫₀^τ exp(A s) ds B
/// ```
/// The slave's deflection is not sent: `u` excludes it, and `-Γ(T) d_k` is added.
#[derive(Debug, Clone)]
pub struct FractionalDelayPlants<L> {
    exact: ExactPlants<L>,
    late_force: ForceColumn<L>,
    late_reference: [L; SLAVE_STATES],
    force_n: L,
    reference_m: L,
}

impl<L: Lane> FractionalDelayPlants<L> {
    /// `master` and `slave` are the steps after the arrival.
    pub fn new(exact: ExactPlants<L>, master: &MasterStep, slave: &SlaveStep, reference_m: f64) -> Self {
        Self {
            exact,
            late_force: ForceColumn::of(master),
            late_reference: slave.reference.map(L::splat),
            force_n: L::zero(),
            reference_m: L::splat(reference_m),
        }
    }
}

impl<L: Lane> Plants<L> for FractionalDelayPlants<L> {
    #[inline(always)]
    fn master(&self) -> MasterOutput<L> {
        self.exact.master()
    }

    #[inline(always)]
    fn slave(&self) -> SlaveOutput<L> {
        self.exact.slave()
    }

    #[inline(always)]
    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        force: TissueForce<L>,
    ) -> Result<(), IntegrationError> {
        self.exact.step(desired, desired_next, self.force_n, self.reference_m, deflection, force)?;
        self.exact.add_force(&self.late_force, feedback - self.force_n);
        self.exact.add_reference(&self.late_reference, reference - self.reference_m);
        (self.force_n, self.reference_m) = (feedback, reference);
        Ok(())
    }
}
