use trocar_base::interrupt;
use trocar_base::large_pages::with_capacity;
use trocar_base::quantiles::quantile_of;

const NOISE_BLOCK: usize = 50;
const NOISE_SHARE: f64 = 0.75;

pub(super) fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    trocar_base::interrupt::check();
    quantile_of(&mut values, share)
}

pub(super) fn median(values: &[f64]) -> Option<f64> {
    quantile(values.to_vec(), 0.5)
}

pub(super) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// 0 for fewer than three samples.
///
/// The second difference of white noise has six times its variance. An encoder is quiet at rest and a rupture is not
/// noise, hence the upper quartile over blocks of 50 samples.
pub(crate) fn noise_std(signal: &[f64]) -> f64 {
    let mut second = with_capacity(signal.len());
    for (sample, w) in signal.windows(3).enumerate() {
        interrupt::check_at(sample as u64);
        second.push((w[2] - 2.0 * w[1] + w[0]) / 6.0_f64.sqrt());
    }
    let whole = second.chunks_exact(NOISE_BLOCK);
    let blocks: Vec<f64> = whole.map(root_mean_square).collect();
    quantile(blocks, NOISE_SHARE).unwrap_or_else(|| root_mean_square(&second))
}

/// 0 for a constant.
pub(super) fn min_step(signal: &[f64]) -> f64 {
    let steps = signal.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 1e-9);
    steps.reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn noise_is_found_under_a_signal_and_a_rupture() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let signal = |k: i32| {
            let t = f64::from(k) * 1e-3;
            let force = 2.0 * t * t + (3.0 * t).sin();
            if k < 3000 { force } else { 0.1 * force }
        };
        let noisy: Vec<f64> = (0..5000)
            .map(|k| {
                let noise: f64 = StandardNormal.sample(&mut random);
                signal(k) + 0.02 * noise
            })
            .collect();
        let found = noise_std(&noisy);
        // The upper quartile of a hundred blocks, each with a standard error of 10 %.
        assert!((0.019..0.024).contains(&found), "{found}");
    }

    #[test]
    fn a_quantile_lies_between_values() {
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.25), Some(1.5));
        assert_eq!((quantile(vec![], 0.5), median(&[7.0])), (None, Some(7.0)));
        assert_eq!((noise_std(&[]), noise_std(&[1.0; 200])), (0.0, 0.0));
    }

    #[test]
    fn the_smallest_step_is_the_resolution() {
        assert!((min_step(&[0.0, 0.5, 0.5, 0.75, 0.25]) - 0.25).abs() < 1e-12);
        assert_eq!(min_step(&[1.0; 5]), 0.0);
    }
}
