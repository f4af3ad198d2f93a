use std::f64::consts::TAU;

use trocar_base::interrupt;

/// Changes of at least `min` from each peak to the next trough and back.
pub(super) fn swings(values: &[f64], min: f64) -> Vec<f64> {
    interrupt::check();
    let Some(&first) = values.first() else { return vec![] };
    let (mut low, mut high, mut is_rising) = (first, first, None);
    let mut all = vec![];
    for &value in values {
        match is_rising {
            None => {
                (low, high) = (low.min(value), high.max(value));
                if high - low >= min {
                    is_rising = Some(value == high);
                }
            }
            Some(true) => {
                high = high.max(value);
                if high - value >= min {
                    all.push(high - low);
                    (low, is_rising) = (value, Some(false));
                }
            }
            Some(false) => {
                low = low.min(value);
                if value - low >= min {
                    all.push(high - low);
                    (high, is_rising) = (value, Some(true));
                }
            }
        }
    }
    all
}

pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

pub(super) fn range(values: &[f64]) -> f64 {
    interrupt::check();
    let bounds = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(bounds, |(low, high), value| (low.min(*value), high.max(*value)));
    (high - low).max(0.0)
}

/// The strength of a motion: the standard deviation of the changes from sample to sample, weighted by a Hann window,
/// `1 - cos(2π (k + 1/2) / N)`, against incomplete periods at the ends.
///
/// Offset and drift have no effect. Unlike the distance from peak to trough, it does not beat with the samples for
/// periods of two or three samples.
pub(super) fn strength(values: &[f64]) -> f64 {
    interrupt::check();
    let count = values.len().saturating_sub(1);
    let turn = TAU / count.max(1) as f64;
    let weighted =
        || values.windows(2).enumerate().map(|(k, pair)| (1.0 - libm::cos(turn * (k as f64 + 0.5)), pair[1] - pair[0]));
    let mean_of = |of: &dyn Fn(f64) -> f64| {
        let (sum, weights) =
            weighted().fold((0.0, 0.0), |(sum, all), (weight, change)| (sum + weight * of(change), all + weight));
        if weights > 0.0 { sum / weights } else { 0.0 }
    };
    let mean = mean_of(&|change| change);
    mean_of(&|change| (change - mean) * (change - mean)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(amplitude: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..2000).map(|k| f64::from(k) * 1e-3).map(|t| amplitude(t) * (20.0 * t).sin()).collect()
    }

    #[test]
    fn swings_go_from_peak_to_trough() {
        let all = swings(&wave(|_| 0.5e-3), 1e-4);
        assert!(all.len() >= 11 && all.iter().skip(1).all(|swing| (swing - 1e-3).abs() < 1e-6), "{all:?}");
        assert!(swings(&wave(|_| 1e-5), 1e-4).is_empty());
        assert!(swings(&[0.0; 100], 1e-4).is_empty() && swings(&[], 1e-4).is_empty());
        let drift: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-5).collect();
        assert!(swings(&drift, 1e-4).is_empty(), "a drift does not reverse");
    }

    #[test]
    fn the_strength_does_not_depend_on_the_drift_or_the_samples_of_a_swing() {
        // For a sine of amplitude A, sampled every T: √2 A sin(ω T / 2).
        let expected = |amplitude: f64, per_sample: f64| 2.0_f64.sqrt() * amplitude * (per_sample / 2.0).sin();
        for per_sample in [0.02, 0.37, TAU / 3.0 + 1e-3, 2.9] {
            let signal: Vec<f64> = (0..2000).map(f64::from).map(|k| 3.0 * (per_sample * k).sin() + 0.1 * k).collect();
            for part in [&signal[..1000], &signal[900..]] {
                let (found, expected) = (strength(part), expected(3.0, per_sample));
                assert!((found - expected).abs() < 2e-3 * expected, "{per_sample}: {found} instead of {expected}");
            }
        }
        assert_eq!((strength(&[]), strength(&[1.0]), strength(&[2.0; 9])), (0.0, 0.0, 0.0));
    }

    #[test]
    fn the_range_of_no_values_is_0_and_their_median_is_undefined() {
        assert_eq!((range(&[1.0, -2.0, 3.0]), range(&[])), (5.0, 0.0));
        assert_eq!((median(vec![3.0, 1.0, 2.0]), median(vec![])), (Some(2.0), None));
    }
}
