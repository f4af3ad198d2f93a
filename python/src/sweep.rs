//! Sweeps and shards of sweeps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tempfile::TempDir;
use trocar_base::parallel::try_map;
use trocar_document::Study as _;
use trocar_metrics::{Declaration, Metrics};
use trocar_scenario::{ScenarioError, Source};
use trocar_studies::run::RunError;
use trocar_studies::sweep::{
    AxisColumn, CaseMaker, Column, Design, DrawnCases, Execution, Layout, Outcome, PACK_CASES, PackRows, Part, Plan,
    Progress, Rows, Shard, SweepError, SweepReport, execute, findings, stored_design,
};

use crate::arrays::{put, samples};
use crate::interrupt::{interruptible, interruptible_with_count, interruptible_with_progress};
use crate::run::{measure_compiled, measure_with};
use crate::scenario::{Scenario, text_source};
use crate::user_defined::CompiledParts;
use crate::{convert, document, error};

struct Columns {
    case: Vec<i64>,
    axes: Vec<(String, AxisColumn)>,
    seed: Vec<i64>,
    outcome: Vec<u8>,
    metrics: Vec<(String, Vec<f64>)>,
}

impl Columns {
    fn for_cases(design: &Design, cases: u64, memory_bytes: u64) -> Result<Self, NoRoom> {
        let numbers = design.columns.len() + design.axes.len() + 2;
        if cases.saturating_mul(numbers as u64 * 8) > memory_bytes {
            return Err(NoRoom { cases, numbers });
        }
        Ok(Self {
            case: vec![],
            axes: design.axes.iter().map(|axis| (axis.key.path.to_string(), AxisColumn::of(axis))).collect(),
            seed: vec![],
            outcome: vec![],
            metrics: design.columns.iter().map(|column| (column.name.clone(), vec![])).collect(),
        })
    }

    fn fill<E>(
        &mut self,
        design: &Design,
        each: impl FnOnce(&mut dyn FnMut(u64, Outcome, &[f64])) -> Result<(), E>,
    ) -> Result<(), E> {
        let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
        each(&mut |case, outcome, metrics| {
            sampler.values(case, &mut coordinates, &mut values);
            self.case.push(case as i64);
            self.seed.push(design.seed(case) as i64);
            self.outcome.push(outcome as u8);
            self.axes.iter_mut().zip(&values).for_each(|((_, column), value)| column.push(value));
            self.metrics.iter_mut().zip(metrics).for_each(|((_, column), metric)| column.push(*metric));
        })
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

/// The cases do not fit into memory.
#[derive(Debug, Clone, Copy)]
struct NoRoom {
    cases: u64,
    numbers: usize,
}

impl std::fmt::Display for NoRoom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let gigabytes = self.cases as f64 * self.numbers as f64 * 8e-9;
        write!(
            f,
            "the {} cases take {gigabytes:.0} GB of memory, more than this machine has: use fewer points or metrics, \
             or `trocar sweep` on the command line, which keeps the cases on disk",
            self.cases
        )
    }
}

enum Failed {
    Sweep(SweepError),
    NoRoom(NoRoom),
    Python(PyErr),
}

impl From<SweepError> for Failed {
    fn from(error: SweepError) -> Self {
        Self::Sweep(error)
    }
}

impl From<trocar_scenario::ScenarioError> for Failed {
    fn from(error: trocar_scenario::ScenarioError) -> Self {
        Self::Sweep(error.into())
    }
}

impl Failed {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Sweep(error) => error::sweep(py, &error),
            Self::NoRoom(no_room) => PyMemoryError::new_err(no_room.to_string()),
            Self::Python(error) => error,
        }
    }
}

/// The sources of a sweep: its file or text, and the scenario if the sweep names none.
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

type Swept<'py> = (Bound<'py, PyDict>, String, u64, String);

/// The hash of a sweep and its number of cases, without running any.
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

/// Runs a sweep, or a shard such as "3/8", if its rows fit into `memory_bytes`. The sweep is a file's path or a text;
/// `base` is the scenario if the sweep names none. 0 threads: one per processor. Calls `tell` with the numbers of
/// completed and of all cases.
///
/// The columns, the hash of the whole sweep, its number of cases, and the text of all its inputs.
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
    memory_bytes: u64,
    tell: Option<Py<PyAny>>,
) -> PyResult<Swept<'py>> {
    let shard: Shard = shard.parse().map_err(error::value)?;
    let sources = Sources::of(path, text, base);
    let done = Arc::new([const { AtomicU64::new(0) }; 2]);
    let counted = done.clone();
    let tell = move |py: Python<'_>| {
        let [done, all] = counted.each_ref().map(|count| count.load(Ordering::Relaxed));
        tell.as_ref().filter(|_| all > 0).map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let work = move |stop: &AtomicBool| {
        let plan = sources.plan(&settings)?;
        let layout = plan.layout(shard);
        let all = layout.part_cases();
        done[1].store(all, Ordering::Relaxed);
        let mut columns = Columns::for_cases(&plan.design, all, memory_bytes).map_err(Failed::NoRoom)?;
        let (_folder, part) = temporary_part(layout)?;
        let count = |cases: u64| {
            done[0].fetch_add(cases, Ordering::Relaxed);
        };
        let progress = Progress { stop, begun: &|_| (), done: &count };
        let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
        if execute(&plan, &part, Execution { threads, shares_runs: true }, &progress)? < all {
            return Ok(None);
        }
        columns.fill(&plan.design, |row| {
            Rows(vec![part]).each(|case, outcome, metrics| {
                row(case, outcome, metrics);
                Ok(())
            })
        })?;
        Ok(Some((columns, plan.hash(), plan.design.cases(), plan.canonical().to_owned())))
    };
    let swept = interruptible_with_progress(py, threads, &tell, work)?.map_err(|failed: Failed| failed.raise(py))?;
    // Only a signal stops a sweep, and its exception has been raised.
    let (columns, hash, cases, inputs) = swept.ok_or_else(|| error::value("the sweep was interrupted"))?;
    tell(py)?;
    Ok((columns.hand_over(py)?, hash, cases, inputs))
}

const CASES_AT_ONCE: u64 = 16;

/// Runs a sweep, or a shard, with user-defined parts, by role: in threads if all are compiled, otherwise case by case.
/// Returns the same as [`sweep`].
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes a job and how to run it")]
pub(crate) fn sweep_with<'py>(
    py: Python<'py>,
    path: Option<&str>,
    text: &str,
    base: Option<&Scenario>,
    settings: Vec<String>,
    parts: &Bound<'py, PyDict>,
    shard: &str,
    threads: usize,
    memory_bytes: u64,
    tell: Option<Py<PyAny>>,
) -> PyResult<Swept<'py>> {
    let shard: Shard = shard.parse().map_err(error::value)?;
    let plan = Sources::of(path, text, base).plan(&settings).map_err(|error| error::scenario(py, &error))?;
    let layout = plan.layout(shard);
    let mut of_packs = layout.packs.clone().map(|pack| layout.cases_of(pack));
    let begin =
        of_packs.next().map_or(0..0, |cases| cases.start..of_packs.next_back().map_or(cases.end, |last| last.end));
    let cases = begin.end - begin.start;
    let columns = Columns::for_cases(&plan.design, cases, memory_bytes);
    let mut columns = columns.map_err(|no_room| Failed::NoRoom(no_room).raise(py))?;
    let tell = |py: Python<'_>, done: u64| tell.as_ref().map_or(Ok(()), |tell| tell.call1(py, (done, cases)).map(drop));
    let (columns, plan) = if let Some(compiled) = CompiledParts::of(parts)? {
        let offset = begin.start;
        let work = move |done: &AtomicU64| {
            let rows = try_map(cases.div_ceil(CASES_AT_ONCE) as usize, |turn| {
                let first = offset + turn as u64 * CASES_AT_ONCE;
                let mut maker = plan.maker();
                let of_case = |case| {
                    let row = of_case(&plan, &mut maker, case, |scenario| measure_compiled(scenario, &compiled));
                    done.fetch_add(1, Ordering::Relaxed);
                    row
                };
                (first..(first + CASES_AT_ONCE).min(offset + cases)).map(of_case).collect::<Result<Vec<_>, Failed>>()
            })?;
            columns.fill(&plan.design, |row| {
                let rows = rows.into_iter().flatten().zip(offset..);
                rows.for_each(|((outcome, values), case)| row(case, outcome, &values));
                Ok::<_, Failed>(())
            })?;
            Ok((columns, plan))
        };
        let swept = interruptible_with_count(py, threads, tell, work)?;
        swept.map_err(|failed: Failed| failed.raise(py))?
    } else {
        let mut maker = plan.maker();
        columns
            .fill(&plan.design, |row| {
                for case in begin.clone() {
                    let measure = |scenario: &_| measure_with(py, scenario, parts);
                    let (outcome, values) = of_case(&plan, &mut maker, case, measure)?;
                    row(case, outcome, &values);
                    tell(py, case + 1 - begin.start).map_err(Failed::Python)?;
                }
                Ok::<_, Failed>(())
            })
            .map_err(|failed| failed.raise(py))?;
        (columns, plan)
    };
    let all = plan.design.cases();
    Ok((columns.hand_over(py)?, plan.hash(), all, plan.canonical().to_owned()))
}

/// The document of a complete sweep, from the text of all its inputs, its hash, and its rows: the code of each outcome
/// and one column per metric.
#[pyfunction]
pub(crate) fn sweep_document<'py>(
    py: Python<'py>,
    inputs: &str,
    hash: String,
    outcomes: PyReadonlyArray1<'py, u8>,
    columns: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let design = stored_design(&text_source("sweep", inputs)).map_err(|error| error::scenario(py, &error))?;
    let column = |column: &Column| {
        let values = columns.get_item(&column.name)?;
        let values = values.ok_or_else(|| error::value(format!("no column {:?}", column.name)))?;
        samples(&values.extract()?)
    };
    let metrics = design.columns.iter().map(column).collect::<PyResult<Vec<_>>>()?;
    let outcomes = outcomes.as_slice().map_err(error::value)?.to_vec();
    let work = move |_: &AtomicBool| {
        let (_folder, rows) = stored_rows(&design, &outcomes, &metrics)?;
        let (findings, cases) = (findings(&design, &rows)?, DrawnCases::of(&design, &rows)?);
        let report = SweepReport { design: &design, hash: &hash, findings: &findings, cases: Some(&cases) };
        Ok::<_, Failed>(document::contents(&report.document(), false))
    };
    convert::python(py, &interruptible(py, 1, work)?.map_err(|failed| failed.raise(py))?)
}

/// Writes the rows of a complete sweep into a file for the statistics. Returns the rows and the temporary folder.
fn stored_rows(design: &Design, outcomes: &[u8], metrics: &[Vec<f64>]) -> Result<(TempDir, Rows), Failed> {
    let cases = design.cases();
    let layout = Layout { key: 0, columns: metrics.len(), cases, packs: 0..cases.div_ceil(PACK_CASES) };
    let ((folder, part), mut rows) = (temporary_part(layout)?, PackRows::default());
    for pack in part.layout().packs.clone() {
        rows.clear();
        for case in part.layout().cases_of(pack) {
            let case = case as usize;
            let outcome = [Outcome::Completed, Outcome::Diverged, Outcome::Failed][usize::from(outcomes[case].min(2))];
            rows.push(outcome, metrics.iter().map(|column| Some(column[case])));
        }
        part.write(pack, &mut rows)?;
    }
    Ok((folder, Rows(vec![part])))
}

fn temporary_part(layout: Layout) -> Result<(TempDir, Part), SweepError> {
    let io = |source| SweepError::Io { path: std::env::temp_dir(), source };
    let folder = tempfile::Builder::new().prefix("trocar-sweep-").tempdir().map_err(io)?;
    let part = Part::open(&folder.path().join(trocar_studies::sweep::CASES), layout)?;
    // On Unix, open files need no name: removed now, the folder leaves nothing behind even if the process is killed.
    #[cfg(unix)]
    std::fs::remove_dir_all(folder.path()).map_err(io)?;
    Ok((folder, part))
}

fn of_case(
    plan: &Plan,
    maker: &mut CaseMaker<'_>,
    case: u64,
    measure: impl FnOnce(&trocar_scenario::Scenario) -> PyResult<Result<Metrics, RunError>>,
) -> Result<(Outcome, Vec<f64>), Failed> {
    let scenario = maker.scenario(case)?;
    let (outcome, metrics) = match measure(&scenario).map_err(Failed::Python)? {
        Ok(metrics) => (Outcome::of(metrics.outcome), Some(metrics)),
        Err(RunError::Engine { .. }) => (Outcome::Failed, None),
        Err(refused) => return Err(maker.refused(case, refused).into()),
    };
    let value = |column: &Column| metrics.as_ref().and_then(|metrics| column.value(metrics, None));
    Ok((outcome, plan.design.columns.iter().map(|column| value(column).unwrap_or(f64::NAN)).collect()))
}

/// The metrics of a sweep: name, scope, label, unit, which values are better, and meaning. Metrics of
/// ruptures and events have the number 1.
#[pyfunction]
pub(crate) fn metrics() -> Vec<(String, &'static str, String, &'static str, &'static str, &'static str)> {
    let columns =
        |m: &Declaration| (m.key(1), m.scope.word(), m.full_label(1), m.unit.si(), m.better.word(), m.meaning);
    Column::declarations().map(columns).collect()
}
