use trocar_base::quantiles::{normal_quantile, normal_share};

#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    pub name: String,
    pub axes: Vec<usize>,
    /// Correlation of the normal numbers from which the values are derived.
    pub coefficient: f64,
}

/// A Gaussian copula: each coordinate remains uniformly distributed.
#[derive(Debug, Clone)]
pub(super) struct Mixer {
    axes: Vec<usize>,
    /// Lower triangle by rows.
    factor: Vec<Vec<f64>>,
}

impl Mixer {
    pub(super) fn new(correlation: &Correlation) -> Self {
        let count = correlation.axes.len();
        let mut factor: Vec<Vec<f64>> = vec![];
        for row in 0..count {
            let mut line: Vec<f64> = vec![];
            for column in 0..=row {
                let wanted = if row == column { 1.0 } else { correlation.coefficient };
                let above = factor.get(column).unwrap_or(&line);
                let known: f64 = line.iter().zip(above).map(|(a, b)| a * b).sum();
                let left = wanted - known;
                line.push(if row == column { left.max(0.0).sqrt() } else { left / factor[column][column] });
            }
            factor.push(line);
        }
        Self { axes: correlation.axes.clone(), factor }
    }

    pub(super) fn mix(&self, coordinates: &mut [f64]) {
        let normals: Vec<f64> = self.axes.iter().map(|axis| normal_quantile(coordinates[*axis])).collect();
        for (row, axis) in self.factor.iter().zip(&self.axes) {
            let mixed: f64 = row.iter().zip(&normals).map(|(weight, normal)| weight * normal).sum();
            coordinates[*axis] = normal_share(mixed).min(1.0 - f64::EPSILON);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
        let (of_a, of_b) = (mean(a), mean(b));
        let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - of_a, b - of_b)).sum::<f64>();
        sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
    }

    #[test]
    fn coordinates_have_the_correlation_and_stay_even() {
        for coefficient in [0.7, -0.4, 0.0] {
            let group = Correlation { name: "x".into(), axes: vec![0, 2, 3], coefficient };
            let mixer = Mixer::new(&group);
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
            let mut columns = vec![vec![]; 4];
            for _ in 0..20_000 {
                let mut case: [f64; 4] = std::array::from_fn(|_| random.random());
                mixer.mix(&mut case);
                columns.iter_mut().zip(case).for_each(|(column, value)| column.push(value));
            }
            // The rank correlation of normal numbers.
            let expected = 6.0 / std::f64::consts::PI * (coefficient / 2.0).asin();
            for (a, b) in [(0, 2), (0, 3), (2, 3)] {
                let found = correlation(&columns[a], &columns[b]);
                assert!((found - expected).abs() < 0.02, "{coefficient}: {found} instead of {expected}");
            }
            assert!(correlation(&columns[0], &columns[1]).abs() < 0.02);
            for column in &columns {
                let below = column.iter().filter(|value| **value < 0.25).count();
                assert!((below as f64 / 20_000.0 - 0.25).abs() < 0.01, "{below}");
            }
        }
    }
}
