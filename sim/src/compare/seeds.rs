//! Scenarios over many seeds: how much of a difference is chance.

use rayon::prelude::*;
use serde::Serialize;

use super::{Row, rows};
use crate::metrics::{Better, Metrics, Unit};
use crate::quantiles;
use crate::run::{RunError, measure};
use crate::scenario::Scenario;

/// Most seeds of one study, which keeps the metrics of every run.
pub const MAX_SEEDS: u64 = 100_000;

/// How a metric spreads over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// In how many seeds it is defined, at least 1.
    pub defined: u64,
    /// The median.
    pub median: f64,
    /// The 2.5 % quantile: with `high`, the middle 95 % of the seeds.
    pub low: f64,
    /// The 97.5 % quantile.
    pub high: f64,
    /// Lower end of the 95 % confidence interval of the median.
    pub median_low: f64,
    /// Upper end of the 95 % confidence interval of the median.
    pub median_high: f64,
}

impl Spread {
    /// The spread of values; none of no values.
    ///
    /// Quantiles are linear between order statistics. The median's interval is that of the order statistics of ranks
    /// `n/2 ± 1.96 √n/2` (the normal approximation of the sign test, outwards); below six values it is the whole range.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let defined = values.len() as u64;
        let of_rank = |rank: u64| values[rank as usize];
        let quantile = |share: f64| quantiles::quantile(defined, share, of_rank);
        let median = quantile(0.5)?;
        let (median_low, median_high) = quantiles::median_ranks(defined);
        Some(Self {
            defined,
            median,
            low: quantile(0.025)?,
            high: quantile(0.975)?,
            median_low: of_rank(median_low),
            median_high: of_rank(median_high),
        })
    }
}

/// One metric over the seeds, a spread per scenario.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpreadRow {
    /// Its key, as in `rupture_1_detection_delay_s`.
    pub metric: String,
    /// Its label in tables.
    pub label: String,
    /// Its key without the prefix of a rupture or the link.
    #[serde(skip)]
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Which values are better.
    pub better: Better,
    /// Its spread in SI in each scenario; none where no seed defines it.
    pub spreads: Vec<Option<Spread>>,
    /// The spread of each scenario's value over the first scenario's, seed by seed; none for counts, and where no seed
    /// defines it.
    pub ratios: Vec<Option<Spread>>,
}

/// Scenarios that were run with the same seeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeedStudy {
    /// The scenarios' names.
    pub scenarios: Vec<String>,
    /// How many seeds.
    pub seeds: u64,
    /// The first one of each scenario; the others follow it.
    pub first_seeds: Vec<u64>,
    /// A row per metric.
    pub rows: Vec<SpreadRow>,
}

impl SeedStudy {
    /// Runs every scenario with `seeds` seeds, from its own on, in parallel; `done` is told of each run. The results do
    /// not depend on the number of threads.
    ///
    /// # Errors
    /// A [`RunError`] of the first scenario and seed that cannot be run.
    pub fn of(scenarios: &[Scenario], seeds: u64, done: impl Fn() + Sync) -> Result<Self, RunError> {
        let run = |scenario: &Scenario, offset: u64| {
            let metrics = measure(&scenario.with_seed(scenario.seed.wrapping_add(offset)));
            done();
            metrics
        };
        let of_seed = |offset| scenarios.iter().map(|scenario| run(scenario, offset)).collect::<Result<Vec<_>, _>>();
        let runs: Vec<Vec<Metrics>> = (0..seeds).into_par_iter().map(of_seed).collect::<Result<_, _>>()?;
        Ok(Self {
            scenarios: scenarios.iter().map(|scenario| scenario.name.clone()).collect(),
            seeds,
            first_seeds: scenarios.iter().map(|scenario| scenario.seed).collect(),
            rows: spread_rows(&runs, scenarios.len()),
        })
    }

    /// The row of a metric.
    #[must_use]
    pub fn row(&self, metric: &str) -> Option<&SpreadRow> {
        self.rows.iter().find(|row| row.metric == metric)
    }
}

/// The rows of all seeds, metric by metric in the order of the table with the most of them.
fn spread_rows(runs: &[Vec<Metrics>], scenarios: usize) -> Vec<SpreadRow> {
    let tables: Vec<_> = runs.par_iter().map(|of_seed| rows(&of_seed.iter().collect::<Vec<_>>(), &[])).collect();
    let Some(longest) = tables.iter().max_by_key(|table| table.len()) else { return vec![] };
    let of_metric = |metric: &Row| {
        let values = |table: &Vec<Row>| {
            let found = table.iter().find(|row| row.metric == metric.metric);
            found.map_or_else(|| vec![None; scenarios], |row| row.values.clone())
        };
        spread_row(metric, &tables.iter().map(values).collect::<Vec<_>>(), scenarios)
    };
    longest.iter().map(of_metric).collect()
}

/// The spread of a metric's values: for each seed, one per scenario.
fn spread_row(row: &Row, values: &[Vec<Option<f64>>], scenarios: usize) -> SpreadRow {
    let &Row { name, unit, better, .. } = row;
    let spread = |index: usize| Spread::of(values.iter().filter_map(|of_seed| of_seed[index]).collect());
    let ratio = |of_seed: &Vec<Option<f64>>, index: usize| {
        let ratio = of_seed[index]? / of_seed[0]?;
        ratio.is_finite().then_some(ratio)
    };
    let ratios = |index: usize| Spread::of(values.iter().filter_map(|of_seed| ratio(of_seed, index)).collect());
    SpreadRow {
        metric: row.metric.clone(),
        label: row.label.clone(),
        name,
        unit,
        better,
        spreads: (0..scenarios).map(spread).collect(),
        ratios: (0..scenarios).map(|index| if unit == Unit::Count { None } else { ratios(index) }).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_order_statistics() {
        let spread = Spread::of((0..=200).rev().map(f64::from).collect()).expect("values");
        assert_eq!((spread.defined, spread.median, spread.low, spread.high), (201, 100.0, 5.0, 195.0));
        // n/2 - 1.96 √n/2 = 86.6: ranks 86 and 116 of 201.
        assert_eq!((spread.median_low, spread.median_high), (85.0, 115.0));
        let one = Spread::of(vec![3.0]).expect("a value");
        assert_eq!((one.median, one.low, one.median_high), (3.0, 3.0, 3.0));
        assert_eq!(Spread::of(vec![]), None);
    }

    #[test]
    fn a_median_interval_covers_the_true_median_as_often_as_it_says() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let covers = |_: &i32| {
            let spread = Spread::of((0..50).map(|_| rng.random::<f64>()).collect()).expect("values");
            (spread.median_low..=spread.median_high).contains(&0.5)
        };
        let covered = (0..2000).filter(covers).count();
        assert!((1900..=1980).contains(&covered), "{covered} of 2000");
    }
}
