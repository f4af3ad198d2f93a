use trocar_base::quantiles::bisect;

const Z: f64 = 1.959_963_984_540_054;

/// Above it, the error of the cube-root approximation is negligible.
const MAX_EXACT: u64 = 100;

/// 95 % interval of a probability (Wilson, *Journal of the American Statistical Association* 22, 1927).
pub fn wilson(successes: u64, trials: u64) -> Option<(f64, f64)> {
    if trials == 0 {
        return None;
    }
    let n = trials as f64;
    let share = successes.min(trials) as f64 / n;
    let middle = share + Z * Z / (2.0 * n);
    let half_width = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    let low = if successes == 0 { 0.0 } else { ((middle - half_width) / scale).max(0.0) };
    let high = if successes >= trials { 1.0 } else { ((middle + half_width) / scale).min(1.0) };
    Some((low, high))
}

/// 95 % interval of a Poisson mean (Garwood, *Biometrika* 28, 1936); for 0, one-sided up to `-ln 0.05`.
pub fn poisson(count: u64) -> (f64, f64) {
    if count == 0 {
        return (0.0, -libm::log(0.05));
    }
    if count > MAX_EXACT {
        return (wilson_hilferty(count as f64, -Z), wilson_hilferty(count as f64 + 1.0, Z));
    }
    let low = bisect(0.0, count as f64, |mean| 1.0 - poisson_cdf(count - 1, mean) < 0.025);
    let high = bisect(0.0, 2.0 * count as f64 + 20.0, |mean| poisson_cdf(count, mean) > 0.025);
    (low, high)
}

/// Half of a chi-square quantile with `2 shape` degrees of freedom.
fn wilson_hilferty(shape: f64, z: f64) -> f64 {
    let inner = 1.0 - 1.0 / (9.0 * shape) + z / (3.0 * shape.sqrt());
    shape * inner * inner * inner
}

fn poisson_cdf(count: u64, mean: f64) -> f64 {
    let mut term = libm::exp(-mean);
    let mut sum = term;
    for k in 1..=count {
        term *= mean / k as f64;
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: (f64, f64), expected: (f64, f64), tolerance: f64) {
        let near = |a: f64, b: f64| (a - b).abs() <= tolerance;
        assert!(near(got.0, expected.0) && near(got.1, expected.1), "{got:?} is not {expected:?}");
    }

    #[test]
    fn wilson_solves_its_quadratic() {
        assert_eq!(wilson(0, 0), None);
        for (k, n) in [(1, 10), (5, 10), (199, 200), (1990, 2000)] {
            let (low, high) = wilson(k, n).expect("trials");
            let share = k as f64 / n as f64;
            // At the ends of the interval the normal test of the share against p is at its limit.
            for p in [low, high] {
                assert!(((share - p).abs() / (p * (1.0 - p) / n as f64).sqrt() - Z).abs() < 1e-9);
            }
        }
        assert_eq!(wilson(0, 50).expect("trials").0, 0.0);
        assert_eq!(wilson(50, 50).expect("trials").1, 1.0);
    }

    #[test]
    fn garwood_has_its_published_ends() {
        // From the table in the paper: 95 %, two-sided.
        close(poisson(1), (0.0253, 5.572), 6e-4);
        close(poisson(10), (4.795, 18.39), 6e-3);
        close(poisson(50), (37.11, 65.92), 6e-3);
        close(poisson(0), (0.0, 2.9957), 1e-4);
    }

    #[test]
    fn exact_and_approximate_intervals_agree() {
        let exact = |count: u64| {
            let low = bisect(0.0, count as f64, |mean| 1.0 - poisson_cdf(count - 1, mean) < 0.025);
            (low, bisect(0.0, 2.0 * count as f64 + 20.0, |mean| poisson_cdf(count, mean) > 0.025))
        };
        for count in [101, 200, 400] {
            close(poisson(count), exact(count), 2e-3);
        }
    }
}
