use crate::interrupt;

/// Ratio of a Gaussian's standard deviation to its median absolute deviation.
const GAUSSIAN_MAD: f64 = 1.4826;

/// The quantile at `share` (0 to 1), interpolated linearly between order statistics (`of_rank`; 0 is the smallest).
pub fn quantile(count: u64, share: f64, of_rank: impl Fn(u64) -> f64) -> Option<f64> {
    let last = count.checked_sub(1)?;
    let place = share * last as f64;
    let below = place as u64;
    let (here, next) = (of_rank(below), of_rank((below + 1).min(last)));
    Some(here + (place - below as f64) * (next - here))
}

/// [`quantile`] that reorders the values without sorting them completely.
pub fn quantile_of(values: &mut [f64], share: f64) -> Option<f64> {
    let below = (share * values.len().checked_sub(1)? as f64) as usize;
    let (_, _, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    if let Some(next) = (0..above.len()).min_by(|a, b| above[*a].total_cmp(&above[*b])) {
        above.swap(0, next);
    }
    quantile(values.len() as u64, share, |rank| values[rank as usize])
}

/// Ranks, from 0, of the median's 95 % interval for any distribution and `count > 0`: `n/2 ± 1.96 √n/2`, rounded
/// outwards (sign test); the whole range for fewer than six values.
pub fn median_ranks(count: u64) -> (u64, u64) {
    let half = 0.5 * count as f64;
    let half_width = 1.96 * half.sqrt() / std::f64::consts::SQRT_2;
    let low = (half - half_width).floor().max(1.0) as u64 - 1;
    (low, count - 1 - low)
}

pub fn upper_median(values: &[f64]) -> Option<f64> {
    order_statistic(values.len(), |visit| visit(values), values.len() / 2)
}

/// 1.4826 times the median absolute deviation from the median (both upper medians) over all parts.
pub fn robust_std(parts: &[&[f64]]) -> Option<f64> {
    let count = parts.iter().map(|part| part.len()).sum();
    let middle = count / 2;
    let median = order_statistic(count, |visit| parts.iter().for_each(|part| visit(part)), middle)?;
    let deviations = |visit: &mut dyn FnMut(&[f64])| {
        let mut deviations = [0.0; AT_ONCE];
        for block in parts.iter().flat_map(|part| part.chunks(AT_ONCE)) {
            deviations.iter_mut().zip(block).for_each(|(deviation, value)| *deviation = (value - median).abs());
            visit(&deviations[..block.len()]);
        }
    };
    Some(GAUSSIAN_MAD * order_statistic(count, deviations, middle)?)
}

/// Values per block for [`order_statistic`].
pub const AT_ONCE: usize = 512;

/// Values selected in memory, sample size, and distance in ranks of the bounds: four standard deviations.
const MAX_SELECTED: usize = 1 << 16;
const SAMPLE: usize = 1 << 14;
const MARGIN: usize = 4 * 64;

/// The value of a rank (0 is the smallest), by [`f64::total_cmp`]. `visit_all` must pass the same blocks at every call.
///
/// Two bounds from a sample almost certainly enclose it. One pass counts the values below and keeps those between
/// (Floyd and Rivest, *Communications of the ACM* 18, 1975), without copying millions of values.
pub fn order_statistic(count: usize, visit_all: impl Fn(&mut dyn FnMut(&[f64])), rank: usize) -> Option<f64> {
    interrupt::check();
    if rank >= count {
        return None;
    }
    let between = if count > MAX_SELECTED { between_bounds(&visit_all, count, rank) } else { None };
    let among_all = || {
        let mut keys = Vec::with_capacity(count);
        visit_all(&mut |values| keys.extend(values.iter().map(key)));
        select(keys, rank)
    };
    Some(of_key(between.unwrap_or_else(among_all)))
}

/// `None` if the bounds do not enclose the rank.
fn between_bounds(visit_all: impl Fn(&mut dyn FnMut(&[f64])), count: usize, rank: usize) -> Option<u64> {
    let (step, mut next, mut sample) = (count / SAMPLE, 0, Vec::with_capacity(2 * SAMPLE));
    visit_all(&mut |values| {
        while let Some(value) = values.get(next) {
            sample.push(key(value));
            next += step;
        }
        next -= values.len();
    });
    sample.sort_unstable();
    let place = (rank as f64 / count as f64 * sample.len() as f64) as usize;
    let low = place.checked_sub(MARGIN).map_or(0, |place| sample[place]);
    let high = sample.get(place + MARGIN).copied().unwrap_or(u64::MAX);
    let (mut below, mut at_low, mut at_high, mut between) = (0, 0, 0, vec![]);
    visit_all(&mut |values| {
        // Two loops avoid unpredictable branches.
        below += values.iter().map(|value| usize::from(key(value) < low)).sum::<usize>();
        for key in values.iter().map(key).filter(|key| key.wrapping_sub(low) <= high - low) {
            if key == low {
                at_low += 1;
            } else if key == high {
                at_high += 1;
            } else {
                between.push(key);
            }
        }
    });
    let rank = rank.checked_sub(below)?;
    match rank.checked_sub(at_low) {
        None => Some(low),
        Some(rank) if rank < between.len() => Some(select(between, rank)),
        Some(rank) => (rank - between.len() < at_high).then_some(high),
    }
}

fn select(mut keys: Vec<u64>, rank: usize) -> u64 {
    *keys.select_nth_unstable(rank).1
}

/// Has the order of [`f64::total_cmp`].
#[inline(always)]
fn key(value: &f64) -> u64 {
    let bits = value.to_bits();
    // Without an unpredictable branch: inverts all bits of a negative number, otherwise the sign bit.
    bits ^ ((bits.cast_signed() >> 63).cast_unsigned() | 1 << 63)
}

fn of_key(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

/// `Φ(x)`.
pub fn normal_share(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

/// `Φ⁻¹(share)`, limited to ±38.
pub fn normal_quantile(share: f64) -> f64 {
    bisect(-38.0, 38.0, |x| normal_share(x) < share)
}

/// The point at which `below` changes from true to false, to 2⁻⁶⁴ of the interval.
pub fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if below(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// With mean 0 and variance 1; equal values have their mean rank. `None` if all are equal or one is NaN.
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

/// Spearman's; `None` if a variable is constant or a value is NaN.
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
    fn the_upper_median_and_the_robust_deviation_are_order_statistics() {
        assert_eq!(upper_median(&[4.0, 1.0, 3.0, 2.0]), Some(3.0));
        // The deviations from 3 are 2, 1, 0 and 97, so their upper median is 2.
        let robust_std = |values: &[f64]| robust_std(&[values]);
        assert_eq!(robust_std(&[1.0, 2.0, 3.0, 100.0]), Some(1.4826 * 2.0));
        assert_eq!(super::robust_std(&[&[1.0, 2.0], &[], &[3.0, 100.0]]), Some(1.4826 * 2.0));
        assert_eq!((upper_median(&[]), robust_std(&[])), (None, None));
    }

    #[test]
    fn an_order_statistic_agrees_with_the_sorted_values() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let wide: Vec<f64> = (0..5000).map(|_| next() * 1e3_f64.powf(8.0 * next())).collect();
        // More values than are selected in memory; they differ in the last bits.
        let narrow: Vec<f64> =
            (0..100_000).map(|_| f64::from_bits(1.0_f64.to_bits() + (1e5 * (next() + 0.5)) as u64)).collect();
        // Few values many times; and a sample with equal values, while all other values are smaller.
        let few: Vec<f64> = (0..100_000).map(|_| (3.0 * next()).round()).collect();
        let misleading: Vec<f64> = (0..131_072).map(|k| if k % 8 == 0 { 1.0 } else { next() }).collect();
        let special = vec![0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, -1.0, 1.0];
        for values in [wide, narrow, few, misleading, special, vec![-0.25; 70_000]] {
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            for rank in (0..values.len()).step_by(values.len() / 7) {
                let found = order_statistic(values.len(), |visit| values.chunks(1000).for_each(&mut *visit), rank);
                assert_eq!(found.map(f64::to_bits), Some(sorted[rank].to_bits()), "{rank} of {}", values.len());
            }
            assert_eq!(order_statistic(values.len(), |visit| visit(&values), values.len()), None);
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
    fn the_rank_correlation_depends_on_the_order_of_values() {
        let close = |pairs: &[(f64, f64)], expected: f64| {
            assert!((rank_correlation(pairs).expect("both vary") - expected).abs() < 1e-12, "{pairs:?}");
        };
        close(&[(1.0, 10.0), (2.0, 20.0), (3.0, 25.0)], 1.0);
        close(&[(1.0, 3.0), (2.0, 2.0), (3.0, 1.0)], -1.0);
        // The ranks are 0.5, 0.5, 2 and 0, 1, 2.
        close(&[(1.0, 1.0), (1.0, 2.0), (5.0, 3.0)], 0.75_f64.sqrt());
        assert_eq!(rank_correlation(&[(1.0, 3.0), (1.0, 2.0)]), None);
    }
}
