use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// `s_k = e_k²` in N², the paper's choice (4.4.3).
#[derive(Debug, Clone)]
pub struct SquaredResidual<L>(core::marker::PhantomData<L>);

impl<L> SquaredResidual<L> {
    /// Needs no settings.
    #[must_use]
    pub const fn new() -> Self {
        Self(core::marker::PhantomData)
    }
}

impl<L> Default for SquaredResidual<L> {
    fn default() -> Self {
        Self::new()
    }
}

impl<L: Lane> BuiltIn for SquaredResidual<L> {
    const UNIT: &'static str = "N²";

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        hypotheses.squared_tuning()
    }

    fn new(_settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self(core::marker::PhantomData)
    }
}

impl<L: Lane> Distance<L> for SquaredResidual<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        input.residual_n * input.residual_n
    }
}

crate::lane::gather_nothing!(SquaredResidual);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::with_residual;
    use super::*;

    #[test]
    fn the_distance_is_the_square_of_a_residual_of_either_sign() {
        assert_eq!(
            [-0.5, 0.5, 0.0, -2.0].map(|e| SquaredResidual::new().update(&with_residual(e))),
            [0.25, 0.25, 0.0, 4.0]
        );
    }
}
