pub(crate) fn half(half_s: f64, interval_s: f64) -> usize {
    ((half_s / interval_s).round() as usize).max(1)
}

/// Linear between samples and constant beyond the ends.
pub(crate) fn delayed(values: &[f64], sample: usize, delay_s: f64, interval_s: f64) -> f64 {
    let last = values.len() - 1;
    let place = (sample as f64 - delay_s / interval_s).clamp(0.0, last as f64);
    let (left, share) = (place as usize, place.fract());
    values[left] + share * (values[(left + 1).min(last)] - values[left])
}

/// Least-squares slope per s over `half` samples on each side: `Σ k x_{i+k} / (h Σ k²)`. The ends repeat the first and
/// last whole window.
pub(crate) fn slope(values: &[f64], half: usize, interval_s: f64) -> Vec<f64> {
    let half = half.min(values.len().saturating_sub(1) / 2).max(1);
    let weight: f64 = (1..=half).map(|k| 2.0 * (k * k) as f64).sum::<f64>() * interval_s;
    let last = values.len().saturating_sub(1 + half);
    let at = |index: usize| {
        let centre = index.clamp(half.min(last), last);
        let pairs = (1..=half).map(|k| k as f64 * (values[centre + k] - values[centre - k]));
        pairs.sum::<f64>() / weight
    };
    if values.len() < 3 { vec![0.0; values.len()] } else { (0..values.len()).map(at).collect() }
}

/// Slope per s of the least-squares cubic: `Σ k (S₆ - S₄ k²) x_{i+k} / (h (S₂ S₆ - S₄²))` with `S_n = Σ kⁿ`. It
/// attenuates fast motions less than a line.
pub(crate) fn cubic_slope(values: &[f64], half: usize, interval_s: f64) -> Vec<f64> {
    let weights: Vec<Vec<f64>> = (0..=half).map(|half| cubic_weights(half, interval_s)).collect();
    let last = values.len().saturating_sub(1);
    let at = |index: usize| {
        let half = half.min(index).min(last - index);
        if half == 0 {
            return (values[(index + 1).min(last)] - values[index.saturating_sub(1)]) / interval_s;
        }
        let pairs = weights[half].iter().zip(1..).map(|(weight, k)| weight * (values[index + k] - values[index - k]));
        pairs.sum::<f64>()
    };
    (0..values.len()).map(at).collect()
}

fn cubic_weights(half: usize, interval_s: f64) -> Vec<f64> {
    if half < 2 {
        return vec![0.5 / interval_s; half];
    }
    let sum = |power: i32| (1..=half).map(|k| 2.0 * (k as f64).powi(power)).sum::<f64>();
    let (s2, s4, s6) = (sum(2), sum(4), sum(6));
    let weight = |k: f64| k * (s6 - s4 * k * k) / (interval_s * (s2 * s6 - s4 * s4));
    (1..=half).map(|k| weight(k as f64)).collect()
}

/// A moving mean, twice. Ends, within `2 half` samples, are means over fewer samples.
pub(crate) fn smooth(values: &[f64], half: usize) -> Vec<f64> {
    moving_mean(&moving_mean(values, half), half)
}

fn moving_mean(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    sums.extend(values.iter().map(|value| {
        sum += value;
        sum
    }));
    let at = |index: usize| {
        let (from, to) = (index.saturating_sub(half), (index + half + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_parabola_is_its_derivative() {
        let values: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.01).powi(2)).collect();
        let slopes = slope(&values, 3, 0.01);
        for (k, slope) in slopes.iter().enumerate().skip(3).take(44) {
            assert!((slope - 2.0 * k as f64 * 0.01).abs() < 1e-12, "{k}: {slope}");
        }
        assert_eq!(slopes[0], slopes[3]);
        assert_eq!(slope(&[1.0, 2.0], 3, 0.01), [0.0, 0.0]);
    }

    #[test]
    fn the_cubic_slope_of_a_cubic_is_its_derivative() {
        let values: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.01).powi(3)).collect();
        let slopes = cubic_slope(&values, 5, 0.01);
        for (k, slope) in slopes.iter().enumerate().skip(2).take(46) {
            assert!((slope - 3.0 * (k as f64 * 0.01).powi(2)).abs() < 1e-12, "{k}: {slope}");
        }
        let line: Vec<f64> = (0..9).map(|k| 0.5 * f64::from(k)).collect();
        assert!(cubic_slope(&line, 4, 0.5).iter().all(|slope| (slope - 1.0).abs() < 1e-12));
    }

    #[test]
    fn smoothing_keeps_a_line() {
        let values: Vec<f64> = (0..40).map(|k| 3.0 - 0.5 * f64::from(k)).collect();
        let smoothed = smooth(&values, 4);
        let differs = |k: &usize| (smoothed[*k] - values[*k]).abs() > 1e-12;
        assert_eq!((8..32).find(differs), None);
    }
}
