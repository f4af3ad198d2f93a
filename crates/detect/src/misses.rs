use schemars::JsonSchema;
use serde::Serialize;

use super::{Detection, Match};
use trocar_base::warning::Warning;
use trocar_core::time::nearest_ticks;
use trocar_metrics::{DetectorSample, Miss, MissRule, SupervisorHistory};

/// The reason why a labelled rupture was missed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LabelMiss {
    /// Index of the label, from 0.
    pub label: usize,
    /// Time of the rupture in the recording, in s.
    pub time_s: f64,
    /// The reason.
    #[serde(flatten)]
    pub miss: Miss,
}

impl LabelMiss {
    pub(super) fn warning(&self) -> Warning {
        self.miss.warning(self.label + 1, self.time_s)
    }
}

/// An alarm belongs to a label if it is at most `within_s` after it.
pub(super) fn misses(detection: &Detection, labels_s: &[f64], matches: &[Match], within_s: f64) -> Vec<LabelMiss> {
    let start_s = detection.time_s.first().copied().unwrap_or(0.0);
    let rule = MissRule {
        tick_s: detection.interval_s,
        start_s,
        window_s: within_s,
        detector: &detection.detector,
        refractory_s: 0.0,
    };
    let supervisor = SupervisorHistory::of_alarms(&detection.alarms);
    let missed = (0..labels_s.len()).filter(|label| matches.iter().all(|matched| matched.label != *label));
    let explain = |label: usize| {
        let first = nearest_ticks((labels_s[label] - start_s).max(0.0), detection.interval_s);
        let last = first.saturating_add(rule.window_ticks()).min(detection.time_s.len().saturating_sub(1) as u64);
        let samples: Vec<_> = (first..=last).map(|sample| (sample, sample_at(detection, sample as usize))).collect();
        let miss = rule.explain(first, &samples, &supervisor)?;
        Some(LabelMiss { label, time_s: labels_s[label], miss })
    };
    missed.filter_map(explain).collect()
}

fn sample_at(detection: &Detection, sample: usize) -> DetectorSample {
    let threshold = detection.detector.cusum.threshold;
    let is_quiet = |at: &usize| detection.conditions[*at].in_contact() && detection.decision[*at] <= threshold;
    let settle = nearest_ticks(detection.detector.arming.settle_s, detection.interval_s) as usize;
    let quiet = (0..sample).rev().take(settle).take_while(is_quiet).count();
    DetectorSample {
        distance: detection.distance[sample],
        decision: detection.decision[sample],
        conditions: detection.conditions[sample].with_quiet(quiet as f64),
        depth_m: detection.position_m[sample] - detection.contact_m,
        velocity_m_per_s: detection.velocity_m_per_s[sample],
    }
}
