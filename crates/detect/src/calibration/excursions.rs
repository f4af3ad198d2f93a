use super::signal::{Residuals, Signal};
use super::spread::median;
use trocar_base::interrupt;

/// Prevents one rupture from hiding the next.
const CAP_THRESHOLDS: f64 = 20.0;

const BEFORE_S: f64 = 20e-3;
const AFTER_S: f64 = 100e-3;
const MEDIAN_S: f64 = 5e-3;
const MIN_SHARE: f64 = 0.25;
const NOISE_STDS: f64 = 10.0;
const MIN_DROP_N: f64 = 0.5;
const MAX_WITHDRAWAL_M: f64 = 0.2e-3;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Excursion {
    /// First sample above 0, and first one back at 0.
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) crossing: Option<usize>,
    /// Maximum in N² while an alarm is possible.
    pub(super) peak: f64,
    pub(super) peak_at: usize,
}

/// Excursions that could raise an alarm; drift and threshold in N².
pub(super) fn excursions(
    signal: &Signal<'_>,
    residuals: &Residuals,
    (drift, threshold): (f64, f64),
    withdrawal_m_per_s: f64,
) -> Vec<Excursion> {
    let mut found = vec![];
    let mut open: Option<Excursion> = None;
    let mut decision = 0.0_f64;
    let count = residuals.residual_n.len();
    for sample in 0..count {
        interrupt::check_at(sample as u64);
        let added = residuals.residual_n[sample] * residuals.residual_n[sample];
        decision = (decision + added - drift).clamp(0.0, CAP_THRESHOLDS * threshold);
        if decision == 0.0 {
            found.extend(open.take().map(|excursion| Excursion { to: sample, ..excursion }));
            continue;
        }
        let begun = Excursion { from: sample, to: count, crossing: None, peak: 0.0, peak_at: sample };
        let excursion = open.get_or_insert(begun);
        if decision > threshold {
            excursion.crossing.get_or_insert(sample);
        }
        let inserting = signal.velocity_m_per_s[sample] >= -withdrawal_m_per_s;
        if residuals.is_drop(sample) && decision > excursion.peak && residuals.depth_m[sample] > 0.0 && inserting {
            (excursion.peak, excursion.peak_at) = (decision, sample);
        }
    }
    found.extend(open);
    found.retain(|excursion| excursion.peak > 0.0);
    found
}

/// Needs samples after the crossing, so a detector cannot use this rule.
pub(super) fn is_rupture(signal: &Signal<'_>, crossing: usize, noise_n: f64) -> bool {
    let Signal { position_m, force_n, .. } = *signal;
    let back = signal.samples_in(BEFORE_S, 5);
    let start = crossing.saturating_sub(back);
    let before = &force_n[start..force_n.len().min(start.saturating_add((back / 2).max(3)))];
    let after = &force_n[crossing..force_n.len().min(crossing.saturating_add(signal.samples_in(AFTER_S, 10)))];
    let width = signal.samples_in(MEDIAN_S, 3);
    let stride = (width / 2).max(1);
    let medians = after.windows(width).step_by(stride).map(|window| median(window).unwrap_or(f64::INFINITY));
    let lowest = medians.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let (Some(before_n), Some((index, after_n))) = (median(before), lowest) else { return false };
    let then = (crossing + index * stride + width / 2).min(position_m.len() - 1);
    let withdrawn_m = position_m[crossing.saturating_sub(2)] - position_m[then];
    let min_n = (MIN_SHARE * before_n.abs()).max(NOISE_STDS * noise_n).max(MIN_DROP_N);
    before_n - after_n > min_n && withdrawn_m <= MAX_WITHDRAWAL_M
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns position, velocity and force at 1 kHz. The velocity is constant, and the force falls from 4 N to `to` N
    /// at sample 500.
    fn fall(to: f64, velocity_m_per_s: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let force = (0..1000).map(|k| if k < 500 { 4.0 } else { to }).collect();
        let position = (0..1000).map(|k| 0.05 + 1e-3 * velocity_m_per_s * f64::from(k)).collect();
        (position, vec![velocity_m_per_s; 1000], force)
    }

    fn ruptures(to: f64, velocity_m_per_s: f64, noise_n: f64) -> bool {
        let (position, velocity, force) = fall(to, velocity_m_per_s);
        let signal = Signal { interval_s: 1e-3, position_m: &position, velocity_m_per_s: &velocity, force_n: &force };
        is_rupture(&signal, 500, noise_n)
    }

    #[test]
    fn a_force_that_drops_during_insertion_is_a_rupture() {
        assert!(ruptures(1.0, 0.01, 0.02));
        assert!(!ruptures(3.2, 0.01, 0.02), "a fifth of the force");
        assert!(!ruptures(1.0, -0.1, 0.02), "the needle is withdrawn");
        assert!(!ruptures(1.0, 0.01, 0.5), "within the noise");
    }

    #[test]
    fn an_excursion_runs_from_zero_to_zero() {
        let residual_n = vec![0.0, -1.0, -1.0, 1.2, 0.0, 0.0, 0.0, 0.0, -2.0];
        let count = residual_n.len();
        let residuals =
            Residuals { residual_n, predicted_n: vec![3.0; count], depth_m: vec![0.01; count], input: vec![] };
        let still = vec![0.0; count];
        let signal = Signal { interval_s: 1e-3, position_m: &still, velocity_m_per_s: &still, force_n: &still };
        // Decision: 0, 0.5, 1, 1.94, 1.44, 0.94, 0.44, 0, 3.5. The rise at sample 3 cannot raise an alarm and is not
        // the peak.
        let found = excursions(&signal, &residuals, (0.5, 0.75), 0.0);
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!((found[0].from, found[0].to, found[0].crossing), (1, 7, Some(2)));
        assert_eq!((found[0].peak, found[1].peak), (1.0, 3.5));
        assert_eq!((found[1].from, found[1].to, found[1].crossing), (8, 9, Some(8)));
    }
}
