use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// `s_k = |(ΔK_k / K_1, ΔB_k / B_1)|`, dimensionless: `H_k` (eq. 25) relative to a rupture's (Barbé et al. 2006).
///
/// The paper does not say how eq. 26 combines the components; with the length, each can raise the alarm alone.
#[derive(Debug, Clone)]
pub struct ParameterChange<L> {
    /// In m/N and m/(N·s).
    scale: [L; 2],
}

impl<L: Lane> BuiltIn for ParameterChange<L> {
    const UNIT: &'static str = "1";

    fn tuning(_hypotheses: &Hypotheses) -> (f64, f64) {
        // A correction by a hypothesis has the distance 1.
        (0.5, 0.5)
    }

    fn new(settings: &DistanceSettings, _tick_s: f64) -> Self {
        let h = &settings.hypotheses;
        Self { scale: [h.stiffness_change_n_per_m, h.damping_change_n_s_per_m].map(|change| L::splat(1.0 / change)) }
    }
}

impl<L: Lane> Distance<L> for ParameterChange<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        let stiffness = input.correction[0] * self.scale[0];
        let damping = input.correction[1] * self.scale[1];
        (stiffness * stiffness + damping * damping).sqrt()
    }
}

crate::lane::gather!(ParameterChange { scale } stored);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::QUIET;
    use super::*;

    /// The distance of corrections under hypotheses of 10 N/m and 4 N·s/m.
    fn of(correction: [f64; 2]) -> f64 {
        let hypotheses =
            Hypotheses { stiffness_change_n_per_m: 10.0, damping_change_n_s_per_m: 4.0, ..Hypotheses::DEFAULT };
        let settings = DistanceSettings { hypotheses, ..DistanceSettings::DEFAULT };
        ParameterChange::<f64>::new(&settings, 1e-3).update(&DetectorInput { correction, ..QUIET })
    }

    #[test]
    fn the_distance_is_the_length_of_the_vector_of_relative_corrections() {
        let close = |correction, length: f64| assert!((of(correction) - length).abs() < 1e-12, "{correction:?}");
        close([-30.0, 0.0], 3.0);
        close([0.0, 8.0], 2.0);
        close([-30.0, 16.0], 5.0);
        close([0.0, 0.0], 0.0);
    }

    #[test]
    fn the_distance_does_not_depend_on_the_units_of_the_parameters() {
        let in_mm =
            Hypotheses { stiffness_change_n_per_m: 10.0e-3, damping_change_n_s_per_m: 4.0e-3, ..Hypotheses::DEFAULT };
        let settings = DistanceSettings { hypotheses: in_mm, ..DistanceSettings::DEFAULT };
        let mut change = ParameterChange::<f64>::new(&settings, 1e-3);
        let same = change.update(&DetectorInput { correction: [7.0e-3, -3.0e-3], ..QUIET });
        assert!((same - of([7.0, -3.0])).abs() < 1e-12, "{same}");
    }

    #[test]
    fn a_correction_by_one_hypothesis_adds_the_threshold() {
        let (threshold, drift) = ParameterChange::<f64>::tuning(&Hypotheses::DEFAULT);
        for correction in [[10.0, 0.0], [0.0, -4.0]] {
            assert!((of(correction) - drift - threshold).abs() < 1e-12, "{correction:?}");
        }
    }
}
