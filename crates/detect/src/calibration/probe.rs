//! Ruptures added to a recording.

use super::Candidate;
use super::signal::{Residuals, Signal};

const BEFORE_S: f64 = 0.6;
const AFTER_S: f64 = 0.1;

#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    pub(super) duration_s: f64,
    pub(super) remaining_share: f64,
}

pub(super) fn delays(signal: &Signal<'_>, probes: &[usize], fall: Fall, candidate: &Candidate) -> Vec<Option<f64>> {
    probes.iter().map(|&probe| delay(signal, probe, fall, candidate)).collect()
}

fn delay(signal: &Signal<'_>, probe: usize, fall: Fall, candidate: &Candidate) -> Option<f64> {
    let from = probe.saturating_sub(signal.samples_in(BEFORE_S, 1));
    let to = probe.saturating_add(signal.samples_in(AFTER_S.max(1.2 * fall.duration_s), 1)).min(signal.force_n.len());
    let force_n: Vec<f64> = (from..to)
        .map(|sample| {
            let since_s = sample.saturating_sub(probe) as f64 * signal.interval_s;
            let fallen = (since_s / fall.duration_s).min(1.0) * (1.0 - fall.remaining_share);
            signal.force_n[sample] * (1.0 - fallen)
        })
        .collect();
    let probed = Signal {
        interval_s: signal.interval_s,
        position_m: &signal.position_m[from..to],
        velocity_m_per_s: &signal.velocity_m_per_s[from..to],
        force_n: &force_n,
    };
    let residuals = Residuals::of(&probed, &candidate.estimator, candidate.contact_m);
    let alarms = residuals.alarms(&probed, &candidate.detector);
    let first = alarms.into_iter().find(|alarm| from + alarm >= probe)?;
    Some((from + first - probe) as f64 * signal.interval_s)
}
