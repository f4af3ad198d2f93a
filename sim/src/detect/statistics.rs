//! Statistics of the residual, over a whole recording and by phase.

use serde::Serialize;

use super::Detection;
use super::phases::{Phase, PhaseInterval};
use crate::estimation::Confidence;
use crate::quantiles::robust_std;

/// Statistics of the residual over a whole recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ResidualStatistics {
    /// Mean, in N.
    pub mean_n: f64,
    /// Standard deviation, in N.
    pub std_n: f64,
    /// Mean of the magnitude, in N.
    pub mean_absolute_n: f64,
    /// Largest magnitude, in N.
    pub max_absolute_n: f64,
    /// 1.4826 times the median absolute deviation, in N: a standard deviation that outliers do not affect.
    pub robust_std_n: f64,
}

impl ResidualStatistics {
    /// Returns the statistics of residuals in N; 0 without residuals. `residual` returns the same values at every call.
    pub(super) fn of<I: Iterator<Item = f64>>(residual: impl Fn() -> I) -> Self {
        let mut sums = (0_usize, -0.0, -0.0, 0.0_f64);
        residual().for_each(|e| {
            let magnitude = e.abs();
            sums = (sums.0 + 1, sums.1 + e, sums.2 + magnitude, sums.3.max(magnitude));
        });
        let (count, sum_n, absolute_n, max_absolute_n) = sums;
        let count = count.max(1) as f64;
        let mean_n = sum_n / count;
        let variance = residual().map(|e| (e - mean_n).powi(2)).sum::<f64>() / count;
        Self {
            mean_n,
            std_n: variance.sqrt(),
            mean_absolute_n: absolute_n / count,
            max_absolute_n,
            robust_std_n: robust_std(residual).unwrap_or(0.0),
        }
    }
}

/// The statistics of one phase over all its intervals. A value is `None` if it is undefined: in a phase that does not
/// occur, or out of the tissue.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseStatistics {
    /// The phase.
    pub phase: Phase,
    /// Number of intervals.
    #[serde(rename = "stretches")]
    pub intervals: usize,
    /// Number of samples.
    pub samples: usize,
    /// Total duration, in s.
    pub duration_s: f64,
    /// Mean magnitude of the residual, in N.
    pub mean_absolute_n: Option<f64>,
    /// Standard deviation of the residual, in N.
    pub std_n: Option<f64>,
    /// 1.4826 times the median absolute deviation of the residual, in N; `None` over several recordings.
    pub robust_std_n: Option<f64>,
    /// Mean estimated stiffness in N/m; `None` out of the tissue, where the estimator does not update.
    pub mean_stiffness_n_per_m: Option<f64>,
    /// Mean estimated damping in N·s/m; `None` as the stiffness.
    pub mean_damping_n_s_per_m: Option<f64>,
    /// Mean standard error of the estimated stiffness in N/m; `None` as the stiffness.
    pub mean_stiffness_std_n_per_m: Option<f64>,
    /// Mean standard error of the estimated damping in N·s/m; `None` as the stiffness.
    pub mean_damping_std_n_s_per_m: Option<f64>,
}

/// Samples from one evaluation of the standard errors to the next; all of them enter the errors.
const STEP: usize = 8;

/// The mean standard errors of stiffness (N/m) and damping (N·s/m) in each phase of [`Phase::ALL`].
fn standard_errors(detection: &Detection, intervals: &[PhaseInterval]) -> [Option<[f64; 2]>; Phase::ALL.len()] {
    let mut confidence = Confidence::new(detection.interval_s);
    let mut sums = [([0.0; 2], 0_usize); Phase::ALL.len()];
    for interval in intervals {
        let Some(place) = Phase::ALL.iter().position(|phase| *phase == interval.phase) else { continue };
        let (sum, count) = &mut sums[place];
        for sample in interval.samples.clone() {
            let depth_m = detection.position_m[sample] - detection.contact_m;
            if depth_m > 0.0 {
                confidence.add(depth_m, detection.velocity_m_per_s[sample], detection.residual_n[sample]);
            }
            if sample.is_multiple_of(STEP) {
                let trust = confidence.trust();
                sum[0] += trust.stiffness_std_n_per_m;
                sum[1] += trust.damping_std_n_s_per_m;
                *count += 1;
            }
        }
    }
    sums.map(|(sum, count)| (count > 0).then(|| sum.map(|sum| sum / count as f64)))
}

impl PhaseStatistics {
    /// Returns the statistics of every phase, in the order of [`Phase::ALL`].
    pub(super) fn all(detection: &Detection, intervals: &[PhaseInterval]) -> Vec<Self> {
        let errors = standard_errors(detection, intervals);
        let of = |(phase, errors): (Phase, _)| Self::of(detection, intervals, phase, errors);
        Phase::ALL.into_iter().zip(errors).map(of).collect()
    }

    fn of(detection: &Detection, intervals: &[PhaseInterval], phase: Phase, errors: Option<[f64; 2]>) -> Self {
        let own: Vec<&PhaseInterval> = intervals.iter().filter(|interval| interval.phase == phase).collect();
        let samples = own.iter().map(|interval| interval.samples.len()).sum();
        let residual = || of_intervals(&detection.residual_n, &own);
        let statistics = (samples > 0).then(|| ResidualStatistics::of(residual));
        let is_estimated = samples > 0 && phase != Phase::Free;
        let mean = |column: &[f64]| is_estimated.then(|| of_intervals(column, &own).sum::<f64>() / samples as f64);
        Self {
            phase,
            intervals: own.len(),
            samples,
            duration_s: samples as f64 * detection.interval_s,
            mean_absolute_n: statistics.map(|s| s.mean_absolute_n),
            std_n: statistics.map(|s| s.std_n),
            robust_std_n: statistics.map(|s| s.robust_std_n),
            mean_stiffness_n_per_m: mean(&detection.stiffness_n_per_m),
            mean_damping_n_s_per_m: mean(&detection.damping_n_s_per_m),
            mean_stiffness_std_n_per_m: errors.filter(|_| is_estimated).map(|[k, _]| k),
            mean_damping_std_n_s_per_m: errors.filter(|_| is_estimated).map(|[_, b]| b),
        }
    }

    /// Returns the statistics of one phase over several recordings, with equal weight for every sample. The standard
    /// deviation is about the mean of each recording.
    #[must_use]
    pub fn pooled<'a>(phase: Phase, of: impl IntoIterator<Item = &'a Self>) -> Self {
        let own: Vec<&Self> = of.into_iter().filter(|statistics| statistics.phase == phase).collect();
        let samples = own.iter().map(|s| s.samples).sum();
        let weighted = |value: &dyn Fn(&Self) -> Option<f64>| {
            let (sum, count) = own
                .iter()
                .filter_map(|s| value(s).map(|value| (value * s.samples as f64, s.samples)))
                .fold((0.0, 0), |(sum, count), (value, samples)| (sum + value, count + samples));
            (count > 0).then(|| sum / count as f64)
        };
        Self {
            phase,
            intervals: own.iter().map(|s| s.intervals).sum(),
            samples,
            duration_s: own.iter().map(|s| s.duration_s).sum(),
            mean_absolute_n: weighted(&|s| s.mean_absolute_n),
            std_n: weighted(&|s| s.std_n.map(|std_n| std_n * std_n)).map(f64::sqrt),
            robust_std_n: None,
            mean_stiffness_n_per_m: weighted(&|s| s.mean_stiffness_n_per_m),
            mean_damping_n_s_per_m: weighted(&|s| s.mean_damping_n_s_per_m),
            mean_stiffness_std_n_per_m: weighted(&|s| s.mean_stiffness_std_n_per_m),
            mean_damping_std_n_s_per_m: weighted(&|s| s.mean_damping_std_n_s_per_m),
        }
    }
}

/// The values of a column in some intervals.
fn of_intervals<'a>(column: &'a [f64], intervals: &'a [&PhaseInterval]) -> impl Iterator<Item = f64> + 'a {
    intervals.iter().flat_map(|interval| column[interval.samples.clone()].iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detection(residual_n: Vec<f64>) -> Detection {
        let count = residual_n.len();
        let ramp = || (0..count).map(|k| k as f64).collect::<Vec<_>>();
        Detection {
            interval_s: 0.5,
            time_s: ramp(),
            position_m: ramp(),
            velocity_m_per_s: ramp(),
            measured_force_n: ramp(),
            residual_n,
            stiffness_n_per_m: ramp(),
            damping_n_s_per_m: vec![2.0; count],
            distance: ramp(),
            decision: ramp(),
            extra_parameter: None,
            alarms: vec![],
            contact_m: 0.0,
            touched: true,
            conditions: vec![],
            detector: crate::detection::DetectorSettings::default(),
            is_velocity_measured: true,
        }
    }

    #[test]
    fn a_phase_is_summed_over_its_intervals_and_nothing_else() {
        let interval = |phase, samples| PhaseInterval { phase, samples };
        let intervals = [
            interval(Phase::Free, 0..1),
            interval(Phase::Insertion, 1..3),
            interval(Phase::Hold, 3..4),
            interval(Phase::Insertion, 4..6),
        ];
        let all = PhaseStatistics::all(&detection(vec![9.0, 1.0, -1.0, 5.0, 3.0, -3.0]), &intervals);
        let insertion = &all[1];
        assert_eq!((insertion.intervals, insertion.samples, insertion.duration_s), (2, 4, 2.0));
        assert_eq!((insertion.mean_absolute_n, insertion.std_n), (Some(2.0), Some(5.0_f64.sqrt())));
        assert_eq!((insertion.mean_stiffness_n_per_m, insertion.mean_damping_n_s_per_m), (Some(3.0), Some(2.0)));
        assert_eq!(
            (all[0].mean_absolute_n, all[0].mean_stiffness_n_per_m),
            (Some(9.0), None),
            "no update out of the tissue"
        );
        let never = &all[3];
        assert_eq!((never.samples, never.std_n, never.robust_std_n), (0, None, None), "undefined, not 0");
    }

    #[test]
    fn a_held_needle_tells_little_about_the_damping() {
        // 0.5 s of oscillation, then 2 s at rest, with an error of 0.05 N in turn up and down.
        let mut all = detection((0..2500).map(|k| if k % 2 == 0 { 0.05 } else { -0.05 }).collect());
        all.interval_s = 1e-3;
        let swing = |k: usize| if k < 500 { 0.05 * k as f64 } else { 0.0 };
        all.position_m = (0..2500).map(|k| 0.01 + 1e-3 * swing(k).sin()).collect();
        all.velocity_m_per_s = (0..2500).map(|k| if k < 500 { 0.05 * swing(k).cos() } else { 0.0 }).collect();
        let interval = |phase, samples| PhaseInterval { phase, samples };
        let intervals = [interval(Phase::Insertion, 0..500), interval(Phase::Hold, 500..2500)];
        let phases = PhaseStatistics::all(&all, &intervals);
        let errors = |phase: usize| {
            let of = &phases[phase];
            [of.mean_stiffness_std_n_per_m.expect("estimated"), of.mean_damping_std_n_s_per_m.expect("estimated")]
        };
        let (insertion, hold) = (errors(1), errors(2));
        assert!(hold[1] > 10.0 * insertion[1], "{insertion:?} {hold:?}");
        assert!(hold[0] < 10.0, "the stiffness stays known: {hold:?}");
        // The columns have the same errors, sample by sample.
        let trust = all.trust();
        let mean = |column: &[f64]| column[500..].iter().step_by(8).skip(1).sum::<f64>() / 249.0;
        assert!((mean(&trust.damping_std_n_s_per_m) / hold[1] - 1.0).abs() < 0.01, "{hold:?}");
        assert_eq!((phases[0].mean_damping_std_n_s_per_m, phases[3].mean_damping_std_n_s_per_m), (None, None));
    }

    #[test]
    fn pooling_weighs_by_samples() {
        let intervals = |samples| [PhaseInterval { phase: Phase::Hold, samples }];
        let one = PhaseStatistics::all(&detection(vec![1.0, -1.0]), &intervals(0..2));
        let two = PhaseStatistics::all(&detection(vec![4.0, -4.0, 4.0, -4.0]), &intervals(0..4));
        let both = PhaseStatistics::pooled(Phase::Hold, one.iter().chain(&two));
        assert_eq!((both.samples, both.duration_s, both.mean_absolute_n), (6, 3.0, Some(3.0)));
        assert_eq!(both.std_n, Some((66.0_f64 / 6.0).sqrt()));
        assert_eq!(PhaseStatistics::pooled(Phase::Free, one.iter().chain(&two)).mean_absolute_n, None);
    }
}
