use std::ops::Range;
use std::sync::Arc;

use super::error::ScenarioError;
use super::intervals::intervals;
use super::values::Values;
use trocar_core::time::TickGrid;
use trocar_engine::teleoperation::{PassivitySettings, Scheme};

trocar_core::settings! {
    /// The clutch of the master.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct ClutchSettings in "operator." no const {
        /// Start and end times of intervals in which the clutch is open and the master moves alone, for example
        /// [2.0, 2.5]. The slave keeps its reference, the master feels no force, and their distance stays afterwards.
        clutch_s: Vec<f64> = [],
    }
}

const CLUTCH: &str = ClutchSettings::KEYS[0].path;

pub(super) fn clutch(values: &mut Values, grid: &TickGrid) -> Result<Arc<[Range<u64>]>, ScenarioError> {
    let times_s = ClutchSettings::read(values)?.clutch_s;
    let open = intervals(values, (CLUTCH, "opening"), &times_s, grid.tick_s())?;
    let scheme = PassivitySettings::read(values)?.scheme;
    if scheme != Scheme::None && !open.is_empty() {
        let message =
            format!("{CLUTCH} moves the master without the slave, which {} does not allow for", scheme.word());
        return Err(values.error(CLUTCH, message).remedy("remove it, or use passivity.scheme = \"none\""));
    }
    Ok(open)
}
