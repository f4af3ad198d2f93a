use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings, square};
use crate::lane::Lane;

/// `s = m_1/σ_0² (e - m_1/2)`, dimensionless (eq. 22).
#[derive(Debug, Clone)]
pub struct MeanChange<L> {
    scale: L,
    offset: L,
}

impl<L: Lane> BuiltIn for MeanChange<L> {
    const UNIT: &'static str = "1";
    const IS_ONE_SIDED: bool = true;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        (square(hypotheses.rupture_mean_n) / (2.0 * square(hypotheses.quiet_std_n)), 0.0)
    }

    fn new(settings: &DistanceSettings, _tick_s: f64) -> Self {
        let h = &settings.hypotheses;
        let quiet = square(h.quiet_std_n);
        Self { scale: L::splat(h.rupture_mean_n / quiet), offset: L::splat(-square(h.rupture_mean_n) / (2.0 * quiet)) }
    }
}

impl<L: Lane> Distance<L> for MeanChange<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        self.scale * input.residual_n + self.offset
    }
}

crate::lane::gather!(MeanChange { scale, offset } stored);
