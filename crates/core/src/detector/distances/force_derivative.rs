use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// `s_k = (y_k - y_{k-1})²` in N² (direct filtering, 4.1); 0 at the first sample.
#[derive(Debug, Clone)]
pub struct ForceDerivative<L> {
    last_force: L,
    started: bool,
}

impl<L: Lane> BuiltIn for ForceDerivative<L> {
    const UNIT: &'static str = "N²";
    const IS_BASELINE: bool = true;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        hypotheses.squared_tuning()
    }

    fn new(_settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self { last_force: L::zero(), started: false }
    }
}

impl<L: Lane> Distance<L> for ForceDerivative<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        if !self.started {
            self.started = true;
            self.last_force = input.force_n;
        }
        let change = input.force_n - self.last_force;
        self.last_force = input.force_n;
        change * change
    }
}

crate::lane::gather!(ForceDerivative { last_force } same { started } stored);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::with_force;
    use super::*;

    #[test]
    fn the_distance_is_the_square_of_the_change_and_0_at_the_first_sample() {
        let mut derivative = ForceDerivative::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        let distances = [3.0, 3.5, 1.5, 1.5].map(|force_n| derivative.update(&with_force(force_n)));
        assert_eq!(distances, [0.0, 0.25, 4.0, 0.0]);
    }
}
