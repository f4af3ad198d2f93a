use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::quantity::{Aggregate, Samples};
use trocar_base::quantiles::quantile_of;

/// Makes the ends of a 95 % interval the 25th and 975th order statistics.
const RESAMPLES: usize = 1000;

const SHARES: [f64; 2] = [0.025, 0.975];

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end of the 95 % interval.
    pub high: f64,
}

/// All candidates share the resamples, so their differences are paired.
#[derive(Debug)]
pub(super) struct Resamples {
    clusters: Vec<Vec<usize>>,
    /// Indices of the drawn clusters, by resample.
    drawn: Vec<Vec<usize>>,
}

impl Resamples {
    pub(super) fn of(clusters: Vec<Vec<usize>>, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let count = clusters.len();
        let drawn =
            (0..RESAMPLES).map(|_| (0..count).map(|_| random.random_range(0..count.max(1))).collect()).collect();
        Self { clusters, drawn }
    }

    pub(super) fn values(&self, samples: &Samples, how: Aggregate) -> (Option<f64>, Vec<Option<f64>>) {
        let sums: Vec<(f64, f64)> = self
            .clusters
            .iter()
            .map(|runs| {
                runs.iter().map(|&run| samples.sum(run)).fold((0.0, 0.0), |(a, b), (sum, weight)| (a + sum, b + weight))
            })
            .collect();
        let of_resample = |drawn: &Vec<usize>| match how {
            Aggregate::Mean => {
                let (sum, weight) =
                    drawn.iter().map(|&cluster| sums[cluster]).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
                (weight > 0.0).then(|| sum / weight)
            }
            Aggregate::Quantile(_) => {
                samples.aggregate_over(how, drawn.iter().flat_map(|&cluster| self.clusters[cluster].iter().copied()))
            }
        };
        (samples.aggregate(how), self.drawn.iter().map(of_resample).collect())
    }
}

pub(super) fn estimate((value, resampled): &(Option<f64>, Vec<Option<f64>>)) -> Option<Estimate> {
    let value = (*value)?;
    let mut defined: Vec<f64> = resampled.iter().flatten().copied().collect();
    let [low, high] = SHARES.map(|share| quantile_of(&mut defined, share).unwrap_or(value));
    Some(Estimate { value, low, high })
}

pub(super) fn difference(a: &(Option<f64>, Vec<Option<f64>>), b: &(Option<f64>, Vec<Option<f64>>)) -> Option<Estimate> {
    let minus = |(a, b): (&Option<f64>, &Option<f64>)| Some((*a)? - (*b)?);
    let value = minus((&a.0, &b.0));
    estimate(&(value, a.1.iter().zip(&b.1).map(minus).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::quantity::Values;
    use super::*;

    fn samples(patients: usize, of: impl Fn(usize, usize) -> f64) -> Samples {
        let mut samples = Samples::default();
        for run in 0..2 * patients {
            samples.push(Values { values: vec![of(run / 2, run % 2)], weight: 1.0 });
        }
        samples
    }

    fn clusters(patients: usize) -> Vec<Vec<usize>> {
        (0..patients).map(|patient| vec![2 * patient, 2 * patient + 1]).collect()
    }

    #[test]
    fn an_interval_covers_the_mean_of_the_population_with_its_probability() {
        let covers = |trial: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(trial);
            let of_patients: Vec<f64> = (0..40).map(|_| random.random::<f64>()).collect();
            let samples = samples(40, |patient, _| of_patients[patient]);
            let resamples = Resamples::of(clusters(40), trial);
            let estimate = estimate(&resamples.values(&samples, Aggregate::Mean)).expect("values");
            (estimate.low..=estimate.high).contains(&0.5)
        };
        let covered = (0..300).filter(|&trial| covers(trial)).count();
        // 95 % of 300 is 285, with a standard deviation of 4; a bootstrap of 40 is slightly too narrow.
        assert!((270..=297).contains(&covered), "{covered}");
    }

    #[test]
    fn differences_are_paired() {
        let resamples = Resamples::of(clusters(20), 1);
        let of = |offset: f64| {
            resamples
                .values(&samples(20, |patient, seed| offset + 100.0 * patient as f64 + seed as f64), Aggregate::Mean)
        };
        let found = difference(&of(1.0), &of(0.0)).expect("values");
        assert!((found.low - 1.0).abs() < 1e-9 && (found.high - 1.0).abs() < 1e-9, "{found:?}");
        let wide = estimate(&of(0.0)).expect("values");
        assert!(wide.high - wide.low > 200.0, "{wide:?}");
        let quantile = resamples.values(&samples(20, |patient, _| patient as f64), Aggregate::Quantile(0.5));
        assert_eq!(estimate(&quantile).map(|estimate| estimate.value), Some(9.5));
    }
}
