use std::borrow::Cow;
use std::io;

use super::{AxisColumn, Design, Outcome, Rows, SweepError};
use trocar_document::{DataTable, Values};
use trocar_scenario::Value;

/// A table is held in memory.
const MAX_ROWS: usize = 1 << 16;

pub fn case_tables(
    design: &Design,
    hash: &str,
    rows: &Rows,
    each: &mut dyn FnMut(&DataTable<'_>) -> io::Result<()>,
) -> Result<(), SweepError> {
    let mut each =
        |part: &mut Part<'_>| each(&part.take(hash)).map_err(|source| SweepError::Io { path: "cases".into(), source });
    let mut part = Part::new(design);
    let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
    rows.each(|case, outcome, metrics| {
        sampler.values(case, &mut coordinates, &mut values);
        part.push(case, &values, outcome, metrics);
        if part.cases.len() == MAX_ROWS { each(&mut part) } else { Ok(()) }
    })?;
    if part.cases.is_empty() { Ok(()) } else { each(&mut part) }
}

struct Part<'a> {
    design: &'a Design,
    cases: Vec<u64>,
    axes: Vec<AxisColumn>,
    seeds: Vec<u64>,
    outcomes: Vec<Cow<'a, str>>,
    metrics: Vec<Vec<Option<f64>>>,
}

impl<'a> Part<'a> {
    fn new(design: &'a Design) -> Self {
        Self {
            design,
            cases: vec![],
            axes: design.axes.iter().map(AxisColumn::of).collect(),
            seeds: vec![],
            outcomes: vec![],
            metrics: vec![vec![]; design.columns.len()],
        }
    }

    fn push(&mut self, case: u64, values: &[Value], outcome: Outcome, metrics: &[f64]) {
        self.cases.push(case);
        self.axes.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        self.seeds.push(self.design.seed(case));
        self.outcomes.push(outcome.word().into());
        let metrics = metrics.iter().map(|metric| (!metric.is_nan()).then_some(*metric));
        self.metrics.iter_mut().zip(metrics).for_each(|(column, metric)| column.push(metric));
    }

    fn take(&mut self, hash: &str) -> DataTable<'a> {
        let Self { design, cases, axes, seeds, outcomes, metrics } = std::mem::replace(self, Self::new(self.design));
        let mut table = DataTable::new("cases").with("case", Values::Whole(cases));
        table.metadata.push(("trocar.sweep_sha256", hash.to_owned()));
        for (axis, column) in design.axes.iter().zip(axes) {
            table = table.with(axis.key.path.to_string(), column.into_values());
        }
        table = table.with("seed", Values::Whole(seeds)).with("outcome", Values::Texts(outcomes));
        for (column, metrics) in design.columns.iter().zip(metrics) {
            let values = match column.is_count() {
                true => {
                    Values::OptionalWhole(metrics.into_iter().map(|metric| metric.map(|count| count as u64)).collect())
                }
                false => Values::Optional(metrics),
            };
            table = table.with(&*column.name, values);
        }
        table
    }
}
