use super::{Axis, Column, Design, Levels, Rows, SweepError};
use trocar_document::{Figure, readable};
use trocar_figures::{self as figures, CasesView};
use trocar_scenario::Value;

const MAX_CASES: u64 = 2_000;

const MAX_CHARTS: usize = 16;

const CLASSES: usize = 20;

#[derive(Clone, Debug)]
pub struct DrawnCases {
    axes: Vec<Vec<f64>>,
    metrics: Vec<Vec<f64>>,
    cases: u64,
}

impl DrawnCases {
    /// A regular step could skip a level of an axis.
    pub fn of(design: &Design, rows: &Rows) -> Result<Self, SweepError> {
        let all = design.cases();
        let parts = all.min(MAX_CASES);
        let of_part = |part: u64| {
            let bound = |part: u64| (u128::from(part) * u128::from(all) / u128::from(parts.max(1))) as u64;
            let (start, end) = (bound(part), bound(part + 1));
            // Multiples of the golden ratio are spread evenly over the part.
            start + (part.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) % (end - start).max(1)
        };
        let mut drawing =
            Self { axes: vec![vec![]; design.axes.len()], metrics: vec![vec![]; design.focus.len()], cases: parts };
        let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
        let mut part = 0;
        rows.each(|case, _, metrics| {
            if part >= parts || case != of_part(part) {
                return Ok(());
            }
            part += 1;
            sampler.values(case, &mut coordinates, &mut values);
            for (column, (value, axis)) in drawing.axes.iter_mut().zip(values.iter().zip(&design.axes)) {
                column.push(place(axis, value));
            }
            for (column, index) in drawing.metrics.iter_mut().zip(&design.focus) {
                column.push(metrics[*index]);
            }
            Ok(())
        })?;
        Ok(drawing)
    }

    pub(super) fn about(&self, all: u64) -> String {
        let shown = if self.cases < all {
            format!("{} of {all} cases are drawn, evenly chosen; cases.parquet has all", self.cases)
        } else {
            "Every case is drawn".to_owned()
        };
        format!("{shown}. The line connects the medians of the drawn cases at each level or class of the axis.")
    }

    pub(super) fn charts(&self, design: &Design) -> Vec<(String, Figure<'static>)> {
        let mut charts = vec![];
        for (metrics, index) in self.metrics.iter().zip(&design.focus) {
            let column = &design.columns[*index];
            for (values, axis) in self.axes.iter().zip(&design.axes) {
                if axis.count() != Some(1) && charts.len() < MAX_CHARTS {
                    let name = format!("cases_{}_over_{}", column.name, axis.key.path);
                    charts.push((name, chart(column, axis, values, metrics)));
                }
            }
        }
        charts
    }
}

/// The number, or the index of a word in the list, from 1.
fn place(axis: &Axis, value: &Value) -> f64 {
    match (value, &axis.levels) {
        (Value::Number(number), _) => *number,
        (Value::Whole(whole), _) => *whole as f64,
        (_, Levels::List(list)) => list.iter().position(|level| level == value).map_or(f64::NAN, |at| (at + 1) as f64),
        _ => f64::NAN,
    }
}

fn chart(column: &Column, axis: &Axis, values: &[f64], metrics: &[f64]) -> Figure<'static> {
    let (factor, unit) = readable(column.unit);
    let words = match &axis.levels {
        Levels::List(list) if !axis.is_numeric() => {
            let word =
                |(at, level): (usize, &Value)| format!("{}: {}", at + 1, level.to_toml().to_string().trim_matches('"'));
            format!(", {}", list.iter().enumerate().map(word).collect::<Vec<_>>().join(", "))
        }
        _ => String::new(),
    };
    let mut cases: Vec<(f64, f64)> =
        values.iter().zip(metrics).filter(|(x, _)| x.is_finite()).map(|(x, y)| (*x, factor * y)).collect();
    cases.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let unit = if unit.is_empty() { String::new() } else { format!(" ({})", unit.trim_start()) };
    let medians = medians(&cases, axis.is_log());
    figures::cases(&CasesView {
        x_caption: format!("{}{words}", axis.key.path),
        is_log: axis.is_log(),
        y_caption: format!("{} over {}{unit}", column.name, axis.key.path),
        cases: &cases,
        medians: &medians,
    })
}

/// Few distinct values of x are classes of their own.
fn medians(cases: &[(f64, f64)], log: bool) -> Vec<(f64, f64)> {
    let mut medians = vec![];
    let Some((&(low, _), &(high, _))) = cases.first().zip(cases.last()) else { return medians };
    let distinct = cases.chunk_by(|a, b| a.0 == b.0).count();
    let scale = |x: f64| if log { x.ln() } else { x };
    let width = (scale(high) - scale(low)) / CLASSES as f64;
    let class = |x: f64| if width > 0.0 { (((scale(x) - scale(low)) / width) as usize).min(CLASSES - 1) } else { 0 };
    let is_same = |a: &(f64, f64), b: &(f64, f64)| {
        if distinct <= 2 * CLASSES { a.0 == b.0 } else { class(a.0) == class(b.0) }
    };
    for group in cases.chunk_by(is_same) {
        let mut values: Vec<f64> = group.iter().map(|(_, y)| *y).filter(|y| y.is_finite()).collect();
        if let Some(median) = trocar_base::quantiles::quantile_of(&mut values, 0.5) {
            medians.push((group[group.len() / 2].0, median));
        }
    }
    medians
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_level_has_its_median() {
        let cases = [(1.0, 5.0), (1.0, 1.0), (1.0, 3.0), (2.0, f64::NAN), (4.0, 7.0), (4.0, 9.0)];
        assert_eq!(medians(&cases, true), [(1.0, 3.0), (4.0, 8.0)]);
    }

    #[test]
    fn an_axis_without_levels_has_classes() {
        let cases: Vec<(f64, f64)> = (0..1000).map(|k| (f64::from(k), f64::from(k))).collect();
        let medians = medians(&cases, false);
        assert_eq!(medians.len(), CLASSES);
        assert!(medians.is_sorted_by_key(|median| median.1));
    }
}
