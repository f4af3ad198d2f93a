//! The stiffness of a scenario's tissue, from its parameters or else from a run.

use super::CheckError;
use crate::run::{RunError, observe};
use trocar_core::time::nearest_ticks;
use trocar_engine::engine::{Observer, Signals};
use trocar_engine::tissue::Springs;
use trocar_scenario::{OVERSHOOT, Scenario};
use trocar_stability::{LinearLoop, TissueRange, TissueSource};

/// Minimum advance for a slope.
const ADVANCE_M: f64 = 5e-5;

/// Excluded, because the force of the ruptured layer falls.
const RUPTURE_S: f64 = 0.1;

/// Runs the scenario for the tissue of a unit, and for one that stiffens with depth under a live hand: their parameters
/// do not determine the springs and dampers.
pub fn tissue_range(scenario: &Scenario) -> Result<TissueRange, RunError> {
    if let Some(range) = TissueRange::of_parameters(scenario) {
        return Ok(range);
    }
    let mut observer = SlopeObserver {
        contact_m: scenario.tissue.settings().and_then(|settings| settings.surface_m()).unwrap_or(scenario.contact_m),
        from: None,
        until: 0,
        rupture_ticks: nearest_ticks(RUPTURE_S, scenario.grid.tick_s()),
        largest_n_per_m: 0.0,
        deepest_m: 0.0,
    };
    observe(scenario, &mut observer)?;
    let depth_m = OVERSHOOT * observer.deepest_m;
    let model = scenario.tissue.settings().and_then(|settings| TissueRange::of_model(settings, Some(depth_m)));
    let of_slopes = || Springs::between((0.0, observer.largest_n_per_m), (0.0, 0.0));
    Ok(match model {
        Some(range) => TissueRange { source: TissueSource::ModelInRun, ..range },
        None => TissueRange { source: TissueSource::Run, springs: of_slopes() },
    })
}

pub fn linear_loop(scenario: &Scenario) -> Result<LinearLoop, CheckError> {
    Ok(LinearLoop::of(scenario, tissue_range(scenario)?)?)
}

struct SlopeObserver {
    contact_m: f64,
    /// Depth and force at the beginning of the present slope.
    from: Option<(f64, f64)>,
    /// First evaluated tick after a rupture.
    until: u64,
    rupture_ticks: u64,
    largest_n_per_m: f64,
    deepest_m: f64,
}

impl Observer<f64> for SlopeObserver {
    fn observe(&mut self, s: &Signals<f64>) {
        let (depth_m, force_n) = (s.slave_position_m - self.contact_m, s.tissue_force_n);
        self.deepest_m = self.deepest_m.max(depth_m);
        if s.ruptured {
            self.until = s.tick + self.rupture_ticks;
        }
        if s.slave_velocity_m_per_s <= 0.0 || depth_m <= 0.0 || s.tick < self.until {
            self.from = None;
            return;
        }
        let (from_m, from_n) = *self.from.get_or_insert((depth_m, force_n));
        if depth_m - from_m >= ADVANCE_M {
            self.largest_n_per_m = self.largest_n_per_m.max((force_n - from_n) / (depth_m - from_m));
            self.from = Some((depth_m, force_n));
        }
    }
}
