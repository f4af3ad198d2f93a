use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings, square};
use crate::lane::Lane;

/// `s = ln(σ_0/σ_1) + (1/σ_0² - 1/σ_1²) e²/2`, dimensionless (eq. 23).
#[derive(Debug, Clone)]
pub struct VarianceChange<L> {
    scale: L,
    offset: L,
}

impl<L: Lane> BuiltIn for VarianceChange<L> {
    const UNIT: &'static str = "1";

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        let (quiet, changed) = (square(hypotheses.quiet_std_n), square(hypotheses.rupture_std_n));
        (libm::log(hypotheses.quiet_std_n / hypotheses.rupture_std_n) + (changed / quiet - 1.0) / 2.0, 0.0)
    }

    fn new(settings: &DistanceSettings, _tick_s: f64) -> Self {
        let h = &settings.hypotheses;
        let (quiet, changed) = (square(h.quiet_std_n), square(h.rupture_std_n));
        Self {
            scale: L::splat((1.0 / quiet - 1.0 / changed) / 2.0),
            offset: L::splat(libm::log(h.quiet_std_n / h.rupture_std_n)),
        }
    }
}

impl<L: Lane> Distance<L> for VarianceChange<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        self.scale * (input.residual_n * input.residual_n) + self.offset
    }
}

crate::lane::gather!(VarianceChange { scale, offset } stored);
