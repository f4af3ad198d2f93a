//! What the rows of a sweep come to: how each metric spreads, and which axis matters.
//!
//! Rows are read in order, several times over, and nothing but counts is kept of them: memory does not grow with the cases,
//! and quantiles are exact all the same.

mod cells;
mod influence;
mod quantiles;

pub use cells::{Cell, HeatMap};
pub use influence::{Influence, Influences};

use serde::Serialize;

use self::cells::Cells;
use self::influence::Inputs;
use self::quantiles::OrderStatistics;
use super::design::Design;
use super::error::SweepError;
use super::part::{Outcome, Rows};
use crate::metrics::Unit;
use crate::moments::Moments;
use crate::quantiles::{median_ranks, quantile};

/// How a metric spreads over the cases in which it is defined.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Its name.
    pub metric: String,
    /// Its label in tables.
    pub label: String,
    /// Its unit; the numbers are in SI.
    pub unit: Unit,
    /// In how many cases it is defined.
    pub defined: u64,
    /// What the rest is about; none where it is defined nowhere.
    pub spread: Option<Spread>,
}

/// Quantiles are linear between order statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The least.
    pub least: f64,
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
    /// The greatest.
    pub greatest: f64,
    /// Lower end of the 95 % interval of the median, of the order statistics of ranks n/2 ± 1.96 √n/2.
    pub median_low: f64,
    /// Its upper end.
    pub median_high: f64,
    /// The mean.
    pub mean: f64,
    /// Half the width of the 95 % interval of the mean, 1.96 standard deviations over √n.
    pub mean_ci95_half_width: f64,
    /// The standard deviation; 0 of a single case.
    pub standard_deviation: f64,
}

/// What came out of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// How many cases there are.
    pub cases: u64,
    /// How many of them diverged.
    pub diverged: u64,
    /// How many could not be integrated.
    pub failed: u64,
    /// A summary per metric that is kept.
    pub summaries: Vec<Summary>,
    /// What the metrics in focus depend on.
    pub influences: Vec<Influences>,
    /// The metrics in focus over the first two axes of numbers, where there are two.
    pub heat_maps: Vec<HeatMap>,
}

/// UnitCoordinates of the values at which quantiles are read.
const QUANTILES: [f64; 7] = [0.025, 0.05, 0.25, 0.5, 0.75, 0.95, 0.975];

/// Reads the rows and sums them up.
///
/// # Errors
/// Those of the rows.
pub fn findings(design: &Design, rows: &Rows) -> Result<Findings, SweepError> {
    let mut moments = vec![Moments::default(); design.columns.len()];
    let (mut cases, mut diverged, mut failed) = (0, 0, 0);
    let mut inputs = Inputs::new(design);
    let mut cells = Cells::new(design);
    let (sampler, mut shares) = (design.shares(), vec![]);
    rows.each(|case, outcome, values| {
        cases += 1;
        diverged += u64::from(outcome == Outcome::Diverged);
        failed += u64::from(outcome == Outcome::Failed);
        moments.iter_mut().zip(values).for_each(|(moments, value)| moments.add_defined(*value));
        sampler.of(case, &mut shares);
        inputs.add(case, &shares, values);
        cells.add(&shares, values);
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
    Ok(Findings {
        cases,
        diverged,
        failed,
        summaries: design.columns.iter().zip(&moments).zip(&statistics).map(summary).collect(),
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
        least: statistics.of_rank(0),
        quantile_2_5,
        quantile_5,
        quantile_25,
        median,
        quantile_75,
        quantile_95,
        quantile_97_5,
        greatest: statistics.of_rank(moments.count - 1),
        median_low: statistics.of_rank(low),
        median_high: statistics.of_rank(high),
        mean: moments.mean,
        mean_ci95_half_width: 1.96 * moments.standard_error(),
        standard_deviation: moments.variance().sqrt(),
    }
}
