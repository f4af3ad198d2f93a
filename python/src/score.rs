//! Scores of alarms against ruptures.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use trocar_detect::{Scores, Tally, match_alarms};

use crate::arrays::samples;
use crate::{convert, error};

type Scored<'py> = (Bound<'py, PyAny>, Vec<(usize, usize)>);

/// Scores alarms against ruptures, both in s and ascending. Returns the scores and the matches: pairs of the indices of
/// a rupture and its alarm. The recorded time is NaN if unknown.
#[pyfunction]
pub(crate) fn score<'py>(
    py: Python<'py>,
    alarms_s: PyReadonlyArray1<'py, f64>,
    ruptures_s: PyReadonlyArray1<'py, f64>,
    within_s: f64,
    recorded_s: f64,
) -> PyResult<Scored<'py>> {
    let (alarms_s, ruptures_s) = (samples(&alarms_s)?, samples(&ruptures_s)?);
    for (name, times_s) in [("alarms_s", &alarms_s), ("ruptures_s", &ruptures_s)] {
        if let Some(time_s) = times_s.iter().find(|time_s| !time_s.is_finite()) {
            return Err(error::value(format!("{name} has {time_s}, must be finite")));
        }
    }
    if !(within_s.is_finite() && within_s >= 0.0) {
        return Err(error::value(format!("within_s is {within_s}, must be a finite number of at least 0")));
    }
    if recorded_s.is_infinite() || recorded_s <= 0.0 {
        return Err(error::value(format!("recorded_s is {recorded_s}, must be a finite number above 0")));
    }
    let matches = match_alarms(&alarms_s, &ruptures_s, within_s);
    let tally = Tally {
        recordings: 1,
        ruptures: ruptures_s.len(),
        alarms: alarms_s.len(),
        delays_s: matches.iter().map(|one| one.delay_s).collect(),
        recorded_s: if recorded_s.is_nan() { 0.0 } else { recorded_s },
        contact_s: 0.0,
    };
    let mut scores = serde_json::to_value(Scores::of(&tally)).map_err(error::value)?;
    if let Some(scores) = scores.as_object_mut() {
        // Leave out the scores whose inputs were not given.
        for name in ["recordings", "recorded_s", "contact_s", "false_alarms_per_contact_minute"] {
            scores.remove(name);
        }
    }
    let pairs = matches.iter().map(|one| (one.label, one.alarm)).collect();
    Ok((convert::python(py, &scores)?, pairs))
}
