//! Diverged runs do not affect the limits.

use trocar_document::figure::{Axis, Y_TICKS, quantile_extent, union};

pub(super) struct Signal<'a> {
    time_s: &'a [f64],
    values: &'a [f64],
    scale: f64,
    /// Maximum magnitude, in the unit of `values`, of a run that has not diverged.
    plausible: f64,
}

/// Maximum plausible force in N: above any needle insertion.
const PLAUSIBLE_FORCE_N: f64 = 1e3;
/// Maximum plausible distance in m: above the length of any needle.
const PLAUSIBLE_POSITION_M: f64 = 1.0;

impl<'a> Signal<'a> {
    pub(super) fn force(time_s: &'a [f64], values: &'a [f64]) -> Self {
        Self { time_s, values, scale: 1.0, plausible: PLAUSIBLE_FORCE_N }
    }

    /// Displayed in mm.
    pub(super) fn position(time_s: &'a [f64], values: &'a [f64]) -> Self {
        Self { time_s, values, scale: 1e3, plausible: PLAUSIBLE_POSITION_M }
    }
}

/// A common axis for all signals within `window`. Signals that diverge there are ignored, unless all diverge.
pub(super) fn shared(signals: &[Signal<'_>], window: (f64, f64)) -> Axis {
    let mut plausible = None;
    let mut all = None;
    for signal in signals {
        let inside = || {
            let samples = signal.time_s.iter().zip(signal.values);
            samples.filter(|(time, _)| (window.0..=window.1).contains(*time)).map(|(_, &v)| v)
        };
        let scaled = |(low, high): (f64, f64)| (low * signal.scale, high * signal.scale);
        let (mut range, mut is_plausible) = ((f64::INFINITY, f64::NEG_INFINITY), true);
        for v in inside() {
            is_plausible &= v.abs() <= signal.plausible;
            range = (range.0.min(v), range.1.max(v));
        }
        if is_plausible && range.0 <= range.1 {
            plausible = union(plausible, Some(scaled(range)));
        } else {
            let bounded = inside().filter(|v| v.abs() <= signal.plausible);
            all = union(all, quantile_extent(bounded, 0.95).map(scaled));
        }
    }
    Axis::padded(plausible.or(all).unwrap_or((0.0, 1.0)), Y_TICKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diverged_run_does_not_hide_the_others() {
        let time_s: Vec<f64> = (0..100).map(f64::from).collect();
        let stable: Vec<f64> = time_s.iter().map(|t| t * 0.05).collect();
        let diverged: Vec<f64> = time_s.iter().map(|t| t.exp()).collect();
        let signal = |values| Signal { time_s: &time_s, values, scale: 1.0, plausible: 1e3 };
        let both = shared(&[signal(&stable), signal(&diverged)], (0.0, 100.0));
        assert!(both.high < 6.0);
        assert!(shared(&[signal(&diverged)], (0.0, 100.0)).high < 1.1e3);
        assert!(shared(&[], (0.0, 1.0)).high > 0.0);
    }
}
