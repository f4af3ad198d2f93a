//! Everything that is said of where a scenario is stable.

use std::sync::atomic::AtomicBool;

use super::{Check, CheckError, check};
use crate::scenario::Scenario;
use crate::stability::{Analysis, Axis, LoopSettings, StabilityError, StabilityMap, Switching, SwitchingSettings, map};

/// The stiffest tissue that events are looked at on, in N/m.
pub const MAX_STIFFNESS_N_PER_M: f64 = 1e6;

/// A scenario's loop, its map over two parameters, its events, and what the engine says of them.
#[derive(Debug, Clone)]
pub struct StabilityStudy {
    /// The scenario's name.
    pub name: String,
    /// What of the scenario is not in the linear loop.
    pub unmodelled: Vec<&'static str>,
    /// The loop.
    pub analysis: Analysis,
    /// The map.
    pub map: StabilityMap,
    /// The events, or why nothing is said of them.
    pub switching: Result<Switching, &'static str>,
    /// The engine's word on the map, where it was asked.
    pub check: Option<Check>,
}

impl StabilityStudy {
    /// Analyses a scenario, maps it over two axes, and lets events happen while the tissue's stiffness (N/m) is anything from
    /// the first to the second of `tissue`, which [`is_tissue`] allows. The engine is not asked.
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

    /// Asks the engine at every point of the map; `done` is told of each run, those not begun when `stop` is set are left out.
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

/// Whether events can be looked at on a tissue between these stiffnesses in N/m: ascending, from 0 to
/// [`MAX_STIFFNESS_N_PER_M`].
#[must_use]
pub fn is_tissue((low, high): (f64, f64)) -> bool {
    0.0 <= low && low <= high && high <= MAX_STIFFNESS_N_PER_M
}
