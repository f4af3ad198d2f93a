//! The plants with samples that arrive between ticks, stepped exactly.

use super::exact::ForceColumn;
use super::{ExactPlants, IntegrationError, MasterReading, Plants, SlaveReading};
use crate::lane::Lane;
use crate::plant::{MasterStep, SLAVE_STATES, SlaveStep};

/// Both plants, holding the last tick's fed-back force and reference for a first part of each tick and the tick's own for
/// the rest: what a delay of 3.7 ticks does after its three whole ones.
///
/// The machines are linear, so a sample that arrives late adds what its difference to the one before it does over the
/// rest of the tick:
///
/// ```text
/// x_{k+1} = Φ x_k + Γ(T) u_{k-1} + Γ((1-f) T) (u_k - u_{k-1}),   Γ(τ) = ∫₀^τ exp(A s) ds B
/// ```
#[derive(Debug, Clone)]
pub struct FractionalDelayPlants<L> {
    exact: ExactPlants<L>,
    late_force: ForceColumn<L>,
    late_reference: [L; SLAVE_STATES],
    force_n: L,
    reference_m: L,
}

impl<L: Lane> FractionalDelayPlants<L> {
    /// Plants at rest without a fed-back force and under the reference `reference_m` (m); `master` and `slave` are the steps
    /// over what is left of a tick when the force or the reference arrives.
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
    fn master(&self) -> MasterReading<L> {
        self.exact.master()
    }

    #[inline(always)]
    fn slave(&self) -> SlaveReading<L> {
        self.exact.slave()
    }

    #[inline(always)]
    fn step(&mut self, desired: L, desired_next: L, feedback: L, reference: L) -> Result<(), IntegrationError> {
        self.exact.step(desired, desired_next, self.force_n, self.reference_m)?;
        self.exact.push(&self.late_force, feedback - self.force_n);
        self.exact.pull(&self.late_reference, reference - self.reference_m);
        (self.force_n, self.reference_m) = (feedback, reference);
        Ok(())
    }
}
