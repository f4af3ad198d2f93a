//! The squared residual where the force is below the prediction.

use super::super::Evidence;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// `s_k = e_k²` in N² where `e_k < 0 < ŷ_k`, else 0: rises of the force neither add to the decision nor disarm the detector.
#[derive(Debug, Clone)]
pub struct SquaredDrop<L>(core::marker::PhantomData<L>);

impl<L: Lane> BuiltIn for SquaredDrop<L> {
    const UNIT: &'static str = "N²";

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        hypotheses.squared_tuning()
    }

    fn new(_settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self(core::marker::PhantomData)
    }
}

impl<L: Lane> Distance<L> for SquaredDrop<L> {
    #[inline(always)]
    fn update(&mut self, evidence: &Evidence<L>) -> L {
        let e = evidence.residual_n;
        let falls_short = e.lt(L::zero()) & evidence.predicted_force_n.gt(L::zero());
        L::select(falls_short, e * e, L::zero())
    }
}

crate::lane::gather_nothing!(SquaredDrop);
