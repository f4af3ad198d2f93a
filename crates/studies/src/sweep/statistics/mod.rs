//! Only counts and sums are stored: the memory does not grow with the number of cases, and the quantiles are exact.

mod cells;
mod influence;
mod quantiles;
mod unchanged;

pub use cells::{Cell, HeatMap};
pub use influence::{Influence, Influences, LevelMean};

use schemars::JsonSchema;
use serde::Serialize;

use self::cells::Cells;
use self::influence::Inputs;
use self::quantiles::OrderStatistics;
use super::design::Design;
use super::error::SweepError;
use super::part::{Outcome, Rows};
use trocar_base::moments::Moments;
use trocar_base::quantiles::{median_ranks, quantile};
use trocar_base::warning::Warning;
use trocar_metrics::Unit;

/// The distribution of a metric over the cases in which it is defined and finite.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// Name.
    pub metric: String,
    /// Label in tables.
    pub label: String,
    /// Unit; the numbers are in SI units.
    pub unit: Unit,
    /// Number of cases in which the metric is defined and finite.
    pub defined: u64,
    /// The distribution; `None` without such a case.
    pub spread: Option<Spread>,
}

/// The distribution of a metric. Quantiles are interpolated linearly between order statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// The minimum.
    #[serde(rename = "least")]
    pub min: f64,
    /// The 2.5 % quantile.
    pub quantile_2_5: f64,
    /// The 5 % quantile.
    pub quantile_5: f64,
    /// The lower quartile.
    pub quantile_25: f64,
    /// The median.
    pub median: f64,
    /// The upper quartile.
    pub quantile_75: f64,
    /// The 95 % quantile.
    pub quantile_95: f64,
    /// The 97.5 % quantile.
    pub quantile_97_5: f64,
    /// The maximum.
    #[serde(rename = "greatest")]
    pub max: f64,
    /// Lower end of the 95 % confidence interval of the median, between the order statistics of ranks n/2 ± 1.96 √n/2.
    pub median_low: f64,
    /// Upper end of that interval.
    pub median_high: f64,
    /// The mean.
    pub mean: f64,
    /// Half-width of the 95 % confidence interval of the mean, 1.96 standard deviations over √n.
    pub mean_ci95_half_width: f64,
    /// The standard deviation; 0 for a single case.
    pub standard_deviation: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    pub cases: u64,
    pub diverged: u64,
    pub failed: u64,
    pub summaries: Vec<Summary>,
    pub influences: Vec<Influences>,
    pub heat_maps: Vec<HeatMap>,
    pub warnings: Vec<Warning>,
}

const QUANTILES: [f64; 7] = [0.025, 0.05, 0.25, 0.5, 0.75, 0.95, 0.975];

pub fn findings(design: &Design, rows: &Rows) -> Result<Findings, SweepError> {
    let mut moments = vec![Moments::default(); design.columns.len()];
    let (mut cases, mut diverged, mut failed) = (0, 0, 0);
    let mut inputs = Inputs::new(design);
    let mut cells = Cells::new(design);
    let (sampler, mut coordinates) = (design.coordinates(), vec![]);
    rows.each(|case, outcome, values| {
        cases += 1;
        diverged += u64::from(outcome == Outcome::Diverged);
        failed += u64::from(outcome == Outcome::Failed);
        moments.iter_mut().zip(values).for_each(|(moments, value)| moments.add_finite(*value));
        sampler.of(case, &mut coordinates);
        inputs.add(case, &coordinates, values);
        cells.add(&coordinates, values);
        Ok(())
    })?;
    let ranks = |moments: &Moments| quantiles::ranks(moments.count, &QUANTILES);
    let mut statistics: Vec<_> = moments.iter().map(|moments| OrderStatistics::new(ranks(moments))).collect();
    while statistics.iter().any(|statistics| !statistics.are_known()) {
        rows.each(|_, _, values| {
            statistics.iter_mut().zip(values).for_each(|(statistics, value)| statistics.count(*value));
            Ok(())
        })?;
        statistics.iter_mut().for_each(OrderStatistics::narrow);
    }
    let summary = |((column, moments), statistics): ((&super::Column, &Moments), &OrderStatistics)| Summary {
        metric: column.name.clone(),
        label: column.label.clone(),
        unit: column.unit,
        defined: moments.count,
        spread: (moments.count > 0).then(|| spread(moments, statistics)),
    };
    let summaries: Vec<Summary> = design.columns.iter().zip(&moments).zip(&statistics).map(summary).collect();
    Ok(Findings {
        cases,
        diverged,
        failed,
        warnings: unchanged::warning(&summaries, cases).into_iter().collect(),
        summaries,
        influences: inputs.influences(),
        heat_maps: cells.heat_maps(),
    })
}

fn spread(moments: &Moments, statistics: &OrderStatistics) -> Spread {
    let quantile = |share: f64| quantile(moments.count, share, |rank| statistics.of_rank(rank)).unwrap_or(f64::NAN);
    let [quantile_2_5, quantile_5, quantile_25, median, quantile_75, quantile_95, quantile_97_5] =
        QUANTILES.map(quantile);
    let (low, high) = median_ranks(moments.count);
    Spread {
        min: statistics.of_rank(0),
        quantile_2_5,
        quantile_5,
        quantile_25,
        median,
        quantile_75,
        quantile_95,
        quantile_97_5,
        max: statistics.of_rank(moments.count - 1),
        median_low: statistics.of_rank(low),
        median_high: statistics.of_rank(high),
        mean: moments.mean,
        mean_ci95_half_width: 1.96 * moments.standard_error(),
        standard_deviation: moments.variance().sqrt(),
    }
}
