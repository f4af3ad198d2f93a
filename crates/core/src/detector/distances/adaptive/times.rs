use super::aftermath::AftermathTimes;
use super::tare::Tare;
use super::*;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Times {
    pub(super) windows: [usize; WINDOWS_S.len()],
    /// An earlier fall continues by this multiple (window over reference).
    pub(super) trends: [f64; WINDOWS_S.len()],
    pub(super) reference: usize,
    pub(super) stiffness: usize,
    pub(super) instant: usize,
    pub(super) hold: f64,
    pub(super) merge: f64,
    pub(super) stuck: f64,
    /// In 1/s.
    pub(super) per_reference: f64,
    pub(super) per_instant: f64,
    pub(super) scale_share: f64,
    pub(super) stiffness_share: f64,
    pub(super) stiffest_decay: f64,
    pub(super) load_decay: f64,
    pub(super) tare_share: f64,
    pub(super) aftermath: AftermathTimes,
}

impl Times {
    pub(super) fn of(bin_s: f64) -> Self {
        // A bin is at least 1 ms long, so at most 47 are used.
        let bins = |time_s: f64| (libm::round(time_s / bin_s) as usize).max(1);
        let per = |time_s: f64| 1.0 / (bins(time_s) as f64 * bin_s);
        let (windows, reference) = (WINDOWS_S.map(bins), bins(REFERENCE_S));
        Self {
            windows,
            trends: windows.map(|window| window as f64 / reference as f64),
            reference,
            stiffness: bins(STIFFNESS_INTERVAL_S),
            instant: bins(INSTANT_S),
            hold: bins(HOLD_S) as f64,
            merge: bins(MERGE_S) as f64,
            stuck: bins(STUCK_S) as f64,
            per_reference: per(REFERENCE_S),
            per_instant: per(INSTANT_S),
            scale_share: (bin_s / SCALE_MEMORY_S).min(1.0),
            stiffness_share: (bin_s / STIFFNESS_MEMORY_S).min(1.0),
            stiffest_decay: libm::exp(-bin_s / STIFFEST_MEMORY_S),
            load_decay: libm::exp(-bin_s / LOAD_MEMORY_S),
            tare_share: Tare::<f64>::share(bin_s),
            aftermath: AftermathTimes::of(bin_s),
        }
    }
}

impl crate::lane::Stored for Times {
    fn numbers(&mut self, _with: &mut dyn FnMut(&mut u64)) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_to_whole_bins() {
        let times = Times::of(2e-3);
        assert_eq!((times.windows, times.reference, times.stiffness, times.instant), ([1, 2, 4, 8, 16], 8, 4, 2));
        assert_eq!((times.hold, times.stuck), (75.0, 100.0));
        assert_eq!(times.trends, [0.125, 0.25, 0.5, 1.0, 2.0]);
        let is_close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b;
        assert!(is_close(times.per_reference, 1.0 / 16e-3) && is_close(times.per_instant, 1.0 / 4e-3), "{times:?}");
        assert!(is_close(times.scale_share, 2e-3) && is_close(times.stiffness_share, 2e-3 / 0.3), "{times:?}");
        assert!(
            is_close(times.stiffest_decay, (-4e-4_f64).exp()) && is_close(times.load_decay, (-2e-3_f64 / 0.3).exp())
        );
        let slow = Times::of(3.0);
        assert_eq!((slow.scale_share, slow.stiffness_share, slow.windows), (1.0, 1.0, [1; 5]));
    }
}
