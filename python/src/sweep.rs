//! Sweeps and shards of sweeps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_sim::metrics::Declaration;
use trocar_sim::run::RunError;
use trocar_sim::scenario::{ScenarioError, Source};
use trocar_sim::sweep::{
    AxisColumn, Column, Design, Execution, Outcome, Part, Plan, Progress, Rows, Shard, SweepError, execute,
};

use crate::arrays::put;
use crate::error;
use crate::interrupt::interruptible_told;
use crate::run::measure_with;
use crate::scenario::{Scenario, text_source};

/// The result by columns.
struct Columns {
    case: Vec<i64>,
    axes: Vec<(String, AxisColumn)>,
    seed: Vec<i64>,
    outcome: Vec<u8>,
    metrics: Vec<(String, Vec<f64>)>,
}

impl Columns {
    /// Returns the columns of all rows that `each` gives: a case, its outcome, its metrics.
    fn of<E>(
        design: &Design,
        each: impl FnOnce(&mut dyn FnMut(u64, Outcome, &[f64])) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut all = Self {
            case: vec![],
            axes: design.axes.iter().map(|axis| (axis.key.path.to_owned(), AxisColumn::of(axis))).collect(),
            seed: vec![],
            outcome: vec![],
            metrics: design.columns.iter().map(|column| (column.name.clone(), vec![])).collect(),
        };
        let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
        each(&mut |case, outcome, metrics| {
            sampler.values(case, &mut coordinates, &mut values);
            all.case.push(case as i64);
            all.seed.push(design.seed(case) as i64);
            all.outcome.push(outcome as u8);
            all.axes.iter_mut().zip(&values).for_each(|((_, column), value)| column.push(value));
            all.metrics.iter_mut().zip(metrics).for_each(|((_, column), metric)| column.push(*metric));
        })?;
        Ok(all)
    }

    fn hand_over(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let columns = PyDict::new(py);
        put(&columns, "case", self.case)?;
        for (name, column) in self.axes {
            match column {
                AxisColumn::Number(values) => put(&columns, &name, values)?,
                AxisColumn::Whole(values) => put(&columns, &name, values)?,
                AxisColumn::Flag(values) => put(&columns, &name, values)?,
                AxisColumn::Text(values) => columns.set_item(&name, values)?,
            }
        }
        put(&columns, "seed", self.seed)?;
        put(&columns, "outcome", self.outcome)?;
        for (name, values) in self.metrics {
            put(&columns, &name, values)?;
        }
        Ok(columns)
    }
}

/// The sweep: a file or a text, and the scenario if neither names one.
struct Sources {
    sweep: Source,
    base: Option<Source>,
}

impl Sources {
    fn of(path: Option<&str>, text: &str, base: Option<&Scenario>) -> Self {
        let sweep = path.map_or_else(|| text_source("sweep", text), Source::parse);
        Self { sweep, base: base.map(|base| base.source.clone()) }
    }

    fn plan(&self, settings: &[String]) -> Result<Plan, ScenarioError> {
        match &self.base {
            Some(base) => Plan::over(&self.sweep, base, settings),
            None => Plan::load(&self.sweep, settings),
        }
    }
}

type Swept<'py> = (Bound<'py, PyDict>, String, u64, Vec<(String, String)>);

/// Returns the hash of a sweep and its number of cases, without running any.
#[pyfunction]
pub(crate) fn sweep_plan(
    py: Python<'_>,
    path: Option<&str>,
    text: &str,
    base: Option<&Scenario>,
    settings: Vec<String>,
) -> PyResult<(String, u64)> {
    let sources = Sources::of(path, text, base);
    let plan = py.detach(|| sources.plan(&settings)).map_err(|error| error::scenario(py, &error))?;
    Ok((plan.hash(), plan.design.cases()))
}

/// Runs a sweep, or a shard of it such as "3/8", with a number of threads (0 for all processors). Returns the columns, the hash
/// of the whole sweep, its number of cases, and the former names of metrics in the file, each with the present name. The sweep
/// is a file's path or a text; `base` is the scenario if neither names one. `tell` is called with the numbers of complete and of
/// all cases, from time to time and at the end.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes a job and how to run it")]
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    path: Option<&str>,
    text: &str,
    base: Option<&Scenario>,
    settings: Vec<String>,
    shard: &str,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<Swept<'py>> {
    let shard: Shard = shard.parse().map_err(error::value)?;
    let sources = Sources::of(path, text, base);
    let done = Arc::new([const { AtomicU64::new(0) }; 2]);
    let told = done.clone();
    let tell = move |py: Python<'_>| {
        let [done, all] = told.each_ref().map(|count| count.load(Ordering::Relaxed));
        tell.as_ref().filter(|_| all > 0).map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let work = move |stop: &AtomicBool| {
        let plan = sources.plan(&settings)?;
        let layout = plan.layout(shard);
        let all = layout.part_cases();
        done[1].store(all, Ordering::Relaxed);
        let io = |source| SweepError::Io { path: std::env::temp_dir(), source };
        let folder = tempfile::Builder::new().prefix("trocar-sweep-").tempdir().map_err(io)?;
        let part = Part::open(&folder.path().join(trocar_sim::sweep::CASES), layout)?;
        let count = |cases: u64| {
            done[0].fetch_add(cases, Ordering::Relaxed);
        };
        let progress = Progress { stop, begun: &|_| (), done: &count };
        let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
        if execute(&plan, &part, Execution { threads, shares_runs: true }, &progress)? < all {
            return Ok(None);
        }
        let columns = Columns::of(&plan.design, |row| {
            Rows(vec![part]).each(|case, outcome, metrics| {
                row(case, outcome, metrics);
                Ok(())
            })
        })?;
        Ok(Some((columns, plan.hash(), plan.design.cases(), plan.former_names)))
    };
    let swept = interruptible_told(py, threads, &tell, work)?.map_err(|error: SweepError| error::sweep(py, &error))?;
    // Only a signal stops it, and its exception has been raised.
    let (columns, hash, cases, former_names) = swept.ok_or_else(|| error::value("the sweep was interrupted"))?;
    tell(py)?;
    Ok((columns.hand_over(py)?, hash, cases, former_names))
}

/// Runs a sweep with the user's own parts, by role, one case after the other. Returns what [`sweep`] does.
#[pyfunction]
pub(crate) fn sweep_with<'py>(
    py: Python<'py>,
    path: Option<&str>,
    text: &str,
    base: Option<&Scenario>,
    settings: Vec<String>,
    parts: &Bound<'py, PyDict>,
    tell: Option<Bound<'py, PyAny>>,
) -> PyResult<Swept<'py>> {
    let plan = Sources::of(path, text, base).plan(&settings).map_err(|error| error::scenario(py, &error))?;
    let design = &plan.design;
    let mut maker = plan.maker();
    let columns = Columns::of(design, |row| {
        for case in 0..design.cases() {
            let scenario = maker.scenario(case).map_err(|error| error::sweep(py, &error))?;
            let (outcome, metrics) = match measure_with(py, &scenario, parts)? {
                Ok(metrics) => (Outcome::of(metrics.outcome), Some(metrics)),
                Err(RunError::Engine { .. }) => (Outcome::Failed, None),
                Err(refused) => return Err(error::sweep(py, &maker.refused(case, refused))),
            };
            let value = |column: &Column| metrics.as_ref().and_then(|metrics| column.value(metrics, None));
            let values: Vec<f64> = design.columns.iter().map(|column| value(column).unwrap_or(f64::NAN)).collect();
            row(case, outcome, &values);
            tell.as_ref().map_or(Ok(()), |tell| tell.call1((case + 1, design.cases())).map(drop))?;
        }
        Ok(())
    })?;
    let (hash, cases) = (plan.hash(), design.cases());
    Ok((columns.hand_over(py)?, hash, cases, plan.former_names.clone()))
}

/// Returns the metrics of a sweep; those of ruptures and events have the number 1: name, scope, label, unit, which values are
/// better, meaning.
#[pyfunction]
pub(crate) fn metrics() -> Vec<(String, &'static str, String, &'static str, &'static str, &'static str)> {
    let columns =
        |m: &Declaration| (m.key(1), m.scope.word(), m.full_label(1), m.unit.si(), m.better.word(), m.meaning);
    Column::declarations().map(columns).collect()
}
