//! The stiffness of a scenario's tissue, from its parameters or else from a run.

use super::CheckError;
use crate::run::{RunError, observe};
use trocar_engine::engine::{Observer, Signals};
use trocar_scenario::{OVERSHOOT, Scenario};
use trocar_stability::{LinearLoop, TissueRange, TissueSource};

pub fn tissue_range(scenario: &Scenario) -> Result<TissueRange, RunError> {
    if let Some(range) = TissueRange::of_parameters(scenario) {
        return Ok(range);
    }
    let contact_m = scenario.tissue.settings().and_then(|settings| settings.surface_m()).unwrap_or(scenario.contact_m);
    let mut observer = DepthObserver { contact_m, deepest_m: 0.0 };
    observe(scenario, &mut observer)?;
    let depth_m = OVERSHOOT * observer.deepest_m;
    let model = scenario.tissue.settings().and_then(|settings| TissueRange::of_model(settings, Some(depth_m)));
    // The verdict is unknown for a tissue model that does not state its springs.
    let range = model.unwrap_or_else(|| TissueRange::spring(0.0, 0.0));
    Ok(TissueRange { source: TissueSource::ModelInRun, ..range })
}

pub fn linear_loop(scenario: &Scenario) -> Result<LinearLoop, CheckError> {
    Ok(LinearLoop::of(scenario, tissue_range(scenario)?)?)
}

struct DepthObserver {
    contact_m: f64,
    deepest_m: f64,
}

impl Observer<f64> for DepthObserver {
    fn observe(&mut self, s: &Signals<f64>) {
        self.deepest_m = self.deepest_m.max(s.slave_position_m - self.contact_m);
    }
}
