use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::settings::{Arms, Delays, PopulationSettings, Tissues};
use trocar_base::quantiles::{normal_quantile, normal_share};

/// The grip, the five parameters of the arm, stiffness and damping of the tissue, and the delay.
pub const DIMENSIONS: usize = 9;

/// Standard deviations at which the log-normal distribution is truncated.
const MAX_DEVIATIONS: f64 = 3.0;

/// One arm, tissue and link, relative to the scenario's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draw {
    /// Factors of `k_a`, `b_a`, `k_h`, `b_h` and `m_h`.
    pub arm: [f64; 5],
    pub stiffness: f64,
    pub damping: f64,
    /// Each direction in s; `None` for the scenario's.
    pub delay_s: Option<f64>,
}

fn between((low, high): (f64, f64), coordinate: f64) -> f64 {
    (low * libm::pow(high / low, coordinate)).clamp(low, high)
}

/// A quantile of a log-normal distribution with median 1, truncated at three standard deviations: 68 % lie within the
/// factor `spread` up or down. `coordinate` is from 0 to 1.
pub fn log_normal(spread: f64, coordinate: f64) -> f64 {
    let (low, high) = (normal_share(-MAX_DEVIATIONS), normal_share(MAX_DEVIATIONS));
    let deviations = normal_quantile(low + coordinate * (high - low)).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS);
    libm::pow(spread, deviations)
}

impl PopulationSettings {
    /// Members are uniformly distributed on the unit cube. The coordinates have the order of [`DIMENSIONS`]; those that
    /// are not drawn are ignored.
    pub fn at(&self, point: &[f64; DIMENSIONS]) -> Draw {
        let arm = match self.arms {
            Arms::None => [1.0; 5],
            Arms::People(people) => {
                let grip = between((people.grip_min, people.grip_max), point[0]);
                let by_grip = [grip, grip.sqrt(), grip, grip.sqrt(), 1.0];
                let person = |k: usize| between((1.0 / people.person_spread, people.person_spread), point[1 + k]);
                std::array::from_fn(|k| by_grip[k] * person(k))
            }
        };
        let (stiffness, damping) = match self.tissues {
            Tissues::None => (1.0, 1.0),
            Tissues::LogNormal(spread) => {
                (log_normal(spread.stiffness_spread, point[6]), log_normal(spread.damping_spread, point[7]))
            }
        };
        let delay_s = match self.delays {
            Delays::None => None,
            Delays::Uniform(range) => Some(range.delay_min_s + point[8] * (range.delay_max_s - range.delay_min_s)),
        };
        Draw { arm, stiffness, damping, delay_s }
    }

    /// Returns true for each coordinate of [`PopulationSettings::at`] that has an effect.
    pub fn is_drawn(&self) -> [bool; DIMENSIONS] {
        let (arm, tissue) = (self.arms != Arms::None, self.tissues != Tissues::None);
        [arm, arm, arm, arm, arm, arm, tissue, tissue, self.delays != Delays::None]
    }

    /// The arm does not depend on the other drawn quantities.
    pub fn drawn(&self, seed: u64, index: u64) -> Draw {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let mut point = [0.0; DIMENSIONS];
        point.fill_with(|| rng.random());
        self.at(&point)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DelayRange, PeopleSettings, TissueSpread};
    use super::*;

    fn everything() -> PopulationSettings {
        PopulationSettings {
            arms: Arms::People(PeopleSettings::DEFAULT),
            tissues: Tissues::LogNormal(TissueSpread::DEFAULT),
            delays: Delays::Uniform(DelayRange::DEFAULT),
            ..PopulationSettings::DEFAULT
        }
    }

    #[test]
    fn the_corners_of_the_cube_are_the_ends_of_the_ranges() {
        let population = everything();
        let (low, high) = (population.at(&[0.0; DIMENSIONS]), population.at(&[1.0; DIMENSIONS]));
        assert_eq!((low.delay_s, high.delay_s), (Some(0.0), Some(0.04)));
        for (k, by_grip) in [2.0, 2.0_f64.sqrt(), 2.0, 2.0_f64.sqrt(), 1.0].into_iter().enumerate() {
            assert!(
                (high.arm[k] / (1.3 * by_grip) - 1.0).abs() < 1e-12 && (low.arm[k] * high.arm[k] - 1.0).abs() < 1e-12
            );
        }
        let cut = 1.25_f64.powi(3);
        assert!((high.stiffness / cut - 1.0).abs() < 1e-9 && (low.damping * cut - 1.0).abs() < 1e-9);
        let fixed = PopulationSettings::DEFAULT;
        let scenario = Draw { arm: [1.0; 5], stiffness: 1.0, damping: 1.0, delay_s: None };
        assert!(!fixed.varies() && fixed.at(&[0.7; DIMENSIONS]) == scenario);
    }

    #[test]
    fn oracle_the_draws_have_the_moments_of_their_distributions() {
        let population = everything();
        let draws: Vec<Draw> = (0..4000).map(|index| population.drawn(7, index)).collect();
        let moments = |of: &dyn Fn(&Draw) -> f64| {
            let n = draws.len() as f64;
            let mean = draws.iter().map(of).sum::<f64>() / n;
            (mean, (draws.iter().map(|draw| (of(draw) - mean).powi(2)).sum::<f64>() / n).sqrt())
        };
        // The standard deviation of a uniform distribution is its width divided by √12. The logarithm of k_a is the sum
        // of two uniform numbers.
        let uniform = |width: f64| width / 12.0_f64.sqrt();
        let expected = [
            (moments(&|draw| draw.delay_s.expect("drawn")), 0.02, uniform(0.04)),
            (moments(&|draw| draw.arm[4].ln()), 0.0, uniform(2.0 * 1.3_f64.ln())),
            (moments(&|draw| draw.arm[0].ln()), 0.0, uniform(4.0_f64.ln()).hypot(uniform(2.0 * 1.3_f64.ln()))),
            // Truncation at three standard deviations reduces a normal distribution's standard deviation to 0.9866 of
            // it.
            (moments(&|draw| draw.stiffness.ln()), 0.0, 0.98658 * 1.25_f64.ln()),
        ];
        for ((mean, deviation), of_mean, of_deviation) in expected {
            assert!((mean - of_mean).abs() < 4.0 * of_deviation / 4000.0_f64.sqrt(), "{mean} {of_mean}");
            assert!((deviation / of_deviation - 1.0).abs() < 0.05, "{deviation} {of_deviation}");
        }
    }

    #[test]
    fn an_arm_does_not_depend_on_the_other_draws() {
        let people = PopulationSettings { tissues: Tissues::None, delays: Delays::None, ..everything() };
        for index in 0..5 {
            assert_eq!(people.drawn(1, index).arm, everything().drawn(1, index).arm);
            assert_ne!(people.drawn(1, index).arm, people.drawn(2, index).arm);
        }
    }
}
