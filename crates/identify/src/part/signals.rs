use std::path::Path;

use trocar_base::warning::Warning;
use trocar_recording::{Column, Limits};

use super::Part;
use crate::IdentifyError;
use crate::filter::{half, slope};
use crate::grid::{Grid, check};
use crate::measured::{VELOCITY_HALF_S, deviation, span};

/// Factors convert to SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct PartColumns {
    pub time: Column,
    /// Position of the needle for a tissue, otherwise of the master.
    pub position: Column,
    /// Force on the needle, positive when it resists; otherwise of the hand, positive when it pushes the master
    /// forwards.
    pub force: Column,
    /// Desired position of an arm (m), or force of a master's motor (N), positive when it pushes forwards.
    pub input: Option<Column>,
}

/// Evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    pub name: String,
    pub interval_s: f64,
    pub position_m: Vec<f64>,
    pub force_n: Vec<f64>,
    /// Desired position in m, or force of the motor in N.
    pub input: Option<Vec<f64>>,
    pub(super) velocity_m_per_s: Vec<f64>,
    pub(super) unfinished: Option<Warning>,
}

impl Signals {
    /// Resamples unevenly spaced samples at their median interval.
    pub fn open(path: &Path, part: Part, columns: &PartColumns, limits: &Limits) -> Result<Self, IdentifyError> {
        let PartColumns { time, position, force, input } = columns;
        let Grid { name, interval_s, position_m, force_n, others, unfinished } =
            Grid::open(path, time, position, force, input.iter(), limits)?;
        let signals = Self::new(&name, part, interval_s, position_m, force_n, others.into_iter().next())?;
        Ok(Self { unfinished, ..signals })
    }

    /// Takes columns in SI units.
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
        // Smaller spans are rounding errors of double precision.
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

    #[expect(clippy::len_without_is_empty, reason = "a recording is never empty")]
    pub fn len(&self) -> usize {
        self.position_m.len()
    }

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

    /// 2-norm of the predicted signal's deviation from its mean; above 0.
    pub(super) fn variation(&self, part: Part) -> f64 {
        deviation(self.predicted(part)).max(1e-12)
    }

    /// The position of a master, the force of other parts.
    pub(super) fn predicted(&self, part: Part) -> &[f64] {
        match part {
            Part::Tissue | Part::Arm => &self.force_n,
            Part::Master => &self.position_m,
        }
    }
}
