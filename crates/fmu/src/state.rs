use super::instance::{Clock, Instance, InstanceError, Running};
use trocar_core::rig::HapticController;
use trocar_engine::tissue::AnyTissue;
use trocar_scenario::Scenario;
use trocar_studies::fmu::Scalar;
use trocar_studies::run::SteppedRun;

#[derive(Debug)]
pub struct SavedState {
    values: Vec<Scalar>,
    running: Saved,
    clock: Option<Clock>,
}

#[derive(Debug)]
enum Saved {
    Nothing,
    Rig(Box<HapticController>),
    /// The scenario, and the given position of the person by tick: they repeat the run bit for bit.
    Simulation(Box<Scenario>, Vec<f64>),
    Tissue(Box<AnyTissue<f64>>),
}

impl Instance {
    /// Only the same unit can restore the state.
    pub fn save(&self) -> SavedState {
        let running = match &self.running {
            Running::Nothing => Saved::Nothing,
            Running::Rig(controller) => Saved::Rig(controller.clone()),
            Running::Simulation(run) => Saved::Simulation(Box::new(run.scenario().clone()), run.led_m().to_vec()),
            Running::Tissue(tissue) => Saved::Tissue(tissue.clone()),
        };
        SavedState { values: self.values.clone(), running, clock: self.clock }
    }

    /// A whole simulation is repeated up to the state.
    pub fn restore(&mut self, state: &SavedState) -> Result<(), InstanceError> {
        self.running = match &state.running {
            Saved::Nothing => Running::Nothing,
            Saved::Rig(controller) => Running::Rig(controller.clone()),
            Saved::Simulation(scenario, led_m) => {
                Running::Simulation(Box::new(SteppedRun::repeated(Scenario::clone(scenario), led_m)?))
            }
            Saved::Tissue(tissue) => Running::Tissue(tissue.clone()),
        };
        self.values.clone_from(&state.values);
        self.clock = state.clock;
        Ok(())
    }
}
