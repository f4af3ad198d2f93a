//! The stability study of a scenario.

use std::sync::atomic::AtomicBool;

use super::{Check, CheckError, check};
use crate::scenario::Scenario;
use crate::stability::{Analysis, Axis, LoopSettings, StabilityError, StabilityMap, Switching, SwitchingSettings, map};

/// Maximum tissue stiffness of the switching analysis, in N/m.
pub const MAX_STIFFNESS_N_PER_M: f64 = 1e6;

/// A scenario's loop, its map over two parameters, its events, and the comparison with the engine.
#[derive(Debug, Clone)]
pub struct StabilityStudy {
    /// The scenario's name.
    pub name: String,
    /// The parts of the scenario that the linear loop does not model.
    pub unmodelled: Vec<&'static str>,
    /// The loop.
    pub analysis: Analysis,
    /// The map.
    pub map: StabilityMap,
    /// The switching analysis, or why there is none.
    pub switching: Result<Switching, &'static str>,
    /// The comparison of the map with the engine, if it was run.
    pub check: Option<Check>,
}

impl StabilityStudy {
    /// Analyses a scenario, its map over two axes, and its switching with any tissue stiffness (N/m) in the range
    /// `tissue`, which must satisfy [`is_tissue`]. Does not run the engine.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn of(scenario: &Scenario, (x, y): (Axis, Axis), tissue: (f64, f64)) -> Result<Self, StabilityError> {
        let settings = LoopSettings::of(scenario);
        let analysis = Analysis::of(&settings)?;
        let map = map(&settings, x, y)?;
        let switching = match SwitchingSettings::with_loop(scenario, settings, tissue) {
            Ok(settings) => Ok(Switching::of(&settings)?),
            Err(reason) => Err(reason),
        };
        let (name, unmodelled) = (scenario.name.clone(), LoopSettings::unmodelled(scenario));
        Ok(Self { name, unmodelled, analysis, map, switching, check: None })
    }

    /// Runs the engine at every point of the map; calls `done` after each run; runs not begun when `stop` is set are
    /// skipped.
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn simulate(
        &mut self,
        scenario: &Scenario,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<(), CheckError> {
        self.check = Some(check((scenario, &self.analysis.settings), &self.map, stop, done)?);
        Ok(())
    }
}

/// Whether the switching can be analysed for a tissue between these stiffnesses in N/m: ascending, from 0 to
/// [`MAX_STIFFNESS_N_PER_M`].
#[must_use]
pub fn is_tissue((low, high): (f64, f64)) -> bool {
    0.0 <= low && low <= high && high <= MAX_STIFFNESS_N_PER_M
}
