//! The measured columns of a tissue, an arm or a master.

use std::path::Path;

use trocar_base::warning::Warning;
use trocar_recording::{Column, Limits};

use super::Part;
use crate::IdentifyError;
use crate::filter::{half, slope};
use crate::grid::{Grid, check};
use crate::measured::{VELOCITY_HALF_S, deviation, span};

/// The columns of a recording of a part. Their factors convert to SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct PartColumns {
    /// Time in s.
    pub time: Column,
    /// Position in m: of the needle for a tissue, of the master for an arm or a master.
    pub position: Column,
    /// Force in N: on the needle, positive when it resists, for a tissue; of the hand, positive when it pushes the
    /// master forwards, for an arm or a master.
    pub force: Column,
    /// For an arm the desired position in m, for a master the force of its motor in N, positive when it pushes
    /// forwards, if the file contains it. A tissue has none.
    pub input: Option<Column>,
}

/// The samples of a recording of a part, evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    /// The recording, as in messages.
    pub name: String,
    /// Time between two samples in s.
    pub interval_s: f64,
    /// Positions in m.
    pub position_m: Vec<f64>,
    /// Forces in N.
    pub force_n: Vec<f64>,
    /// Desired positions in m, or forces of the motor in N, if recorded.
    pub input: Option<Vec<f64>>,
    pub(super) velocity_m_per_s: Vec<f64>,
    /// The warning about a file that seems to end too early.
    pub(super) unfinished: Option<Warning>,
}

impl Signals {
    /// Reads a recording. Unevenly spaced samples are resampled at their median interval.
    ///
    /// # Errors
    /// If the file cannot be read, a column is missing or has values that are not numbers, and as [`Signals::new`].
    pub fn open(path: &Path, part: Part, columns: &PartColumns, limits: &Limits) -> Result<Self, IdentifyError> {
        let PartColumns { time, position, force, input } = columns;
        let Grid { name, interval_s, position_m, force_n, others, unfinished } =
            Grid::open(path, time, position, force, input.iter(), limits)?;
        let signals = Self::new(&name, part, interval_s, position_m, force_n, others.into_iter().next())?;
        Ok(Self { unfinished, ..signals })
    }

    /// Creates the samples of a recording from columns in SI units.
    ///
    /// # Errors
    /// If columns have different lengths, the recording is too short, a value is not finite or at least 1e9, or the
    /// position or the force does not change.
    pub fn new(
        name: &str,
        part: Part,
        interval_s: f64,
        position_m: Vec<f64>,
        force_n: Vec<f64>,
        input: Option<Vec<f64>>,
    ) -> Result<Self, IdentifyError> {
        let mut columns = vec![("the position", position_m.as_slice()), ("the force", force_n.as_slice())];
        columns.extend(input.as_deref().map(|input| (part.input_name(), input)));
        check(name, interval_s, &columns)?;
        let recording = || name.to_owned();
        let span_m = span(&position_m);
        // Positions and forces of double precision do not change below this size.
        if span_m < 1e-9 {
            let (side, flag) = part.moving();
            return Err(IdentifyError::NoExcitation { recording: recording(), side, span_m, flag });
        }
        let span_n = span(&force_n);
        if span_n < 1e-9 {
            return Err(IdentifyError::NoForce { recording: recording(), span_n });
        }
        let velocity_m_per_s = slope(&position_m, half(VELOCITY_HALF_S, interval_s), interval_s);
        Ok(Self { name: recording(), interval_s, position_m, force_n, input, velocity_m_per_s, unfinished: None })
    }

    /// Returns the number of samples, at least 200.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a recording is never empty")]
    pub fn len(&self) -> usize {
        self.position_m.len()
    }

    /// Returns the part of the recording before a sample.
    pub(super) fn before(&self, end: usize) -> Self {
        let cut = |values: &[f64]| values[..end].to_vec();
        let position_m = cut(&self.position_m);
        Self {
            name: self.name.clone(),
            interval_s: self.interval_s,
            velocity_m_per_s: slope(&position_m, half(VELOCITY_HALF_S, self.interval_s), self.interval_s),
            position_m,
            force_n: cut(&self.force_n),
            input: self.input.as_deref().map(cut),
            unfinished: None,
        }
    }

    /// Returns the 2-norm of the deviation of the predicted signal from its mean; above 0 for a part that is
    /// identified.
    pub(super) fn variation(&self, part: Part) -> f64 {
        deviation(self.predicted(part)).max(1e-12)
    }

    /// Returns the signal that a model of the part predicts: the position of a master, the force of the others.
    pub(super) fn predicted(&self, part: Part) -> &[f64] {
        match part {
            Part::Tissue | Part::Arm => &self.force_n,
            Part::Master => &self.position_m,
        }
    }
}
