//! What a detection says in numbers.

use serde::Serialize;

use super::Detection;
use super::matching::match_alarms;
use super::phases::{PhaseInterval, PhaseRule};
use super::scores::{Scores, Tally};
use super::statistics::{PhaseStatistics, ResidualStatistics};
use crate::metrics::RUPTURE_WINDOW_S;
use crate::quantiles::upper_median;

/// An alarm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DetectedAlarm {
    /// When, in the recording's own time, in s.
    pub time_s: f64,
    /// Which sample, from 0.
    pub sample: usize,
    /// Where the needle was, in m.
    pub position_m: f64,
    /// How deep below the contact that is, in m.
    pub depth_m: f64,
    /// The measured force, in N.
    pub force_n: f64,
    /// The residual, in N.
    pub residual_n: f64,
    /// Which label it announces, from 0; none if it announces none.
    pub label: Option<usize>,
    /// From that label, in s.
    pub delay_s: Option<f64>,
}

/// A rupture that someone has seen in a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Label {
    /// When, in the recording's own time, in s.
    pub time_s: f64,
    /// What kind of rupture, where that was written.
    pub kind: Option<String>,
}

/// What was estimated besides stiffness and damping, over a whole run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExtraParameterEstimate {
    /// Its column, with its unit.
    pub column: &'static str,
    /// The upper median.
    pub median: f64,
    /// The last value.
    pub last: f64,
}

impl ExtraParameterEstimate {
    /// Sums a column up; none where there is none, or nothing in it.
    #[must_use]
    pub fn of(further: &Option<(&'static str, Vec<f64>)>) -> Option<Self> {
        let (column, values) = further.as_ref()?;
        Some(Self { column, median: upper_median(values.clone())?, last: *values.last()? })
    }
}

/// What came out of a detection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectionReport {
    /// How many samples there were.
    pub samples: usize,
    /// How far apart they are, in s.
    pub interval_s: f64,
    /// The time of the first, in s.
    pub start_s: f64,
    /// How long the recording is, in s.
    pub duration_s: f64,
    /// How long the needle was below the contact, in s.
    pub contact_s: f64,
    /// Whether the needle was ever below the contact.
    pub touched: bool,
    /// The alarms, in time order.
    pub alarms: Vec<DetectedAlarm>,
    /// Labelled ruptures, in the recording's own time, in s.
    pub labelled_ruptures_s: Vec<f64>,
    /// What kinds they are, in the same order.
    pub labelled_kinds: Vec<Option<String>>,
    /// Labelled ruptures without an alarm; none where there are no labels.
    pub missed_ruptures: Option<usize>,
    /// Alarms without a labelled rupture; none where there are no labels.
    pub false_alarms: Option<usize>,
    /// How late an alarm may be and still announce a rupture, in s.
    pub window_s: f64,
    /// The scores; none where there are no labels.
    pub scores: Option<Scores>,
    /// The residual's statistics.
    pub residual: ResidualStatistics,
    /// The estimates phase by phase.
    pub phases: Vec<PhaseStatistics>,
    /// The phases, one after the other.
    #[serde(skip)]
    pub intervals: Vec<PhaseInterval>,
    /// What the scores are of.
    #[serde(skip)]
    pub tally: Option<Tally>,
    /// What was estimated besides stiffness and damping, if anything was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub further_estimate: Option<ExtraParameterEstimate>,
}

impl DetectionReport {
    /// Sums a detection up. `ruptures_s` are labels in s after the first sample, of which none means that nobody has
    /// labelled it; an alarm announces one that lies at most [`RUPTURE_WINDOW_S`] before it.
    #[must_use]
    pub fn of(detection: &Detection, ruptures_s: &[f64]) -> Self {
        let start_s = detection.time_s.first().copied().unwrap_or(0.0);
        let label = |rupture: &f64| Label { time_s: start_s + rupture, kind: None };
        let labels: Vec<Label> = ruptures_s.iter().map(label).collect();
        Self::judged(detection, (!labels.is_empty()).then_some(&labels), RUPTURE_WINDOW_S)
    }

    /// Sums a detection up and holds it against labels in time order, where there are any: labels without a rupture say that
    /// there is none, no labels that nobody knows. Alarms and labels are matched by [`match_alarms`] within `window_s` (s).
    #[must_use]
    pub fn judged(detection: &Detection, labels: Option<&[Label]>, window_s: f64) -> Self {
        let start_s = detection.time_s.first().copied().unwrap_or(0.0);
        let labelled_ruptures_s: Vec<f64> = labels.unwrap_or_default().iter().map(|label| label.time_s).collect();
        let alarms_s: Vec<f64> = detection.alarms.iter().map(|&sample| detection.time_s[sample]).collect();
        let matches = match_alarms(&alarms_s, &labelled_ruptures_s, window_s);
        let alarm = |(index, &sample): (usize, &usize)| {
            let announced = matches.iter().find(|announced| announced.alarm == index);
            DetectedAlarm {
                time_s: detection.time_s[sample],
                sample,
                position_m: detection.position_m[sample],
                depth_m: detection.position_m[sample] - detection.contact_m,
                force_n: detection.measured_force_n[sample],
                residual_n: detection.residual_n[sample],
                label: announced.map(|announced| announced.label),
                delay_s: announced.map(|announced| announced.delay_s),
            }
        };
        let duration_s = detection.time_s.last().copied().unwrap_or(0.0) - start_s;
        let in_contact = detection.position_m.iter().filter(|&&position| position - detection.contact_m > 0.0).count();
        let contact_s = (in_contact as f64 * detection.interval_s).min(duration_s);
        let tally = labels.map(|labels| Tally {
            recordings: 1,
            ruptures: labels.len(),
            alarms: alarms_s.len(),
            delays_s: matches.iter().map(|announced| announced.delay_s).collect(),
            recorded_s: duration_s,
            contact_s,
        });
        let scores = tally.as_ref().map(Scores::of);
        let intervals = PhaseRule::default().split(&detection.position_m, detection.interval_s, detection.contact_m);
        Self {
            samples: detection.time_s.len(),
            interval_s: detection.interval_s,
            start_s,
            duration_s,
            contact_s,
            touched: detection.touched,
            alarms: detection.alarms.iter().enumerate().map(alarm).collect(),
            labelled_ruptures_s,
            labelled_kinds: labels.unwrap_or_default().iter().map(|label| label.kind.clone()).collect(),
            missed_ruptures: scores.map(|scores| scores.missed),
            false_alarms: scores.map(|scores| scores.false_alarms),
            window_s,
            scores,
            residual: ResidualStatistics::of(&detection.residual_n),
            phases: PhaseStatistics::all(detection, &intervals),
            intervals,
            tally,
            further_estimate: ExtraParameterEstimate::of(&detection.extra_parameter),
        }
    }

    /// The labels that no alarm announces, by their place among the labels.
    pub fn missed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.labelled_ruptures_s.len()).filter(|&label| self.alarms.iter().all(|alarm| alarm.label != Some(label)))
    }
}
