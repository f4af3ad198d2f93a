use schemars::JsonSchema;
use serde::Serialize;

use super::{Row, rows};
use crate::run::{RunError, measure};
use trocar_base::parallel::{map, try_map};
use trocar_base::quantiles;
use trocar_metrics::{Better, Metrics, Unit};
use trocar_scenario::Scenario;

/// A study stores the metrics of every run.
pub const MAX_SEEDS: u64 = 100_000;

/// The distribution of a metric over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Number of seeds for which the metric is defined, at least 1.
    pub defined: u64,
    /// The median.
    pub median: f64,
    /// The 2.5 % quantile; 95 % of the seeds lie between it and `high`.
    pub low: f64,
    /// The 97.5 % quantile.
    pub high: f64,
    /// Lower end of the 95 % confidence interval of the median.
    pub median_low: f64,
    /// Upper end of the 95 % confidence interval of the median.
    pub median_high: f64,
}

impl Spread {
    /// Quantiles are interpolated linearly. The median's interval lies between ranks `n/2 ± 1.96 √n/2`, rounded
    /// outwards (normal approximation of the sign test); below six values it is the whole range.
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

/// One metric over the seeds, with one spread per scenario.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SpreadRow {
    /// Key, for example `rupture_1_detection_delay_s`.
    pub metric: String,
    /// Label in tables.
    pub label: String,
    /// Key without the prefix of its scope.
    #[serde(skip)]
    pub name: &'static str,
    /// Unit.
    pub unit: Unit,
    /// The better direction.
    pub better: Better,
    /// Spread in each scenario, in SI units; `None` if no seed defines the metric.
    pub spreads: Vec<Option<Spread>>,
    /// Spread of the ratio of each scenario's value to the first scenario's, seed by seed; `None` for counts, and if no
    /// seed defines the ratio.
    pub ratios: Vec<Option<Spread>>,
}

/// The totals over all seeds of a scenario.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SeedTotals {
    /// Number of ruptures.
    pub ruptures: u64,
    /// Number of ruptures without an alarm.
    pub missed_ruptures: u64,
    /// Number of ruptures without an alarm that are undecided because the run ended too soon.
    pub undecided_ruptures: u64,
    /// Number of alarms that match no rupture.
    pub false_alarms: u64,
    /// Number of seeds in which the first, the second, … rupture occurs.
    pub seeds_with_rupture: Vec<u64>,
}

impl SeedTotals {
    fn of<'a>(runs: impl Iterator<Item = &'a Metrics>) -> Self {
        let mut totals = Self::default();
        for metrics in runs {
            let ruptures = metrics.ruptures.len();
            totals.ruptures += ruptures as u64;
            totals.missed_ruptures += metrics.missed_ruptures;
            totals.undecided_ruptures += metrics.undecided_ruptures;
            totals.false_alarms += metrics.false_alarms;
            totals.seeds_with_rupture.resize(totals.seeds_with_rupture.len().max(ruptures), 0);
            totals.seeds_with_rupture[..ruptures].iter_mut().for_each(|seeds| *seeds += 1);
        }
        totals
    }
}

/// The results of scenarios with the same number of seeds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SeedStudy {
    /// Names of the scenarios.
    pub scenarios: Vec<String>,
    /// Number of seeds.
    pub seeds: u64,
    /// First seed of each scenario, followed by consecutive seeds.
    pub first_seeds: Vec<u64>,
    /// Totals of each scenario.
    pub totals: Vec<SeedTotals>,
    /// A row per metric.
    pub rows: Vec<SpreadRow>,
}

impl SeedStudy {
    /// The results do not depend on the threads.
    pub fn of(scenarios: &[Scenario], seeds: u64, done: impl Fn() + Sync) -> Result<Self, RunError> {
        let run = |scenario: &Scenario, offset: u64| {
            let metrics = measure(&scenario.with_seed(scenario.seed.wrapping_add(offset)));
            done();
            metrics
        };
        let of_seed = |offset| scenarios.iter().map(|scenario| run(scenario, offset)).collect::<Result<Vec<_>, _>>();
        let runs: Vec<Vec<Metrics>> = try_map(seeds as usize, |offset| of_seed(offset as u64))?;
        Ok(Self::of_runs(scenarios, &runs))
    }

    /// `runs` by seed and scenario.
    pub fn of_runs(scenarios: &[Scenario], runs: &[Vec<Metrics>]) -> Self {
        Self {
            scenarios: scenarios.iter().map(|scenario| scenario.name.clone()).collect(),
            seeds: runs.len() as u64,
            first_seeds: scenarios.iter().map(|scenario| scenario.seed).collect(),
            totals: (0..scenarios.len()).map(|index| SeedTotals::of(runs.iter().map(|run| &run[index]))).collect(),
            rows: spread_rows(runs, scenarios.len()),
        }
    }

    pub fn max_ruptures(&self) -> usize {
        self.totals.iter().map(|totals| totals.seeds_with_rupture.len()).max().unwrap_or(0)
    }

    pub fn row(&self, metric: &str) -> Option<&SpreadRow> {
        self.rows.iter().find(|row| row.metric == metric)
    }
}

fn spread_rows(runs: &[Vec<Metrics>], scenarios: usize) -> Vec<SpreadRow> {
    let tables: Vec<_> = map(runs.len(), |seed| rows(&runs[seed].iter().collect::<Vec<_>>(), &[]));
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

fn spread_row(row: &Row, values: &[Vec<Option<f64>>], scenarios: usize) -> SpreadRow {
    let &Row { declaration, unit, better, .. } = row;
    let spread = |index: usize| Spread::of(values.iter().filter_map(|of_seed| of_seed[index]).collect());
    let ratio = |of_seed: &Vec<Option<f64>>, index: usize| {
        let ratio = of_seed[index]? / of_seed[0]?;
        ratio.is_finite().then_some(ratio)
    };
    let ratios = |index: usize| Spread::of(values.iter().filter_map(|of_seed| ratio(of_seed, index)).collect());
    SpreadRow {
        metric: row.metric.clone(),
        label: row.label.clone(),
        name: declaration.name,
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
    fn quantiles_are_interpolated_between_order_statistics() {
        let spread = Spread::of((0..=200).rev().map(f64::from).collect()).expect("values");
        assert_eq!((spread.defined, spread.median, spread.low, spread.high), (201, 100.0, 5.0, 195.0));
        // n/2 - 1.96 √n/2 = 86.6: ranks 86 and 116 of 201.
        assert_eq!((spread.median_low, spread.median_high), (85.0, 115.0));
        let one = Spread::of(vec![3.0]).expect("a value");
        assert_eq!((one.median, one.low, one.median_high), (3.0, 3.0, 3.0));
        assert_eq!(Spread::of(vec![]), None);
    }

    #[test]
    fn a_median_interval_covers_the_true_median_with_its_probability() {
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
