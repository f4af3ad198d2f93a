use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

/// A weight of 0.2 at 1 kHz.
const MEMORY_S: f64 = 4.5e-3;

/// `s_k = (y_k - m_k)²` in N² for a force below the earlier samples' exponential average `m_k`, else 0.
#[derive(Debug, Clone)]
pub struct MovingAverage<L> {
    average: L,
    share: L,
    started: bool,
}

impl<L: Lane> BuiltIn for MovingAverage<L> {
    const UNIT: &'static str = "N²";
    const IS_BASELINE: bool = true;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        hypotheses.squared_tuning()
    }

    fn new(_settings: &DistanceSettings, tick_s: f64) -> Self {
        Self { average: L::zero(), share: L::splat(-libm::expm1(-tick_s / MEMORY_S)), started: false }
    }
}

impl<L: Lane> Distance<L> for MovingAverage<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        if !self.started {
            self.started = true;
            self.average = input.force_n;
        }
        let excess = input.force_n - self.average;
        self.average = self.average + self.share * excess;
        let fall = excess.min(L::zero());
        fall * fall
    }
}

crate::lane::gather!(MovingAverage { average, share } same { started } stored);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::with_force;
    use super::*;

    #[test]
    fn after_a_step_down_the_fall_decays_with_the_memory() {
        for tick_s in [5e-4, 1e-3, 2e-3] {
            let mut average = MovingAverage::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
            for _ in 0..100 {
                assert_eq!(average.update(&with_force(3.0)), 0.0);
            }
            for k in 0..20 {
                let fall = 0.5 * (-f64::from(k) * tick_s / MEMORY_S).exp();
                let distance = average.update(&with_force(2.5));
                assert!((distance - fall * fall).abs() < 1e-12, "{k}: {distance}");
            }
        }
    }

    #[test]
    fn a_rise_has_distance_0() {
        let mut average = MovingAverage::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        assert!((0..50).all(|k| average.update(&with_force(0.1 * f64::from(k))) == 0.0));
    }
}
