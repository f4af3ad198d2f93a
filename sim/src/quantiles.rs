//! Quantiles from order statistics, the confidence interval of a median, a robust standard deviation, ranks, and the
//! standard normal distribution.

/// Ratio of the standard deviation of a Gaussian to its median absolute deviation.
const GAUSSIAN_MAD: f64 = 1.4826;

/// The quantile at `share` (0 to 1) of `count` values, interpolated linearly between two order statistics. `of_rank`
/// gives the order statistics (rank 0 is the smallest). `None` without values.
pub fn quantile(count: u64, share: f64, of_rank: impl Fn(u64) -> f64) -> Option<f64> {
    let last = count.checked_sub(1)?;
    let place = share * last as f64;
    let below = place as u64;
    let (here, next) = (of_rank(below), of_rank((below + 1).min(last)));
    Some(here + (place - below as f64) * (next - here))
}

/// The quantile at `share` (0 to 1) of values, interpolated as by [`quantile`]. It reorders them, without sorting them all. `None`
/// without values.
pub fn quantile_of(values: &mut [f64], share: f64) -> Option<f64> {
    let below = (share * values.len().checked_sub(1)? as f64) as usize;
    let (_, _, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    if let Some(next) = (0..above.len()).min_by(|a, b| above[*a].total_cmp(&above[*b])) {
        above.swap(0, next);
    }
    quantile(values.len() as u64, share, |rank| values[rank as usize])
}

/// The ranks, from 0, of the bounds of the median's 95 % interval; `count` is not 0.
///
/// They are `n/2 ± 1.96 √n/2`, rounded outwards (the normal approximation of the sign test), and assume no
/// distribution. With fewer than six values no such interval reaches 95 %; it is then the whole range.
pub fn median_ranks(count: u64) -> (u64, u64) {
    let half = 0.5 * count as f64;
    let half_width = 1.96 * half.sqrt() / std::f64::consts::SQRT_2;
    let low = (half - half_width).floor().max(1.0) as u64 - 1;
    (low, count - 1 - low)
}

/// The upper median; `None` without values.
pub fn upper_median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// 1.4826 times the median absolute deviation from the median, both upper medians: a standard deviation that is robust
/// to outliers; `None` without values.
pub fn robust_std(values: &[f64]) -> Option<f64> {
    let median = upper_median(values.to_vec())?;
    Some(GAUSSIAN_MAD * upper_median(values.iter().map(|value| (value - median).abs()).collect())?)
}

/// `Φ(x)`: the share of a standard normal distribution below `x`.
#[must_use]
pub fn normal_share(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

/// `Φ⁻¹(share)`, within ±38; 0 and 1 give the ends.
#[must_use]
pub fn normal_quantile(share: f64) -> f64 {
    bisect(-38.0, 38.0, |x| normal_share(x) < share)
}

/// Where `below` ceases to hold between `low`, where it does, and `high`, to 2⁻⁶⁴ of their distance.
pub fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if below(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The ranks of `values`, scaled to mean 0 and variance 1; equal values have their mean rank. `None` if all values are
/// equal, or one is NaN.
pub fn standard_ranks(values: &[f64]) -> Option<Vec<f64>> {
    if values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    while start < order.len() {
        let same = order[start..].iter().take_while(|&&k| values[k] == values[order[start]]).count();
        let mean = start as f64 + 0.5 * (same as f64 - 1.0);
        order[start..start + same].iter().for_each(|&k| ranks[k] = mean);
        start += same;
    }
    let n = ranks.len() as f64;
    let mean = ranks.iter().sum::<f64>() / n;
    let deviation = (ranks.iter().map(|rank| (rank - mean).powi(2)).sum::<f64>() / n).sqrt();
    (deviation > 0.0).then(|| ranks.iter().map(|rank| (rank - mean) / deviation).collect())
}

/// Spearman's rank correlation of pairs; `None` if either does not vary, or one is NaN.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let (a, b) = (standard_ranks(&a)?, standard_ranks(&b)?);
    Some(a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_lies_between_order_statistics() {
        let values = [1.0, 2.0, 4.0];
        let at = |share| quantile(3, share, |rank| values[rank as usize]);
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(at), [1.0, 1.5, 2.0, 3.0, 4.0].map(Some));
        assert_eq!(quantile(0, 0.5, |_| 0.0), None);
        let unordered = |share| quantile_of(&mut [4.0, 1.0, 2.0], share);
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(unordered), [1.0, 1.5, 2.0, 3.0, 4.0].map(Some));
        assert_eq!(quantile_of(&mut [], 0.5), None);
    }

    #[test]
    fn the_upper_median_and_the_spread_about_it_are_of_order_statistics() {
        assert_eq!(upper_median(vec![4.0, 1.0, 3.0, 2.0]), Some(3.0));
        // Deviations 2, 1, 0 and 97 from 3: their upper median is 2.
        assert_eq!(robust_std(&[1.0, 2.0, 3.0, 100.0]), Some(1.4826 * 2.0));
        assert_eq!((upper_median(vec![]), robust_std(&[])), (None, None));
    }

    #[test]
    fn oracle_the_normal_distribution_has_the_quantiles_of_tables() {
        for (share, z) in [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.001, -3.090_232_306_167_813_5)] {
            assert!((normal_quantile(share) - z).abs() < 1e-12, "{share}: {}", normal_quantile(share));
            assert!((normal_share(z) - share).abs() < 1e-12);
        }
        assert!(normal_quantile(0.0) <= -37.0 && normal_quantile(1.0) >= 8.2);
    }

    #[test]
    fn ranks_correlate_as_the_values_are_ordered() {
        let close = |pairs: &[(f64, f64)], expected: f64| {
            assert!((rank_correlation(pairs).expect("both vary") - expected).abs() < 1e-12, "{pairs:?}");
        };
        close(&[(1.0, 10.0), (2.0, 20.0), (3.0, 25.0)], 1.0);
        close(&[(1.0, 3.0), (2.0, 2.0), (3.0, 1.0)], -1.0);
        // Of ranks 0.5, 0.5, 2 and 0, 1, 2.
        close(&[(1.0, 1.0), (1.0, 2.0), (5.0, 3.0)], 0.75_f64.sqrt());
        assert_eq!(rank_correlation(&[(1.0, 3.0), (1.0, 2.0)]), None);
    }
}
