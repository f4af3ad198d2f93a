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
pub fn upper_median(values: &[f64]) -> Option<f64> {
    order_statistic(|| values.iter().copied(), values.len() / 2)
}

/// 1.4826 times the median absolute deviation from the median, both upper medians: a standard deviation that is robust
/// to outliers; `None` without values. `values` returns the same values at every call.
pub fn robust_std<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> Option<f64> {
    let middle = values().count() / 2;
    let median = order_statistic(&values, middle)?;
    Some(GAUSSIAN_MAD * order_statistic(|| values().map(|value| (value - median).abs()), middle)?)
}

/// Bits of a key that one pass of [`order_statistic`] counts, and the number of values that are selected in memory.
const RADIX_BITS: u32 = 16;
const MAX_SELECTED: usize = 1 << 16;

/// The order statistic of a rank (0 is the smallest) by [`f64::total_cmp`]; `None` beyond the last. `values` returns the same values
/// at every call.
///
/// Each pass counts the values by the next 16 bits of their keys, which are ordered as they are, and keeps the part that has the rank:
/// millions of values are neither copied nor moved.
pub fn order_statistic<I: Iterator<Item = f64>>(values: impl Fn() -> I, mut rank: usize) -> Option<f64> {
    // The leading bits of the key that are known, how many they are, and the number of keys with them.
    let (mut prefix, mut known, mut count) = (0_u64, 0, values().count());
    let keys = |prefix: u64, known: u32| {
        values().map(key).filter(move |key| known == 0 || key >> (u64::BITS - known) == prefix)
    };
    let mut counts = vec![];
    while known < u64::BITS {
        if count <= MAX_SELECTED {
            let mut keys: Vec<u64> = keys(prefix, known).collect();
            return (rank < count).then(|| of_key(*keys.select_nth_unstable(rank).1));
        }
        counts.clear();
        counts.resize(1 << RADIX_BITS, 0);
        let shift = u64::BITS - known - RADIX_BITS;
        keys(prefix, known).for_each(|key| counts[(key >> shift) as usize & ((1 << RADIX_BITS) - 1)] += 1);
        let mut up_to = 0;
        let bucket = counts.iter().position(|in_bucket| {
            up_to += in_bucket;
            up_to > rank
        })?;
        count = counts[bucket];
        rank -= up_to - count;
        (prefix, known) = (prefix << RADIX_BITS | bucket as u64, known + RADIX_BITS);
    }
    Some(of_key(prefix))
}

/// A number that is ordered as the value is by [`f64::total_cmp`].
#[inline(always)]
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn of_key(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
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
        assert_eq!(upper_median(&[4.0, 1.0, 3.0, 2.0]), Some(3.0));
        // Deviations 2, 1, 0 and 97 from 3: their upper median is 2.
        let robust_std = |values: &[f64]| robust_std(|| values.iter().copied());
        assert_eq!(robust_std(&[1.0, 2.0, 3.0, 100.0]), Some(1.4826 * 2.0));
        assert_eq!((upper_median(&[]), robust_std(&[])), (None, None));
    }

    #[test]
    fn an_order_statistic_is_that_of_the_sorted_values() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let wide: Vec<f64> = (0..5000).map(|_| next() * 1e3_f64.powf(8.0 * next())).collect();
        // More than fit into memory of one selection, in one bucket of 16 bits; they differ in the last bits.
        let narrow: Vec<f64> =
            (0..100_000).map(|_| f64::from_bits(1.0_f64.to_bits() + (1e5 * (next() + 0.5)) as u64)).collect();
        let special = vec![0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, -1.0, 1.0];
        for values in [wide, narrow, special, vec![-0.25; 70_000]] {
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            for rank in (0..values.len()).step_by(values.len() / 7) {
                let found = order_statistic(|| values.iter().copied(), rank).map(f64::to_bits);
                assert_eq!(found, Some(sorted[rank].to_bits()), "{rank} of {}", values.len());
            }
            assert_eq!(order_statistic(|| values.iter().copied(), values.len()), None);
        }
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
