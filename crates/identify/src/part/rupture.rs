use super::signals::Signals;
use crate::filter::half;
use crate::measured::span;

/// Duration of a rupture.
const FALL_S: f64 = 5e-3;

/// Share of the force's range so far, or of half the whole range.
const FALL_SHARE: f64 = 0.4;

/// Multiple of the median change of the force in the same time.
const UNUSUAL: f64 = 4.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rupture {
    /// The first excluded sample, after the last one under full force.
    pub(super) sample: usize,
    pub(super) force_n: f64,
    pub(super) position_m: f64,
    /// Median of the 50 ms after the rupture.
    pub(super) after_n: f64,
}

impl Rupture {
    /// The first large fall of the force within 5 ms in which the needle does not retreat. The force must stay low,
    /// which excludes single wrong samples.
    pub(super) fn of(signals: &Signals) -> Option<Self> {
        let Signals { force_n, position_m, interval_s, .. } = signals;
        let window = half(FALL_S, *interval_s);
        let range_n = span(force_n);
        let changes: Vec<f64> = force_n.windows(window + 1).map(|part| (part[window] - part[0]).abs()).collect();
        let least_n = UNUSUAL * median(&changes);
        let (mut low_n, mut high_n) = (f64::INFINITY, f64::NEG_INFINITY);
        for end in window..force_n.len() {
            let from = end - window;
            (low_n, high_n) = (low_n.min(force_n[from]), high_n.max(force_n[from]));
            let fall_n = least_n.max(FALL_SHARE * (high_n - low_n).max(0.5 * range_n));
            let later = &force_n[end..force_n.len().min(end + 10 * window)];
            let falls = force_n[from] - force_n[end] > fall_n && position_m[end] >= position_m[from];
            if falls && later.len() > window && median(later) < force_n[from] - fall_n {
                let is_whole = |k: &usize| force_n[*k] > force_n[from] - 0.1 * fall_n;
                let last = (from..end).rev().find(is_whole).unwrap_or(from);
                let (force_n, position_m) = (force_n[last], position_m[last]);
                return Some(Self { sample: last + 1, force_n, position_m, after_n: median(later) });
            }
        }
        None
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Part;

    fn signals(at: impl Fn(f64) -> (f64, f64)) -> Signals {
        let rows: Vec<(f64, f64)> = (0..2000).map(|k| at(f64::from(k) * 1e-3)).collect();
        let (position_m, force_n) = rows.into_iter().unzip();
        Signals::new("synthetic", Part::Tissue, 1e-3, position_m, force_n, None).expect("a recording")
    }

    #[test]
    fn a_fall_of_the_force_without_retreat_is_a_rupture() {
        // 5 mm/s into 300 N/m; at 1.5 s the layer ruptures and 0.1 N remain.
        let force_n = |t: f64| if t < 1.5 { 1.5 * t } else { 0.1 };
        let rupture = Rupture::of(&signals(|t| (5e-3 * t, force_n(t)))).expect("a rupture");
        assert_eq!(rupture.sample, 1500);
        assert!((rupture.force_n - 2.25).abs() < 0.01 && (rupture.after_n - 0.1).abs() < 1e-12, "{rupture:?}");
    }

    #[test]
    fn a_retreat_a_wrong_sample_and_noise_are_none() {
        let wave = |t: f64| 0.01 * (60.0 * t).sin();
        assert_eq!(Rupture::of(&signals(|t| (wave(t), 300.0 * wave(t).max(0.0)))), None);
        let spike = |t: f64| if (t - 1.2).abs() < 1e-6 { 0.0 } else { 1.5 * t };
        assert_eq!(Rupture::of(&signals(|t| (5e-3 * t, spike(t)))), None);
        let noise = |t: f64| 0.01 * (1700.0 * t).sin();
        assert_eq!(Rupture::of(&signals(|t| (5e-3 * t, noise(t)))), None);
    }
}
