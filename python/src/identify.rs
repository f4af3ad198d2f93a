//! Identification of machines, arms and tissues.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_document::{Study, to_json};
use trocar_identify::{
    IdentifyError, MachineColumns, Measured, Part, PartColumns, PartRequest, Request, STEPS, Signals,
    identify as slave, identify_part,
};
use trocar_recording::{Column, Limits};
use trocar_scenario::parse_column;

use crate::interrupt::interruptible_with_progress;
use crate::{convert, document, error};

/// The columns of the recordings, in the form `COLUMN:UNIT`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Columns {
    time: String,
    master: Option<String>,
    slave: Option<String>,
    force: String,
    actuator: Option<String>,
    desired: Option<String>,
}

enum Used {
    Slave(MachineColumns),
    Part(Part, PartColumns),
}

impl Used {
    /// Checks that each needed column is given, and none that is not used.
    fn of(machine: &str, columns: &Columns) -> PyResult<Self> {
        let Columns { time, master, slave, force, actuator, desired } = columns;
        for (name, column, machines) in [
            ("master", master, &["slave", "arm", "master"][..]),
            ("slave", slave, &["slave", "tissue"]),
            ("actuator", actuator, &["slave", "master"]),
            ("desired", desired, &["arm"]),
        ] {
            if column.is_some() && !machines.contains(&machine) {
                return Err(error::value(format!(
                    "{name} is not used with machine=\"{machine}\"; leave it out, or identify {}",
                    machines.join(" or ")
                )));
            }
        }
        let column = |text: &str, unit| parse_column(text, unit).map_err(error::value);
        let optional = |text: &Option<String>, unit| text.as_ref().map(|text| column(text, unit)).transpose();
        let needed = |name: &str, text: &Option<String>| -> PyResult<Column> {
            let missing = || error::value(format!("machine=\"{machine}\" needs {name}: the column with its position"));
            column(text.as_ref().ok_or_else(missing)?, "m")
        };
        let (time, force) = (column(time, "s")?, column(force, "N")?);
        let part = |part, position, input| {
            Self::Part(part, PartColumns { time: time.clone(), position, force: force.clone(), input })
        };
        Ok(match machine {
            "slave" => Self::Slave(MachineColumns {
                master: needed("master", master)?,
                slave: needed("slave", slave)?,
                actuator: optional(actuator, "N")?,
                time,
                force,
            }),
            "master" => part(Part::Master, needed("master", master)?, optional(actuator, "N")?),
            "arm" => part(Part::Arm, needed("master", master)?, optional(desired, "m")?),
            "tissue" => part(Part::Tissue, needed("slave", slave)?, None),
            other => {
                let must = "\"slave\", \"master\", \"arm\" or \"tissue\"";
                return Err(error::value(format!("machine is {other:?}, must be {must}")));
            }
        })
    }
}

type Identified<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<(String, String)>, Bound<'py, PyDict>);

/// The content of `identification.json`, the document, the files with their texts, and the data tables. A recording in
/// `folder` is known by its file name. Calls `tell` with the numbers of completed and of all steps.
#[pyfunction]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    machine: &str,
    recordings: Vec<PathBuf>,
    predict: Vec<PathBuf>,
    folder: PathBuf,
    columns: Columns,
    tell: Option<Py<PyAny>>,
) -> PyResult<Identified<'py>> {
    let used = Used::of(machine, &columns)?;
    let limits = Limits::default();
    let counts = Arc::new([AtomicUsize::new(0), AtomicUsize::new(STEPS)]);
    let counted = counts.clone();
    let tell = |py: Python<'_>| {
        let [done, all] = counts.each_ref().map(|count| count.load(Ordering::Relaxed));
        tell.as_ref().map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let name = move |path: &PathBuf| path.strip_prefix(&folder).unwrap_or(path).display().to_string();
    let identified = interruptible_with_progress(py, 0, tell, move |_| {
        let study: Box<dyn Study + Send> = match &used {
            Used::Slave(columns) => {
                let open = |path: &PathBuf| {
                    let mut measured = Measured::open(path, columns, &limits)?;
                    measured.name = name(path);
                    Ok(measured)
                };
                let (training, predictions) = opened(&recordings, &predict, open)?;
                let step = || {
                    counted[0].fetch_add(1, Ordering::Relaxed);
                };
                Box::new(slave(Request { training, predictions }, step)?)
            }
            Used::Part(part, columns) => {
                let open = |path: &PathBuf| {
                    let mut signals = Signals::open(path, *part, columns, &limits)?;
                    signals.name = name(path);
                    Ok(signals)
                };
                let (training, predictions) = opened(&recordings, &predict, open)?;
                let step = |done: usize, all: usize| {
                    counted[0].store(done, Ordering::Relaxed);
                    counted[1].store(all, Ordering::Relaxed);
                };
                Box::new(identify_part(*part, PartRequest { training, predictions }, step)?)
            }
        };
        Ok(study)
    })?;
    tell(py)?;
    let study = identified.map_err(|error: IdentifyError| error::value(error))?;
    let found = study.document();
    let files = found.files.iter().map(|file| (file.name.to_string(), file.text.clone())).collect();
    let json = convert::parsed(py, &to_json(&found.json))?;
    Ok((json, document::dictionary(py, &found, false)?, files, document::data(py, &found)?))
}

fn opened<T>(
    recordings: &[PathBuf],
    predict: &[PathBuf],
    open: impl Fn(&PathBuf) -> Result<T, IdentifyError>,
) -> Result<(Vec<T>, Vec<T>), IdentifyError> {
    let all = |paths: &[PathBuf]| paths.iter().map(&open).collect::<Result<Vec<T>, IdentifyError>>();
    Ok((all(recordings)?, all(predict)?))
}
