//! The estimator is a block ahead of the detector, in parallel.

use super::chain::{DetectionChain, Estimation};
use super::conditions::SampleConditions;
use super::plausibility::Signals;
use trocar_base::interrupt;
use trocar_base::large_pages::with_capacity;
use trocar_base::rows::Rows;
use trocar_core::chain::Measurement;
use trocar_core::detector::{CusumDetector, Decision, Detector, DetectorInput};
use trocar_core::estimation::Estimate;

/// Half a millisecond of work, longer than a thread's wake-up.
const BLOCK: usize = 16384;

/// Residual, stiffness, damping, velocity, extra parameter and decisions; the last two are empty unless requested.
pub(super) fn evaluate(chain: &mut DetectionChain, signals: &Signals<'_>) -> (Rows<5>, Decisions) {
    let count = signals.time_s.len();
    let is_kept = [true, true, true, signals.velocity_m_per_s.is_none(), signals.has_extra_parameter];
    let (mut estimates, mut decisions) = (Rows::new(count, is_kept), Decisions::new(count));
    let (mut estimation, detector) = chain.stages();
    let [mut ready, mut next] = [const { Vec::new() }; 2];
    for from in (0..count).step_by(BLOCK) {
        let samples = from..count.min(from + BLOCK);
        rayon::join(
            || decisions.extend(detector, &ready),
            || {
                next.clear();
                next.extend(samples.map(|at| estimate(&mut estimation, &mut estimates, signals, at)));
            },
        );
        std::mem::swap(&mut ready, &mut next);
    }
    decisions.extend(detector, &ready);
    (estimates, decisions)
}

#[inline(always)]
fn estimate(
    estimation: &mut Estimation<'_>,
    rows: &mut Rows<5>,
    signals: &Signals<'_>,
    at: usize,
) -> DetectorInput<f64> {
    let (estimate, input) = estimation.step(&Measurement {
        position_m: signals.position_m[at],
        velocity_m_per_s: signals.velocity_m_per_s.map_or(0.0, |column| column[at]),
        force_n: signals.force_n[at],
    });
    let Estimate { residual_n, stiffness_n_per_m, damping_n_s_per_m, extra_parameter, .. } = estimate;
    rows.push([residual_n, stiffness_n_per_m, damping_n_s_per_m, input.velocity_m_per_s, extra_parameter]);
    input
}

pub(super) struct Decisions {
    pub(super) columns: Rows<2>,
    pub(super) conditions: Vec<SampleConditions>,
    pub(super) alarms: Vec<usize>,
    pub(super) touched: bool,
}

impl Decisions {
    fn new(count: usize) -> Self {
        let columns = Rows::new(count, [true; 2]);
        Self { columns, conditions: with_capacity(count), alarms: vec![], touched: false }
    }

    fn extend(&mut self, detector: &mut CusumDetector<f64>, samples: &[DetectorInput<f64>]) {
        interrupt::check();
        for input in samples {
            let conditions = detector.conditions(input);
            let Decision { distance, decision, alarm } = detector.update(input);
            self.touched |= input.in_contact;
            self.columns.push([distance, decision]);
            if alarm {
                self.alarms.push(self.conditions.len());
            }
            self.conditions.push(SampleConditions::of(&conditions));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Detection, Step, VelocitySource, detect_recording};
    use super::*;
    use trocar_recording::Recording;
    use trocar_scenario::{DetectionSettings, Values};

    /// Returns insertions of 4 s, in each of which the force drops by 2 N in one sample.
    fn insertions(count: usize) -> [Vec<f64>; 4] {
        let sample = |k: usize| {
            let time_s = 1e-3 * k as f64;
            let (phase, speed) = (std::f64::consts::TAU * time_s / 4.0, 0.01 * std::f64::consts::TAU / 4.0);
            let position_m = 0.01 * (1.0 - phase.cos());
            let fallen_n = if k % 4000 > 1200 { 2.0 } else { 0.0 };
            let force_n = (400.0 * position_m - fallen_n + 0.02 * (12.9898 * k as f64).sin()).max(0.0);
            [time_s, position_m, speed * phase.sin(), force_n]
        };
        [0, 1, 2, 3].map(|column| (0..count).map(|k| sample(k)[column]).collect())
    }

    #[test]
    fn the_parallel_stages_match_the_chain_sample_by_sample() {
        for (count, distance) in [(2 * BLOCK + 1, "adaptive"), (BLOCK, "squared-residual"), (2, "adaptive")] {
            let [time_s, position_m, velocity_m_per_s, force_n] = insertions(count);
            let mut values =
                Values::from_settings("insertions", &[format!("detector.distance={distance}")]).expect("valid");
            let settings = DetectionSettings::resolve(&mut values).expect("valid");
            let measurements = (0..count).map(|at| Measurement {
                position_m: position_m[at],
                velocity_m_per_s: velocity_m_per_s[at],
                force_n: force_n[at],
            });
            let measurements: Vec<_> = measurements.collect();
            let recording = Recording::new(time_s, position_m, Some(velocity_m_per_s), force_n, None).expect("valid");
            let interval_s = recording.median_interval_s();
            let mut chain = DetectionChain::new(&settings, interval_s, VelocitySource::Measured).expect("valid");
            let steps: Vec<Step> = measurements.iter().map(|measurement| chain.step(measurement)).collect();
            let Detection { residual_n, stiffness_n_per_m, distance, decision, conditions, alarms, .. } =
                detect_recording(recording, &settings).expect("valid");
            let column = |of: &dyn Fn(&Step) -> f64| steps.iter().map(of).collect::<Vec<_>>();
            assert!(residual_n == column(&|step| step.estimate.residual_n));
            assert!(stiffness_n_per_m == column(&|step| step.estimate.stiffness_n_per_m));
            assert!(distance == column(&|step| step.decision.distance));
            assert!(decision == column(&|step| step.decision.decision));
            assert!(conditions.into_iter().eq(steps.iter().map(|step| SampleConditions::of(&step.conditions))));
            assert!(alarms.iter().copied().eq((0..count).filter(|&at| steps[at].decision.alarm)));
            assert_eq!(alarms.is_empty(), count == 2, "{count} samples");
        }
    }
}
