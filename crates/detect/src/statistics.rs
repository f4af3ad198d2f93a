use schemars::JsonSchema;
use serde::Serialize;

use super::Detection;
use super::phases::Phase;
use trocar_base::interrupt;
use trocar_base::quantiles::robust_std;
use trocar_core::estimation::Confidence;

/// Statistics of the residual over a whole recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
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

/// The sums begin with -0, like those of iterators.
#[derive(Clone, Copy)]
struct Sums {
    samples: usize,
    residual_n: f64,
    absolute_n: f64,
    max_absolute_n: f64,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

impl Sums {
    const NONE: Self = Self {
        samples: 0,
        residual_n: -0.0,
        absolute_n: -0.0,
        max_absolute_n: 0.0,
        stiffness_n_per_m: -0.0,
        damping_n_s_per_m: -0.0,
    };

    #[inline]
    fn add(&mut self, residual_n: f64, stiffness_n_per_m: f64, damping_n_s_per_m: f64) {
        let absolute_n = residual_n.abs();
        self.samples += 1;
        self.residual_n += residual_n;
        self.absolute_n += absolute_n;
        self.max_absolute_n = self.max_absolute_n.max(absolute_n);
        self.stiffness_n_per_m += stiffness_n_per_m;
        self.damping_n_s_per_m += damping_n_s_per_m;
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / self.samples.max(1) as f64
    }

    fn statistics(&self, squares_n2: f64, robust_std_n: Option<f64>) -> ResidualStatistics {
        ResidualStatistics {
            mean_n: self.mean(self.residual_n),
            std_n: self.mean(squares_n2).sqrt(),
            mean_absolute_n: self.mean(self.absolute_n),
            max_absolute_n: self.max_absolute_n,
            robust_std_n: robust_std_n.unwrap_or(0.0),
        }
    }
}

struct Totals {
    all: (Sums, f64),
    phases: [(Sums, f64); Phase::ALL.len()],
}

impl Totals {
    fn of(detection: &Detection) -> Self {
        let mut all = Sums::NONE;
        let mut phases = [Sums::NONE; Phase::ALL.len()];
        for interval in &detection.phases {
            let samples = interval.samples.clone();
            let (stiffness, damping) =
                (&detection.stiffness_n_per_m[samples.clone()], &detection.damping_n_s_per_m[samples.clone()]);
            let parameters = stiffness.iter().zip(damping);
            let phase = &mut phases[interval.phase as usize];
            let mut sums = (all, *phase);
            for (residual_n, (k, b)) in detection.residual_n[samples].iter().zip(parameters) {
                sums.0.add(*residual_n, *k, *b);
                sums.1.add(*residual_n, *k, *b);
            }
            (all, *phase) = sums;
            interrupt::check();
        }
        let mut totals = Self { all: (all, -0.0), phases: phases.map(|sums| (sums, -0.0)) };
        let mean_n = all.mean(all.residual_n);
        for interval in &detection.phases {
            let (sums, squares) = &mut totals.phases[interval.phase as usize];
            let phase_n = sums.mean(sums.residual_n);
            let (mut of_all, mut of_phase) = (totals.all.1, *squares);
            for residual_n in &detection.residual_n[interval.samples.clone()] {
                of_all += (residual_n - mean_n).powi(2);
                of_phase += (residual_n - phase_n).powi(2);
            }
            (totals.all.1, *squares) = (of_all, of_phase);
            interrupt::check();
        }
        totals
    }
}

fn robust_stds(detection: &Detection) -> (Option<f64>, [Option<f64>; Phase::ALL.len()]) {
    let of_phase = |phase| {
        interrupt::check();
        let of_phase = detection.phases.iter().filter(|interval| interval.phase == phase);
        robust_std(&of_phase.map(|interval| &detection.residual_n[interval.samples.clone()]).collect::<Vec<_>>())
    };
    rayon::join(|| robust_std(&[&detection.residual_n]), || Phase::ALL.map(of_phase))
}

pub(super) fn statistics(detection: &Detection) -> (ResidualStatistics, Vec<PhaseStatistics>) {
    // Each takes a large part of the detection's time.
    let totals = || rayon::join(|| Totals::of(detection), || standard_errors(detection));
    let ((totals, errors), (robust, robust_phases)) = rayon::join(totals, || robust_stds(detection));
    let (sums, squares_n2) = totals.all;
    let of = |phase: Phase| {
        let (sums, squares_n2) = totals.phases[phase as usize];
        let residual = (sums.samples > 0).then(|| sums.statistics(squares_n2, robust_phases[phase as usize]));
        PhaseStatistics::of(detection, phase, &sums, residual, errors[phase as usize])
    };
    (sums.statistics(squares_n2, robust), Phase::ALL.into_iter().map(of).collect())
}

/// The statistics of one phase over all its intervals. `None` means undefined: the phase does not occur, or the needle
/// is out of the tissue.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
    /// Mean estimated damping in N·s/m; `None` out of the tissue.
    pub mean_damping_n_s_per_m: Option<f64>,
    /// Mean standard error of the estimated stiffness in N/m; `None` out of the tissue.
    pub mean_stiffness_std_n_per_m: Option<f64>,
    /// Mean standard error of the estimated damping in N·s/m; `None` out of the tissue.
    pub mean_damping_std_n_s_per_m: Option<f64>,
}

/// Every sample enters the standard errors.
const STEP: usize = 8;

fn standard_errors(detection: &Detection) -> [Option<[f64; 2]>; Phase::ALL.len()] {
    let mut confidence = Confidence::new(detection.interval_s);
    let mut sums = [([0.0; 2], 0_usize); Phase::ALL.len()];
    for interval in &detection.phases {
        let (sum, count) = &mut sums[interval.phase as usize];
        for sample in interval.samples.clone() {
            interrupt::check_at(sample as u64);
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
    fn of(
        detection: &Detection,
        phase: Phase,
        sums: &Sums,
        residual: Option<ResidualStatistics>,
        errors: Option<[f64; 2]>,
    ) -> Self {
        let is_estimated = sums.samples > 0 && phase != Phase::Free;
        let mean = |sum: f64| is_estimated.then(|| sums.mean(sum));
        Self {
            phase,
            intervals: detection.phases.iter().filter(|interval| interval.phase == phase).count(),
            samples: sums.samples,
            duration_s: sums.samples as f64 * detection.interval_s,
            mean_absolute_n: residual.map(|s| s.mean_absolute_n),
            std_n: residual.map(|s| s.std_n),
            robust_std_n: residual.map(|s| s.robust_std_n),
            mean_stiffness_n_per_m: mean(sums.stiffness_n_per_m),
            mean_damping_n_s_per_m: mean(sums.damping_n_s_per_m),
            mean_stiffness_std_n_per_m: errors.filter(|_| is_estimated).map(|[k, _]| k),
            mean_damping_std_n_s_per_m: errors.filter(|_| is_estimated).map(|[_, b]| b),
        }
    }

    /// Samples have equal weight. The standard deviation is about each recording's mean.
    pub fn pooled<'a>(phase: Phase, of: impl IntoIterator<Item = &'a Self>) -> Self {
        let of_phase: Vec<&Self> = of.into_iter().filter(|statistics| statistics.phase == phase).collect();
        let samples = of_phase.iter().map(|s| s.samples).sum();
        let weighted = |value: &dyn Fn(&Self) -> Option<f64>| {
            let (sum, count) = of_phase
                .iter()
                .filter_map(|s| value(s).map(|value| (value * s.samples as f64, s.samples)))
                .fold((0.0, 0), |(sum, count), (value, samples)| (sum + value, count + samples));
            (count > 0).then(|| sum / count as f64)
        };
        Self {
            phase,
            intervals: of_phase.iter().map(|s| s.intervals).sum(),
            samples,
            duration_s: of_phase.iter().map(|s| s.duration_s).sum(),
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

#[cfg(test)]
mod tests {
    use super::super::phases::PhaseInterval;
    use super::super::plausibility::Plausibility;
    use super::*;

    fn detection(residual_n: Vec<f64>, phases: Vec<PhaseInterval>) -> Detection {
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
            detector: trocar_core::detector::DetectorSettings::default(),
            is_velocity_measured: true,
            is_resampled: false,
            notes: vec![],
            warnings: vec![],
            phases,
            recorded: Plausibility::default(),
        }
    }

    #[test]
    fn a_phase_is_summed_over_its_intervals_only() {
        let interval = |phase, samples| PhaseInterval { phase, samples };
        let intervals = vec![
            interval(Phase::Free, 0..1),
            interval(Phase::Insertion, 1..3),
            interval(Phase::Hold, 3..4),
            interval(Phase::Insertion, 4..6),
        ];
        let (residual, all) = statistics(&detection(vec![9.0, 1.0, -1.0, 5.0, 3.0, -3.0], intervals));
        assert_eq!((residual.mean_n, residual.max_absolute_n), (14.0 / 6.0, 9.0));
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
    fn a_held_needle_gives_little_information_about_the_damping() {
        // 0.5 s of oscillation, then 2 s at rest, with an error that alternates between 0.05 and -0.05 N.
        let interval = |phase, samples| PhaseInterval { phase, samples };
        let intervals = vec![interval(Phase::Insertion, 0..500), interval(Phase::Hold, 500..2500)];
        let mut all = detection((0..2500).map(|k| if k % 2 == 0 { 0.05 } else { -0.05 }).collect(), intervals);
        all.interval_s = 1e-3;
        let swing = |k: usize| if k < 500 { 0.05 * k as f64 } else { 0.0 };
        all.position_m = (0..2500).map(|k| 0.01 + 1e-3 * swing(k).sin()).collect();
        all.velocity_m_per_s = (0..2500).map(|k| if k < 500 { 0.05 * swing(k).cos() } else { 0.0 }).collect();
        let (_, phases) = statistics(&all);
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
    fn pooling_weights_recordings_by_samples() {
        let of = |residual_n: Vec<f64>| {
            let intervals = vec![PhaseInterval { phase: Phase::Hold, samples: 0..residual_n.len() }];
            statistics(&detection(residual_n, intervals)).1
        };
        let (one, two) = (of(vec![1.0, -1.0]), of(vec![4.0, -4.0, 4.0, -4.0]));
        let both = PhaseStatistics::pooled(Phase::Hold, one.iter().chain(&two));
        assert_eq!((both.samples, both.duration_s, both.mean_absolute_n), (6, 3.0, Some(3.0)));
        assert_eq!(both.std_n, Some((66.0_f64 / 6.0).sqrt()));
        assert_eq!(PhaseStatistics::pooled(Phase::Free, one.iter().chain(&two)).mean_absolute_n, None);
    }
}
