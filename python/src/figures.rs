//! The figures of the command line as data, which `trocar/_figures.py` draws with matplotlib. Figures of every sample
//! are described on demand.

use std::collections::HashMap;

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_core::detector::DistanceKind;
use trocar_document::Document;
use trocar_engine::engine::TrustColumns;
use trocar_figures::{ESTIMATION_FIGURES, EnergyView, EstimationView, RUN_FIGURES, RunView};
use trocar_studies::{compare, run};

use crate::scenario::Scenario;
use crate::{convert, document, error};

/// A run: its scenario, its columns, the times of its ruptures and alarms in s, and the maximum energy, in J, that its
/// passivity scheme promises to generate.
type RunData<'py> = (PyRef<'py, Scenario>, Bound<'py, PyDict>, Vec<f64>, Vec<f64>, Option<f64>);

/// The numeric columns of a result, borrowed while a figure is described.
struct Columns<'py>(HashMap<String, PyReadonlyArray1<'py, f64>>);

impl<'py> Columns<'py> {
    fn of(columns: &Bound<'py, PyDict>) -> PyResult<Self> {
        let mut all = HashMap::new();
        for (name, column) in columns {
            // Skip columns of codes, which are not float64.
            if let Ok(column) = column.extract() {
                all.insert(name.extract()?, column);
            }
        }
        Ok(Self(all))
    }

    fn get(&self, name: &str) -> PyResult<&[f64]> {
        let column = self.0.get(name).ok_or_else(|| error::value(format!("no column {name:?}")))?;
        column.as_slice().map_err(error::value)
    }

    /// The trust in the estimates from the columns of position and velocity. `sampling` has the contact position in m
    /// and the sampling interval in s.
    fn trust(&self, [position, velocity]: [&str; 2], sampling: (f64, f64)) -> PyResult<TrustColumns> {
        let motion = (self.get(position)?, self.get(velocity)?);
        let parameters = (self.get("stiffness_n_per_m")?, self.get("damping_n_s_per_m")?);
        Ok(TrustColumns::of(sampling, motion, self.get("residual_n")?, parameters))
    }

    fn estimation<'a>(&'a self, about: About<'a>, trust: TrustColumns) -> PyResult<EstimationView<'a>> {
        Ok(EstimationView {
            name: about.name,
            time_s: self.get("time_s")?,
            measured_force_n: self.get("measured_force_n")?,
            residual_n: self.get("residual_n")?,
            stiffness_n_per_m: self.get("stiffness_n_per_m")?,
            damping_n_s_per_m: self.get("damping_n_s_per_m")?,
            standard_errors: Some([trust.stiffness_std_n_per_m.into(), trust.damping_std_n_s_per_m.into()]),
            extra_parameter: about.extra.map(|name| Ok::<_, PyErr>((name, self.get(name)?))).transpose()?,
            decision: self.get("decision")?,
            threshold: about.threshold,
            decision_unit: about.distance.unit(),
            rupture_times_s: about.ruptures_s.into(),
            alarm_times_s: about.alarms_s.into(),
        })
    }
}

struct About<'a> {
    name: &'a str,
    /// The column of the estimator's extra parameter, if any.
    extra: Option<&'static str>,
    threshold: f64,
    distance: DistanceKind,
    ruptures_s: &'a [f64],
    alarms_s: &'a [f64],
}

struct RunColumns<'py> {
    scenario: PyRef<'py, Scenario>,
    columns: Columns<'py>,
    mode: PyReadonlyArray1<'py, u8>,
    ruptures_s: Vec<f64>,
    alarms_s: Vec<f64>,
    promised_energy_j: Option<f64>,
}

impl<'py> RunColumns<'py> {
    fn of((scenario, columns, ruptures_s, alarms_s, promised_energy_j): RunData<'py>) -> PyResult<Self> {
        let mode = columns.get_item("mode")?.ok_or_else(|| error::value("no column \"mode\""))?.extract()?;
        let columns = Columns::of(&columns)?;
        Ok(Self { scenario, columns, mode, ruptures_s, alarms_s, promised_energy_j })
    }

    fn view(&self) -> PyResult<RunView<'_>> {
        let Self { scenario, columns, mode, ruptures_s, alarms_s, .. } = self;
        Ok(RunView {
            name: &scenario.scenario.name,
            is_augmented: scenario.scenario.augmentation.enabled,
            time_s: columns.get("time_s")?,
            master_position_m: columns.get("master_position_m")?,
            slave_position_m: columns.get("slave_position_m")?,
            operator_force_n: columns.get("operator_force_n")?,
            tissue_force_n: columns.get("tissue_force_n")?,
            feedback_force_n: columns.get("feedback_force_n")?,
            mode: mode.as_slice().map_err(error::value)?,
            event: run::event_shade(scenario.scenario.augmentation.hold),
            rupture_times_s: ruptures_s.into(),
            alarm_times_s: alarms_s.into(),
        })
    }

    fn estimation(&self) -> PyResult<EstimationView<'_>> {
        let scenario = &self.scenario.scenario;
        let about = About {
            name: &scenario.name,
            extra: scenario.estimator.extra_parameter_column(),
            threshold: scenario.detector.cusum.threshold,
            distance: scenario.detector.distance.kind,
            ruptures_s: &self.ruptures_s,
            alarms_s: &self.alarms_s,
        };
        self.columns.estimation(about, trust_of_run(scenario, &self.columns)?)
    }

    fn energies(&self) -> PyResult<EnergyView<'_>> {
        let Self { scenario, columns, promised_energy_j, .. } = self;
        Ok(EnergyView {
            name: &scenario.scenario.name,
            time_s: columns.get("time_s")?,
            hand_energy_j: columns.get("hand_energy_j")?,
            master_energy_j: columns.get("master_energy_j")?,
            reference_energy_j: columns.get("reference_energy_j")?,
            needle_energy_j: columns.get("needle_energy_j")?,
            energy_scale: scenario.scenario.link.machines.energy_scale(),
            promised_energy_j: *promised_energy_j,
        })
    }
}

fn trust_of_run(scenario: &trocar_scenario::Scenario, columns: &Columns<'_>) -> PyResult<TrustColumns> {
    columns.trust(["slave_position_m", "slave_velocity_m_per_s"], (scenario.contact_m, scenario.grid.tick_s()))
}

pub(crate) fn run_trust(scenario: &trocar_scenario::Scenario, columns: &Bound<'_, PyDict>) -> PyResult<TrustColumns> {
    trust_of_run(scenario, &Columns::of(columns)?)
}

#[pyfunction]
pub(crate) fn figure_names() -> (Vec<&'static str>, Vec<&'static str>) {
    let of_estimation = || ESTIMATION_FIGURES.into_iter().map(|(name, _)| name);
    (RUN_FIGURES.into_iter().map(|(name, _)| name).chain(of_estimation()).collect(), of_estimation().collect())
}

/// One figure of all runs, or the estimation of the first. `window` is in s; `None` means the time around the first
/// rupture, or the whole time of an estimation.
#[pyfunction]
pub(crate) fn run_figure<'py>(
    py: Python<'py>,
    figure: &str,
    runs: Vec<RunData<'py>>,
    window: Option<(f64, f64)>,
) -> PyResult<Bound<'py, PyAny>> {
    let runs = runs.into_iter().map(RunColumns::of).collect::<PyResult<Vec<_>>>()?;
    let drawn = if let Some((_, draw)) = RUN_FIGURES.into_iter().find(|(name, _)| *name == figure) {
        draw(&runs.iter().map(RunColumns::view).collect::<PyResult<Vec<_>>>()?, window)
    } else if let Some((_, draw)) = ESTIMATION_FIGURES.into_iter().find(|(name, _)| *name == figure) {
        let first = runs.first().ok_or_else(|| error::value("no run to draw"))?;
        draw(&first.estimation()?)
    } else {
        return Err(error::value(format!("figure is {figure:?}, must be one of {}", figure_names().0.join(", "))));
    };
    convert::python(py, &drawn.map_err(error::value)?.description())
}

#[pyfunction]
pub(crate) fn run_figures<'py>(py: Python<'py>, run: RunData<'py>) -> PyResult<Bound<'py, PyAny>> {
    let columns = RunColumns::of(run)?;
    let mut drawn = Document::default();
    run::add_figures(&mut drawn, columns.view()?, &columns.estimation()?, &columns.energies()?);
    convert::python(py, &document::figures(&drawn))
}

#[pyfunction]
pub(crate) fn comparison_figures<'py>(py: Python<'py>, runs: Vec<RunData<'py>>) -> PyResult<Bound<'py, PyAny>> {
    let runs = runs.into_iter().map(RunColumns::of).collect::<PyResult<Vec<_>>>()?;
    let views = runs.iter().map(RunColumns::view).collect::<PyResult<Vec<_>>>()?;
    let estimations = runs.iter().map(RunColumns::estimation).collect::<PyResult<Vec<_>>>()?;
    let mut drawn = Document::default();
    compare::add_figures(&mut drawn, &views, estimations);
    convert::python(py, &document::figures(&drawn))
}

/// The figures of an estimation in a recording, by name. `sampling` has the contact position in m and the sampling
/// interval in s; `distance` is the word of the detector's distance.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes what it has of a detection")]
pub(crate) fn detection_figures<'py>(
    py: Python<'py>,
    name: &str,
    columns: &Bound<'py, PyDict>,
    sampling: (f64, f64),
    threshold: f64,
    distance: &str,
    ruptures_s: Vec<f64>,
    alarms_s: Vec<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let distance = DistanceKind::ALL.into_iter().find(|kind| kind.word() == distance);
    let distance = distance.ok_or_else(|| error::value("an unknown distance"))?;
    let columns = Columns::of(columns)?;
    let trust = columns.trust(["position_m", "velocity_m_per_s"], sampling)?;
    let extra = ["friction_n", "power"].into_iter().find(|name| columns.0.contains_key(*name));
    let about = About { name, extra, threshold, distance, ruptures_s: &ruptures_s, alarms_s: &alarms_s };
    let view = columns.estimation(about, trust)?;
    let mut drawn = Document::default();
    ESTIMATION_FIGURES.into_iter().for_each(|(name, draw)| drawn.figure(name, draw(&view)));
    convert::python(py, &document::figures(&drawn))
}
