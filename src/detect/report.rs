//! What a detection says in numbers.

use serde::Serialize;

use super::Detection;
use crate::metrics::RUPTURE_WINDOW_S;

/// An alarm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DetectedAlarm {
    /// When, in the recording's own time, in s.
    pub time_s: f64,
    /// Which sample, from 0.
    pub sample: usize,
    /// Where the needle was, in m.
    pub position_m: f64,
    /// The measured force, in N.
    pub force_n: f64,
    /// The residual, in N.
    pub residual_n: f64,
    /// From the labelled rupture that it announces, in s; none if it announces none.
    pub delay_s: Option<f64>,
}

/// The residual over the whole recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ResidualStatistics {
    /// Mean, in N.
    pub mean_n: f64,
    /// Standard deviation, in N.
    pub std_n: f64,
    /// Mean of the magnitude, in N.
    pub mean_absolute_n: f64,
    /// Largest magnitude, in N.
    pub greatest_absolute_n: f64,
    /// 1.4826 times the median deviation from the median, in N: the spread that outliers do not move.
    pub robust_std_n: f64,
}

/// What was estimated besides stiffness and damping, over a whole run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FurtherEstimate {
    /// Its column, with its unit.
    pub column: &'static str,
    /// The upper median.
    pub median: f64,
    /// The last value.
    pub last: f64,
}

impl FurtherEstimate {
    /// Sums a column up; none where there is none, or nothing in it.
    #[must_use]
    pub fn of(further: &Option<(&'static str, Vec<f64>)>) -> Option<Self> {
        let (column, values) = further.as_ref()?;
        Some(Self { column, median: median_of(values.clone()), last: *values.last()? })
    }
}

/// What came out of a detection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectionReport {
    /// How many samples there were.
    pub samples: usize,
    /// How long the recording is, in s.
    pub duration_s: f64,
    /// Whether the needle was ever below the contact.
    pub touched: bool,
    /// The alarms, in time order.
    pub alarms: Vec<DetectedAlarm>,
    /// Labelled ruptures, in the recording's own time, in s.
    pub labelled_ruptures_s: Vec<f64>,
    /// Labelled ruptures without an alarm; none where there are no labels.
    pub missed_ruptures: Option<usize>,
    /// Alarms without a labelled rupture; none where there are no labels.
    pub false_alarms: Option<usize>,
    /// The residual's statistics.
    pub residual: ResidualStatistics,
    /// What was estimated besides stiffness and damping, if anything was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub further_estimate: Option<FurtherEstimate>,
}

impl DetectionReport {
    /// Sums a detection up. `ruptures_s` are labels in s after the first sample; each is announced by the first alarm
    /// within [`RUPTURE_WINDOW_S`] after it.
    #[must_use]
    pub fn of(detection: &Detection, ruptures_s: &[f64]) -> Self {
        let start_s = detection.time_s.first().copied().unwrap_or(0.0);
        let labelled_ruptures_s: Vec<f64> = ruptures_s.iter().map(|rupture| start_s + rupture).collect();
        let mut claimed = vec![false; labelled_ruptures_s.len()];
        let mut claim = |time_s: f64| {
            let announces = |&rupture: &f64| (0.0..=RUPTURE_WINDOW_S).contains(&(time_s - rupture));
            // The latest label first: an alarm is about what has just happened.
            let label = (0..claimed.len()).rev().find(|&i| !claimed[i] && announces(&labelled_ruptures_s[i]))?;
            claimed[label] = true;
            // To the nanosecond: the difference of two decimal times is no decimal.
            Some(((time_s - labelled_ruptures_s[label]) * 1e9).round() / 1e9)
        };
        let alarms: Vec<DetectedAlarm> = detection
            .alarms
            .iter()
            .map(|&sample| DetectedAlarm {
                time_s: detection.time_s[sample],
                sample,
                position_m: detection.position_m[sample],
                force_n: detection.measured_force_n[sample],
                residual_n: detection.residual_n[sample],
                delay_s: claim(detection.time_s[sample]),
            })
            .collect();
        let labelled = !labelled_ruptures_s.is_empty();
        let matched = alarms.iter().filter(|alarm| alarm.delay_s.is_some()).count();
        Self {
            samples: detection.time_s.len(),
            touched: detection.touched,
            duration_s: detection.time_s.last().copied().unwrap_or(0.0) - start_s,
            missed_ruptures: labelled.then(|| labelled_ruptures_s.len() - matched),
            false_alarms: labelled.then(|| alarms.len() - matched),
            alarms,
            labelled_ruptures_s,
            residual: statistics(&detection.residual_n),
            further_estimate: FurtherEstimate::of(&detection.further),
        }
    }
}

/// The upper median; 0 of nothing.
fn median_of(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn statistics(residual: &[f64]) -> ResidualStatistics {
    let count = residual.len().max(1) as f64;
    let mean_n = residual.iter().sum::<f64>() / count;
    let variance = residual.iter().map(|e| (e - mean_n).powi(2)).sum::<f64>() / count;
    let median = median_of(residual.to_vec());
    let deviation = median_of(residual.iter().map(|e| (e - median).abs()).collect());
    let mut magnitudes: Vec<f64> = residual.iter().map(|e| e.abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    ResidualStatistics {
        mean_n,
        std_n: variance.sqrt(),
        mean_absolute_n: magnitudes.iter().sum::<f64>() / count,
        greatest_absolute_n: magnitudes.last().copied().unwrap_or(0.0),
        robust_std_n: 1.4826 * deviation,
    }
}
