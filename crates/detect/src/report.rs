use schemars::JsonSchema;
use serde::Serialize;

use super::Detection;
use super::matching::{Match, follows_fall, match_alarms};
use super::misses::{LabelMiss, misses};
use super::phases::{Phase, PhaseInterval};
use super::plausibility::warnings;
use super::scores::{Scores, Tally};
use super::statistics::{PhaseStatistics, ResidualStatistics, statistics};
use trocar_base::quantiles::upper_median;
use trocar_base::warning::{Code, Warning};
use trocar_core::detector::DetectorSettings;
use trocar_metrics::RUPTURE_WINDOW_S;

/// An alarm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct DetectedAlarm {
    /// Time in the recording, in s.
    pub time_s: f64,
    /// Index of the sample, from 0.
    pub sample: usize,
    /// Position of the needle, in m.
    pub position_m: f64,
    /// Depth below the contact, in m.
    pub depth_m: f64,
    /// The measured force, in N.
    pub force_n: f64,
    /// The residual, in N.
    pub residual_n: f64,
    /// Index of the matched label, from 0; `None` without a match.
    pub label: Option<usize>,
    /// Delay after that label, in s.
    pub delay_s: Option<f64>,
}

/// A labelled rupture of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Label {
    /// Time in the recording, in s.
    pub time_s: f64,
    /// Kind of rupture, if given.
    pub kind: Option<String>,
}

/// The estimates of the extra parameter over a whole run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ExtraParameterEstimate {
    /// Name of the column, with the unit.
    pub column: &'static str,
    /// The upper median.
    pub median: f64,
    /// The last value.
    pub last: f64,
}

impl ExtraParameterEstimate {
    pub fn of(extra_parameter: &Option<(&'static str, Vec<f64>)>) -> Option<Self> {
        let (column, values) = extra_parameter.as_ref()?;
        Some(Self { column, median: upper_median(values)?, last: *values.last()? })
    }
}

/// The results of a detection.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DetectionReport {
    /// Number of samples.
    pub samples: usize,
    /// Sampling interval, in s.
    pub interval_s: f64,
    /// Time of the first sample, in s.
    pub start_s: f64,
    /// Duration of the recording, in s.
    pub duration_s: f64,
    /// Duration of the phases in which the needle is below the contact, in s.
    pub contact_s: f64,
    /// True if the needle was ever below the contact.
    pub touched: bool,
    /// The kind of detector, its threshold and the threshold's unit.
    #[serde(skip)]
    pub detector: (&'static str, f64, &'static str),
    /// The alarms, in time order.
    pub alarms: Vec<DetectedAlarm>,
    /// Times of the labelled ruptures in the recording, in s.
    pub labelled_ruptures_s: Vec<f64>,
    /// Kinds of the labelled ruptures, in the same order.
    pub labelled_kinds: Vec<Option<String>>,
    /// Number of labelled ruptures without an alarm; `None` without labels.
    pub missed_ruptures: Option<usize>,
    /// Number of alarms without a labelled rupture; `None` without labels.
    pub false_alarms: Option<usize>,
    /// Reasons why labelled ruptures were missed, with the index of the label.
    pub misses: Vec<LabelMiss>,
    /// Sentences about changes of the recording before the detection: resampled times and interpolated signals.
    pub notes: Vec<String>,
    /// The warnings about recording and detection.
    pub warnings: Vec<Warning>,
    /// Maximum delay of an alarm after the matched rupture, in s.
    pub within_s: f64,
    /// The scores; `None` without labels.
    pub scores: Option<Scores>,
    /// Statistics of the residual.
    pub residual: ResidualStatistics,
    /// Statistics of each phase.
    pub phases: Vec<PhaseStatistics>,
    /// The phases, in order of time.
    #[serde(skip)]
    pub intervals: Vec<PhaseInterval>,
    /// The counts that give the scores.
    #[serde(skip)]
    pub tally: Option<Tally>,
    /// Estimates of the extra parameter, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub further_estimate: Option<ExtraParameterEstimate>,
}

fn stray_alarm(alarms_s: &[f64], labels_s: &[f64], stray: &Match) -> Warning {
    let message = format!(
        "alarm {} at {:.3} s comes {:.1} ms after the labelled rupture {} at {:.3} s and is not its detection: the force does not fall \
         within 0.1 s before it",
        stray.alarm + 1,
        alarms_s[stray.alarm],
        1e3 * stray.delay_s,
        stray.label + 1,
        labels_s[stray.label]
    );
    Warning::new(Code::StrayAlarm, message)
        .at("--rupture-s or detector.threshold")
        .remedy("compare the label with the force; the residual there shows why the alarm was raised (residual.png)")
}

impl DetectionReport {
    /// `ruptures_s` are in s after the first sample; an empty list means no labels.
    pub fn of(detection: &Detection, ruptures_s: &[f64]) -> Self {
        let start_s = detection.time_s.first().copied().unwrap_or(0.0);
        let label = |rupture: &f64| Label { time_s: start_s + rupture, kind: None };
        let labels: Vec<Label> = ruptures_s.iter().map(label).collect();
        Self::judged(detection, (!labels.is_empty()).then_some(&labels), RUPTURE_WINDOW_S)
    }

    /// Labels ascend; an empty list means no rupture, `None` no labels.
    pub fn judged(detection: &Detection, labels: Option<&[Label]>, within_s: f64) -> Self {
        let start_s = detection.time_s.first().copied().unwrap_or(0.0);
        let labelled_ruptures_s: Vec<f64> = labels.unwrap_or_default().iter().map(|label| label.time_s).collect();
        let alarms_s: Vec<f64> = detection.alarms.iter().map(|&sample| detection.time_s[sample]).collect();
        let (matches, stray): (Vec<Match>, Vec<Match>) =
            match_alarms(&alarms_s, &labelled_ruptures_s, within_s).into_iter().partition(|matched| {
                let sample = detection.alarms[matched.alarm];
                let residual_n = detection.residual_n[sample];
                follows_fall(&detection.measured_force_n, detection.interval_s, sample, residual_n)
            });
        let alarm = |(index, &sample): (usize, &usize)| {
            let matched = matches.iter().find(|matched| matched.alarm == index);
            DetectedAlarm {
                time_s: detection.time_s[sample],
                sample,
                position_m: detection.position_m[sample],
                depth_m: detection.position_m[sample] - detection.contact_m,
                force_n: detection.measured_force_n[sample],
                residual_n: detection.residual_n[sample],
                label: matched.map(|matched| matched.label),
                delay_s: matched.map(|matched| matched.delay_s),
            }
        };
        // A label with a stray alarm needs no other explanation.
        let explained: Vec<Match> = matches.iter().chain(&stray).copied().collect();
        let misses = misses(detection, &labelled_ruptures_s, &explained, within_s);
        let strays = stray.iter().map(|stray| stray_alarm(&alarms_s, &labelled_ruptures_s, stray));
        let duration_s = detection.time_s.last().copied().unwrap_or(0.0) - start_s;
        let (residual, phases) = statistics(detection);
        let in_contact = phases.iter().filter(|phase| phase.phase != Phase::Free);
        let contact_s = in_contact.map(|phase| phase.duration_s).sum::<f64>().min(duration_s);
        let tally = labels.map(|labels| Tally {
            recordings: 1,
            ruptures: labels.len(),
            alarms: alarms_s.len(),
            delays_s: matches.iter().map(|matched| matched.delay_s).collect(),
            recorded_s: duration_s,
            contact_s,
        });
        let scores = tally.as_ref().map(Scores::of);
        Self {
            samples: detection.time_s.len(),
            interval_s: detection.interval_s,
            start_s,
            duration_s,
            contact_s,
            touched: detection.touched,
            detector: {
                let DetectorSettings { distance, cusum, .. } = &detection.detector;
                (distance.kind.word(), cusum.threshold, distance.kind.unit())
            },
            alarms: detection.alarms.iter().enumerate().map(alarm).collect(),
            labelled_kinds: labels.unwrap_or_default().iter().map(|label| label.kind.clone()).collect(),
            missed_ruptures: scores.map(|scores| scores.missed),
            false_alarms: scores.map(|scores| scores.false_alarms),
            notes: detection.notes.clone(),
            warnings: detection.warnings.iter().cloned().chain(strays).chain(warnings(detection, &misses)).collect(),
            misses,
            labelled_ruptures_s,
            within_s,
            scores,
            residual,
            phases,
            intervals: detection.phases.clone(),
            tally,
            further_estimate: ExtraParameterEstimate::of(&detection.extra_parameter),
        }
    }

    pub fn missed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.labelled_ruptures_s.len()).filter(|&label| self.alarms.iter().all(|alarm| alarm.label != Some(label)))
    }
}
