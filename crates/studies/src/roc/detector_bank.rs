use super::lanes::{LANES, ThresholdLanes};
use trocar_core::detector::{CusumDetector, Detector, DetectorInput, DetectorSettings};
use trocar_core::lane::{Lane, Mask};

/// One detector at many thresholds. The ratio of cap to threshold is that of the settings. Each threshold is a lane of
/// [`Detector`], so its alarms are those of a separate detector.
#[derive(Debug, Clone)]
pub struct DetectorBank {
    settings: DetectorSettings,
    thresholds: Vec<f64>,
}

impl DetectorBank {
    /// At least two thresholds from 0.01 to nearly 100 times that of the settings, which is one of them, on a
    /// logarithmic scale.
    pub fn around(settings: DetectorSettings, count: usize) -> Self {
        let middle = (count.max(2) / 2) as f64;
        let share = |k: usize| libm::pow(100.0, (k as f64 - middle) / middle);
        Self::new(settings, (0..count.max(2)).map(|k| settings.cusum.threshold * share(k)).collect())
    }

    /// Thresholds are above 0.
    pub fn new(settings: DetectorSettings, thresholds: Vec<f64>) -> Self {
        Self { settings, thresholds }
    }

    pub fn settings(&self) -> &DetectorSettings {
        &self.settings
    }

    pub fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    pub fn settings_at(&self, index: usize) -> DetectorSettings {
        let threshold = self.thresholds.get(index).copied().unwrap_or(self.settings.cusum.threshold);
        let mut settings = self.settings;
        // A division would not reproduce the default ratio of 10 exactly.
        let usual = settings.cusum.cap == 10.0 * settings.cusum.threshold;
        let ratio = if usual { 10.0 } else { settings.cusum.cap / settings.cusum.threshold };
        settings.cusum.threshold = threshold;
        settings.cusum.cap = ratio * threshold;
        settings
    }

    /// `alarm` receives the indices of threshold and sample, in order of time for each threshold.
    pub fn evaluate(&self, input: &[DetectorInput<f64>], tick_s: f64, alarm: &mut dyn FnMut(usize, usize)) {
        let settings: Vec<DetectorSettings> = (0..self.thresholds.len()).map(|index| self.settings_at(index)).collect();
        for (group, settings) in settings.chunks(LANES).enumerate() {
            // The last threshold fills an incomplete group.
            let of = |pick: fn(&DetectorSettings) -> f64| {
                ThresholdLanes(std::array::from_fn(|i| pick(&settings[i.min(settings.len() - 1)])))
            };
            let detector = CusumDetector::<ThresholdLanes>::new(&self.settings, tick_s)
                .with_thresholds(of(|settings| settings.cusum.threshold), of(|settings| settings.cusum.cap));
            self.evaluate_group(detector, input, &mut |index, sample| {
                if index < settings.len() {
                    alarm(group * LANES + index, sample);
                }
            });
        }
    }

    fn evaluate_group(
        &self,
        mut detector: CusumDetector<ThresholdLanes>,
        input: &[DetectorInput<f64>],
        alarm: &mut dyn FnMut(usize, usize),
    ) {
        for (sample, e) in input.iter().enumerate() {
            let decision = detector.update(&DetectorInput {
                force_n: ThresholdLanes::splat(e.force_n),
                predicted_force_n: ThresholdLanes::splat(e.predicted_force_n),
                residual_n: ThresholdLanes::splat(e.residual_n),
                correction: e.correction.map(ThresholdLanes::splat),
                depth_m: ThresholdLanes::splat(e.depth_m),
                velocity_m_per_s: ThresholdLanes::splat(e.velocity_m_per_s),
                in_contact: Mask::splat(e.in_contact),
            });
            if decision.alarm.any() {
                (0..LANES).filter(|&index| decision.alarm.lane(index)).for_each(|index| alarm(index, sample));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_core::detector::{DistanceKind, Hypotheses};

    #[test]
    fn the_thresholds_span_four_decades_around_the_threshold_of_the_settings() {
        for kind in DistanceKind::ALL {
            let settings = DetectorSettings::for_kind(kind, Hypotheses::default());
            let bank = DetectorBank::around(settings, 24);
            assert_eq!((bank.settings_at(12), bank.thresholds().len()), (settings, 24));
            assert!((bank.thresholds()[0] / settings.cusum.threshold - 0.01).abs() < 1e-12);
            assert!(bank.thresholds().windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
