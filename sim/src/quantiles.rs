//! Quantiles from order statistics, the confidence interval of a median, and a robust standard deviation.

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

/// `Φ⁻¹(share)`, for a share above 0 and below 1, within ±38; by bisection.
#[must_use]
pub fn normal_quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-38.0, 38.0);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if normal_share(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
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
    }

    #[test]
    fn the_upper_median_and_the_spread_about_it_are_of_order_statistics() {
        assert_eq!(upper_median(vec![4.0, 1.0, 3.0, 2.0]), Some(3.0));
        // Deviations 2, 1, 0 and 97 from 3: their upper median is 2.
        assert_eq!(robust_std(&[1.0, 2.0, 3.0, 100.0]), Some(1.4826 * 2.0));
        assert_eq!((upper_median(vec![]), robust_std(&[])), (None, None));
    }
}
