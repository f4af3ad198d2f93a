//! The points of a sweep file, and the members of a population.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_scenario::{Source, entries};
use trocar_studies::sweep::{AxisColumn, Plan, SamplingScheme};

use crate::arrays::put;
use crate::error;
use crate::scenario::Scenario;

/// The base, the settings, and the columns.
type Points<'py> = (String, Vec<(String, String)>, Bound<'py, PyDict>);

/// The base scenario of a sweep file, its settings for all cases as keys with values in TOML, and the first `count`
/// points, as a column per key; all points without `count`.
#[pyfunction]
pub(crate) fn sweep_points<'py>(py: Python<'py>, path: &str, count: Option<u64>) -> PyResult<Points<'py>> {
    let source = Source::parse(path);
    let raise = |error| error::scenario(py, &error);
    let entries = entries(&source).map_err(raise)?;
    let mut plan = py.detach(|| Plan::load(&source, &[])).map_err(raise)?;
    let design = &mut plan.design;
    design.seeds = 1;
    if let Some(count) = count {
        design.scheme = match design.scheme {
            // More points continue the same sequence.
            SamplingScheme::Sobol { seed, .. } => SamplingScheme::Sobol { points: count, seed },
            SamplingScheme::Random { seed, .. } => SamplingScheme::Random { points: count, seed },
            other => other,
        };
    }
    let points = design.points().unwrap_or(0);
    let count = count.unwrap_or(points);
    if count > points {
        return Err(error::value(format!("{path} has {points} points, and {count} are wanted")));
    }
    let mut columns: Vec<_> =
        design.axes.iter().map(|axis| (axis.key.path.to_string(), AxisColumn::of(axis))).collect();
    let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
    for point in 0..count {
        sampler.values(point, &mut coordinates, &mut values);
        columns.iter_mut().zip(&values).for_each(|((_, column), value)| column.push(value));
    }
    let all = PyDict::new(py);
    for (name, column) in columns {
        match column {
            AxisColumn::Number(values) => put(&all, &name, values)?,
            AxisColumn::Whole(values) => put(&all, &name, values)?,
            AxisColumn::Flag(values) => put(&all, &name, values)?,
            AxisColumn::Text(values) => all.set_item(&name, values)?,
        }
    }
    let plain = |path: &str| path.replace('"', "");
    let base = entries.iter().find(|entry| entry.path == "base").and_then(|entry| entry.value.as_str());
    let base = source.relative(base.unwrap_or_default()).display();
    let set = entries
        .iter()
        .filter_map(|entry| Some((plain(&entry.path).strip_prefix("set.")?.to_owned(), entry.value.to_string())));
    Ok((base, set.collect(), all))
}

/// The first members of the population of a scenario, as a column per key that its `[population]` draws. Empty if it
/// draws none.
#[pyfunction]
pub(crate) fn population<'py>(py: Python<'py>, scenario: &Scenario, count: u64) -> PyResult<Bound<'py, PyDict>> {
    let scenario = &scenario.scenario;
    let columns = PyDict::new(py);
    if !scenario.population.varies() {
        return Ok(columns);
    }
    let draws: Vec<_> = (0..count).map(|index| scenario.population.drawn(scenario.seed, index)).collect();
    let drawn = scenario.population.is_drawn();
    if drawn[0] {
        let arm = &scenario.arm;
        for (k, (key, value)) in [
            ("arm.k_a_n_per_m", arm.k_a_n_per_m),
            ("arm.b_a_n_s_per_m", arm.b_a_n_s_per_m),
            ("arm.k_h_n_per_m", arm.k_h_n_per_m),
            ("arm.b_h_n_s_per_m", arm.b_h_n_s_per_m),
            ("arm.m_h_kg", arm.m_h_kg),
        ]
        .into_iter()
        .enumerate()
        {
            put(&columns, key, draws.iter().map(|draw| value * draw.arm[k]).collect())?;
        }
    }
    if drawn[6] {
        // The factors; the package applies them to the keys of a spring and damper.
        put(&columns, "stiffness", draws.iter().map(|draw| draw.stiffness).collect())?;
        put(&columns, "damping", draws.iter().map(|draw| draw.damping).collect())?;
    }
    if drawn[8] {
        let delays: Vec<f64> = draws.iter().map(|draw| draw.delay_s.unwrap_or_default()).collect();
        put(&columns, "channel.forward_delay_s", delays.clone())?;
        put(&columns, "channel.backward_delay_s", delays)?;
    }
    Ok(columns)
}

/// The shipped sweep files, each with its question.
#[pyfunction]
pub(crate) fn shipped_sweeps() -> Vec<(String, String)> {
    let question = |source: &Source| {
        let entries = entries(source).unwrap_or_default();
        let entry = entries.iter().find(|entry| entry.path == "question");
        entry.and_then(|entry| entry.value.as_str()).unwrap_or_default().to_owned()
    };
    let named = trocar_scenario::shipped_sweeps().map(|name| format!("builtin:{name}"));
    named.map(|name| (name.clone(), question(&Source::parse(&name)))).collect()
}

/// True if a path is that of a sweep file.
#[pyfunction]
pub(crate) fn is_sweep(path: &str) -> bool {
    trocar_studies::sweep::is_sweep(&Source::parse(path))
}
