//! The plants with samples that arrive between ticks, with an exact step.

use super::exact::ForceColumn;
use super::{ExactPlants, IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::plant::{MasterStep, SLAVE_STATES, SlaveStep};
use trocar_core::lane::Lane;

/// Both plants with a fractional delay (0.7 of a delay of 3.7 ticks): for the first part of each tick they hold the
/// last tick's feedback force and reference, then the present ones.
///
/// The machines are linear, so a late sample adds the effect of its difference to the previous sample over the rest of
/// the tick:
///
/// ```text
/// x_{k+1} = Φ x_k + Γ(T) u_{k-1} + Γ((1-f) T) (u_k - u_{k-1}),   Γ(τ) = ∫₀^τ exp(A s) ds B
/// ```
///
/// The slave's deflection by the tissue is not sent: the slave's `u` excludes it, and `-Γ(T) d_k` is added.
#[derive(Debug, Clone)]
pub struct FractionalDelayPlants<L> {
    exact: ExactPlants<L>,
    late_force: ForceColumn<L>,
    late_reference: [L; SLAVE_STATES],
    force_n: L,
    reference_m: L,
}

impl<L: Lane> FractionalDelayPlants<L> {
    /// Creates plants at rest without a feedback force. `master` and `slave` are the steps over the rest of a tick
    /// after the arrival.
    #[must_use]
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
