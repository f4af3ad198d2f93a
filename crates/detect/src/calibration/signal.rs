use trocar_base::interrupt;
use trocar_base::large_pages::with_capacity;
use trocar_core::detector::{CusumDetector, Detector, DetectorInput, DetectorSettings};
use trocar_core::estimation::{AnyEstimator, Estimator, RlsSettings};

#[derive(Debug, Clone, Copy)]
pub(super) struct Signal<'a> {
    pub(super) interval_s: f64,
    pub(super) position_m: &'a [f64],
    pub(super) velocity_m_per_s: &'a [f64],
    pub(super) force_n: &'a [f64],
}

impl Signal<'_> {
    pub(super) fn samples_in(&self, time_s: f64, min: usize) -> usize {
        ((time_s / self.interval_s) as usize).max(min)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Residuals {
    pub(super) residual_n: Vec<f64>,
    pub(super) predicted_n: Vec<f64>,
    pub(super) depth_m: Vec<f64>,
    pub(super) input: Vec<DetectorInput<f64>>,
}

impl Residuals {
    pub(super) fn of(signal: &Signal<'_>, settings: &RlsSettings, contact_m: f64) -> Self {
        let mut estimator = AnyEstimator::<f64>::new(settings);
        let count = signal.force_n.len();
        let mut residuals = Self {
            residual_n: with_capacity(count),
            predicted_n: with_capacity(count),
            depth_m: with_capacity(count),
            input: with_capacity(count),
        };
        for sample in 0..count {
            interrupt::check_at(sample as u64);
            let (force_n, velocity_m_per_s) = (signal.force_n[sample], signal.velocity_m_per_s[sample]);
            let depth_m = signal.position_m[sample] - contact_m;
            let estimate = estimator.update(force_n, depth_m, velocity_m_per_s);
            residuals.input.push(DetectorInput::new(force_n, depth_m, velocity_m_per_s, &estimate));
            residuals.residual_n.push(estimate.residual_n);
            residuals.predicted_n.push(estimate.predicted_force_n);
            residuals.depth_m.push(depth_m);
        }
        residuals
    }

    pub(super) fn is_drop(&self, sample: usize) -> bool {
        self.residual_n[sample] < 0.0 && self.predicted_n[sample] > 0.0
    }

    pub(super) fn alarms(&self, signal: &Signal<'_>, settings: &DetectorSettings) -> Vec<usize> {
        let mut detector = CusumDetector::<f64>::new(settings, signal.interval_s);
        let alarms = self.input.iter().enumerate().filter_map(|(sample, input)| {
            interrupt::check_at(sample as u64);
            detector.update(input).alarm.then_some(sample)
        });
        alarms.collect()
    }
}
