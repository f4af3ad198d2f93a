//! The change of the estimated stiffness (eq. 26).

use super::super::Evidence;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// Magnitude of the stiffness component of `H_k` in N/m: the earlier proposal of Barbé et al. (2006).
#[derive(Debug, Clone)]
pub struct ParameterChange<L>(core::marker::PhantomData<L>);

impl<L: Lane> BuiltIn for ParameterChange<L> {
    const UNIT: &'static str = "N/m";

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        let half = hypotheses.stiffness_change_n_per_m / 2.0;
        (half, half)
    }

    fn new(_settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self(core::marker::PhantomData)
    }
}

impl<L: Lane> Distance<L> for ParameterChange<L> {
    #[inline(always)]
    fn update(&mut self, evidence: &Evidence<L>) -> L {
        evidence.correction[0].abs()
    }
}

crate::lane::gather_nothing!(ParameterChange);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::QUIET;
    use super::*;

    #[test]
    fn it_is_the_magnitude_of_the_correction_of_the_stiffness_alone() {
        let mut change = ParameterChange::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        let mut of = |correction| change.update(&Evidence { correction, ..QUIET });
        assert_eq!([of([-30.0, 4.0]), of([12.0, -50.0]), of([0.0, 7.0])], [30.0, 12.0, 0.0]);
    }
}
