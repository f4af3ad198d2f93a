//! One detector at many thresholds, on the same samples.

use super::rungs::{RUNGS, ThresholdLanes};
use crate::detection::{CusumDetector, Detector, DetectorSettings, Evidence};
use crate::lane::{Lane, Mask};

/// A detector's thresholds, the others of its settings being the same.
///
/// The cap stands as many times above each threshold as the settings' own does above theirs. Each threshold is a lane of
/// [`Detector`] itself, so that arming, cap and reset are those of the real one, alarm for alarm.
#[derive(Debug, Clone)]
pub struct Ladder {
    settings: DetectorSettings,
    thresholds: Vec<f64>,
}

impl Ladder {
    /// From a hundredth to nearly a hundred times the settings' own threshold, which is among them, evenly on a logarithmic
    /// scale; at least two.
    #[must_use]
    pub fn around(settings: DetectorSettings, count: usize) -> Self {
        let middle = (count.max(2) / 2) as f64;
        let share = |k: usize| libm::pow(100.0, (k as f64 - middle) / middle);
        Self::new(settings, (0..count.max(2)).map(|k| settings.cusum.threshold * share(k)).collect())
    }

    /// At given thresholds, in the unit of the distance, each above 0.
    #[must_use]
    pub fn new(settings: DetectorSettings, thresholds: Vec<f64>) -> Self {
        Self { settings, thresholds }
    }

    /// The settings that it was made of.
    #[must_use]
    pub fn settings(&self) -> &DetectorSettings {
        &self.settings
    }

    /// The thresholds, in the unit of the distance.
    #[must_use]
    pub fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    /// The settings that the detector has at a threshold, by its index.
    #[must_use]
    pub fn settings_at(&self, rung: usize) -> DetectorSettings {
        let threshold = self.thresholds.get(rung).copied().unwrap_or(self.settings.cusum.threshold);
        let mut settings = self.settings;
        // The ratio of the default is 10, of which a division would leave only nearly 10.
        let usual = settings.cusum.cap == 10.0 * settings.cusum.threshold;
        let ratio = if usual { 10.0 } else { settings.cusum.cap / settings.cusum.threshold };
        settings.cusum.threshold = threshold;
        settings.cusum.cap = ratio * threshold;
        settings
    }

    /// Tells of every alarm: the index of the threshold and that of the sample. For each threshold they come in time order.
    pub fn evaluate(&self, evidence: &[Evidence<f64>], tick_s: f64, mut alarm: impl FnMut(usize, usize)) {
        let settings: Vec<DetectorSettings> = (0..self.thresholds.len()).map(|rung| self.settings_at(rung)).collect();
        for (group, settings) in settings.chunks(RUNGS).enumerate() {
            // Where the last group is not full, its last threshold stands in for the rest.
            let of = |pick: fn(&DetectorSettings) -> f64| {
                ThresholdLanes(std::array::from_fn(|i| pick(&settings[i.min(settings.len() - 1)])))
            };
            let detector = CusumDetector::<ThresholdLanes>::new(&self.settings, tick_s)
                .with_thresholds(of(|settings| settings.cusum.threshold), of(|settings| settings.cusum.cap));
            self.climb_group(detector, evidence, |rung, sample| {
                if rung < settings.len() {
                    alarm(group * RUNGS + rung, sample);
                }
            });
        }
    }

    fn climb_group(
        &self,
        mut detector: CusumDetector<ThresholdLanes>,
        evidence: &[Evidence<f64>],
        mut alarm: impl FnMut(usize, usize),
    ) {
        for (sample, e) in evidence.iter().enumerate() {
            let decision = detector.update(&Evidence {
                force_n: ThresholdLanes::splat(e.force_n),
                predicted_force_n: ThresholdLanes::splat(e.predicted_force_n),
                residual_n: ThresholdLanes::splat(e.residual_n),
                correction: e.correction.map(ThresholdLanes::splat),
                depth_m: ThresholdLanes::splat(e.depth_m),
                velocity_m_per_s: ThresholdLanes::splat(e.velocity_m_per_s),
                in_contact: Mask::splat(e.in_contact),
            });
            if decision.alarm.any() {
                (0..RUNGS).filter(|&rung| decision.alarm.lane(rung)).for_each(|rung| alarm(rung, sample));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::{DistanceKind, Hypotheses};

    #[test]
    fn the_middle_threshold_is_the_settings_own_and_the_range_is_four_decades() {
        for kind in DistanceKind::ALL {
            let settings = DetectorSettings::for_kind(kind, Hypotheses::default());
            let ladder = Ladder::around(settings, 24);
            assert_eq!((ladder.settings_at(12), ladder.thresholds().len()), (settings, 24));
            assert!((ladder.thresholds()[0] / settings.cusum.threshold - 0.01).abs() < 1e-12);
            assert!(ladder.thresholds().windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
