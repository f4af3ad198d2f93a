//! The figures as data, which `trocar/_figures.py` draws with matplotlib. They are those of the command line.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_core::detector::DistanceKind;
use trocar_engine::engine::TrustColumns;
use trocar_figures::{
    CharacteristicView, ESTIMATION_FIGURES, EstimationView, FigureError, MapAxisView, MapView, RUN_FIGURES, RunView,
    characteristic, stability_map,
};
use trocar_stability::Parameter;

use crate::scenario::Scenario;
use crate::{convert, error};

/// A run: its scenario, its columns, and the times of its ruptures and alarms in s.
type RunData<'py> = (PyRef<'py, Scenario>, Bound<'py, PyDict>, Vec<f64>, Vec<f64>);

/// The curve of a detector: its name, and by point false alarms per minute, detected share and median delay in s.
type CurveData = (String, Vec<f64>, Vec<f64>, Vec<f64>);

/// The columns of a result, borrowed while a figure is made.
struct Columns<'py> {
    columns: Bound<'py, PyDict>,
}

impl<'py> Columns<'py> {
    fn get<T: numpy::Element>(&self, name: &str) -> PyResult<PyReadonlyArray1<'py, T>> {
        let column = self.columns.get_item(name)?.ok_or_else(|| error::value(format!("no column {name:?}")))?;
        let column: PyReadonlyArray1<'py, T> = column.extract()?;
        Ok(column)
    }
}

fn slice<'a, 'py, T: numpy::Element>(column: &'a PyReadonlyArray1<'py, T>) -> PyResult<&'a [T]> {
    column.as_slice().map_err(error::value)
}

fn unknown(name: &str, known: impl Iterator<Item = &'static str>) -> PyErr {
    let known: Vec<&str> = known.collect();
    error::value(format!("figure is {name:?}, must be one of {}", known.join(", ")))
}

/// Returns the names of the figures of a run and of a detection.
#[pyfunction]
pub(crate) fn figure_names() -> (Vec<&'static str>, Vec<&'static str>) {
    let of_estimation = || ESTIMATION_FIGURES.into_iter().map(|(name, _)| name);
    (RUN_FIGURES.into_iter().map(|(name, _)| name).chain(of_estimation()).collect(), of_estimation().collect())
}

/// Returns a figure of runs: all of them in one, or the estimation of the first. `window` is in s; `None` for the time around the first
/// rupture, or for all of an estimation.
#[pyfunction]
pub(crate) fn run_figure<'py>(
    py: Python<'py>,
    figure: &str,
    runs: Vec<RunData<'py>>,
    window: Option<(f64, f64)>,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some((_, draw)) = RUN_FIGURES.into_iter().find(|(name, _)| *name == figure) {
        const NAMES: [&str; 6] = [
            "time_s",
            "master_position_m",
            "slave_position_m",
            "operator_force_n",
            "tissue_force_n",
            "feedback_force_n",
        ];
        let columns: Vec<_> = runs
            .iter()
            .map(|(_, columns, ..)| {
                let columns = Columns { columns: columns.clone() };
                let numbers = NAMES.map(|name| columns.get::<f64>(name));
                Ok((numbers.into_iter().collect::<PyResult<Vec<_>>>()?, columns.get::<u8>("mode")?))
            })
            .collect::<PyResult<_>>()?;
        let views = runs.iter().zip(&columns).map(|((scenario, _, ruptures_s, alarms_s), (numbers, mode))| {
            Ok(RunView {
                name: &scenario.scenario.name,
                is_augmented: scenario.scenario.augmentation.enabled,
                time_s: slice(&numbers[0])?,
                master_position_m: slice(&numbers[1])?,
                slave_position_m: slice(&numbers[2])?,
                operator_force_n: slice(&numbers[3])?,
                tissue_force_n: slice(&numbers[4])?,
                feedback_force_n: slice(&numbers[5])?,
                mode: slice(mode)?,
                rupture_times_s: ruptures_s.into(),
                alarm_times_s: alarms_s.into(),
            })
        });
        let views = views.collect::<PyResult<Vec<_>>>()?;
        return convert::python(py, &draw(&views, window).map_err(refused)?.description());
    }
    let [(scenario, columns, ruptures_s, alarms_s), ..] = &runs[..] else {
        return Err(error::value("no run to draw"));
    };
    let trust = trust_of_run(&scenario.scenario, columns)?;
    let columns = Columns { columns: columns.clone() };
    let detector = &scenario.scenario.detector;
    let about = About {
        name: &scenario.scenario.name,
        extra: scenario.scenario.estimator.extra_parameter_column(),
        threshold: detector.cusum.threshold,
        distance: detector.distance.kind,
    };
    estimation(py, figure, &columns, &about, &trust, (ruptures_s, alarms_s))
}

/// The trust in the estimates of a run, from the columns of its trace.
pub(crate) fn trust_of_run(
    scenario: &trocar_scenario::Scenario,
    columns: &Bound<'_, PyDict>,
) -> PyResult<TrustColumns> {
    let columns = Columns { columns: columns.clone() };
    trust_of(&columns, ["slave_position_m", "slave_velocity_m_per_s"], (scenario.contact_m, scenario.grid.tick_s()))
}

/// The trust in estimates, from columns with the position and the velocity that are named; `sampling` has the contact in m and the time
/// between two samples in s.
fn trust_of(columns: &Columns<'_>, [position, velocity]: [&str; 2], sampling: (f64, f64)) -> PyResult<TrustColumns> {
    let names = [position, velocity, "residual_n", "stiffness_n_per_m", "damping_n_s_per_m"];
    let all = names.map(|name| columns.get::<f64>(name)).into_iter().collect::<PyResult<Vec<_>>>()?;
    let [position, velocity, residual, stiffness, damping] = &all[..] else { return Err(error::value("no columns")) };
    let motion = (slice(position)?, slice(velocity)?);
    Ok(TrustColumns::of(sampling, motion, slice(residual)?, (slice(stiffness)?, slice(damping)?)))
}

/// Returns a figure of a detection; `sampling` has its contact position in m and the time between two samples in s, `distance` is the
/// word of its distance.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn detection_figure<'py>(
    py: Python<'py>,
    figure: &str,
    name: &str,
    columns: Bound<'py, PyDict>,
    sampling: (f64, f64),
    threshold: f64,
    distance: &str,
    ruptures_s: Vec<f64>,
    alarms_s: Vec<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let distance = DistanceKind::ALL.into_iter().find(|kind| kind.word() == distance);
    let distance = distance.ok_or_else(|| error::value("an unknown distance"))?;
    let columns = Columns { columns };
    let trust = trust_of(&columns, ["position_m", "velocity_m_per_s"], sampling)?;
    let extra = ["friction_n", "power"].into_iter().find(|name| columns.columns.contains(name).unwrap_or(false));
    let about = About { name, extra, threshold, distance };
    estimation(py, figure, &columns, &about, &trust, (&ruptures_s, &alarms_s))
}

/// What an estimation is of.
struct About<'a> {
    name: &'a str,
    /// The column of the estimator's extra parameter, if any.
    extra: Option<&'static str>,
    threshold: f64,
    distance: DistanceKind,
}

fn estimation<'py>(
    py: Python<'py>,
    figure: &str,
    columns: &Columns<'py>,
    about: &About<'_>,
    trust: &TrustColumns,
    (ruptures_s, alarms_s): (&[f64], &[f64]),
) -> PyResult<Bound<'py, PyAny>> {
    let drawn = ESTIMATION_FIGURES.into_iter().find(|(name, _)| *name == figure);
    let (_, draw) = drawn.ok_or_else(|| unknown(figure, figure_names().0.into_iter()))?;
    let names = ["time_s", "measured_force_n", "residual_n", "stiffness_n_per_m", "damping_n_s_per_m", "decision"];
    let numbers = names.map(|name| columns.get::<f64>(name)).into_iter().collect::<PyResult<Vec<_>>>()?;
    let extra = about.extra.map(|name| Ok::<_, PyErr>((name, columns.get::<f64>(name)?))).transpose()?;
    let unit = about.distance.unit();
    let view = EstimationView {
        name: about.name,
        time_s: slice(&numbers[0])?,
        measured_force_n: slice(&numbers[1])?,
        residual_n: slice(&numbers[2])?,
        stiffness_n_per_m: slice(&numbers[3])?,
        damping_n_s_per_m: slice(&numbers[4])?,
        standard_errors: Some([(&*trust.stiffness_std_n_per_m).into(), (&*trust.damping_std_n_s_per_m).into()]),
        extra_parameter: match &extra {
            Some((name, column)) => Some((*name, slice(column)?)),
            None => None,
        },
        decision: slice(&numbers[5])?,
        threshold: about.threshold,
        decision_unit: unit,
        rupture_times_s: ruptures_s.into(),
        alarm_times_s: alarms_s.into(),
    };
    convert::python(py, &draw(&view).map_err(refused)?.description())
}

/// Returns the map of a stability analysis. An axis is its key, its values, whether it is logarithmic, and the scenario's value.
/// `simulated` is 1 where the motion decays, 0 where it grows, and -1 elsewhere; empty without simulations.
#[pyfunction]
pub(crate) fn stability_figure<'py>(
    py: Python<'py>,
    name: &str,
    x: (String, PyReadonlyArray1<'py, f64>, bool, f64),
    y: (String, PyReadonlyArray1<'py, f64>, bool, f64),
    stable: PyReadonlyArray1<'py, bool>,
    boundary: PyReadonlyArray1<'py, f64>,
    simulated: Option<PyReadonlyArray1<'py, i8>>,
) -> PyResult<Bound<'py, PyAny>> {
    let pieces: Vec<[(f64, f64); 2]> =
        slice(&boundary)?.chunks_exact(4).map(|piece| [(piece[0], piece[1]), (piece[2], piece[3])]).collect();
    let grew: Vec<Option<bool>> = match &simulated {
        Some(codes) => slice(codes)?.iter().map(|code| (*code >= 0).then_some(*code == 0)).collect(),
        None => vec![],
    };
    let view = MapView { name, x: axis(&x)?, y: axis(&y)?, stable: slice(&stable)?, boundary: &pieces, grew: &grew };
    convert::python(py, &stability_map(&view).map_err(refused)?.description())
}

fn axis<'a, 'py>(
    (key, values, is_logarithmic, scenario_value): &'a (String, PyReadonlyArray1<'py, f64>, bool, f64),
) -> PyResult<MapAxisView<'a>> {
    Ok(MapAxisView {
        caption: Parameter::of_key(key).map_or(key.as_str(), |parameter| parameter.caption()),
        values: slice(values)?,
        is_logarithmic: *is_logarithmic,
        scenario_value: *scenario_value,
    })
}

/// Returns the operating characteristics of detectors. `min_per_minute` is the rate of one false alarm in the whole time.
#[pyfunction]
pub(crate) fn roc_figure<'py>(
    py: Python<'py>,
    name: &str,
    curves: Vec<CurveData>,
    min_per_minute: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let views: Vec<CharacteristicView<'_>> = curves
        .iter()
        .map(|(name, rates, detection, delays_s)| CharacteristicView {
            name,
            false_alarms_per_minute: rates.clone(),
            detection: detection.clone(),
            delay_median_s: delays_s.clone(),
        })
        .collect();
    convert::python(py, &characteristic(name, &views, min_per_minute).map_err(refused)?.description())
}

fn refused(error: FigureError) -> PyErr {
    error::value(error)
}
