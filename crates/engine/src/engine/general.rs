use super::integrated_slave::IntegratedSlave;
use super::{
    ControlledMaster, ExactPlants, IntegratedPlants, IntegrationError, LimitedPlants, MasterOutput, Plants,
    SlaveOutput, TissueForce,
};
use crate::plant::{
    ActuatorLimits, MachineColumn, MachineStep, PlantError, Rest, SampledController, SampledGains, SlaveParameters,
};

#[derive(Debug, Clone)]
pub enum MasterPlants {
    Exact(Box<ExactPlants<f64>>),
    Limited(Box<LimitedPlants<f64>>),
    Integrated(Box<IntegratedPlants>),
    General(Box<ControlledMaster>),
}

#[derive(Debug, Clone)]
pub enum SlaveMachine {
    Exact(Box<MachineStep>, MachineColumn),
    Integrated(Box<IntegratedSlave>),
}

#[derive(Debug, Clone)]
pub struct GeneralSlave {
    machine: SlaveMachine,
    controller: SampledController,
}

impl GeneralSlave {
    pub fn exact(
        slave: &SlaveParameters,
        limits: &ActuatorLimits,
        tick_s: f64,
        reference_m: f64,
    ) -> Result<Self, PlantError> {
        let rest = Rest::of(slave, reference_m)?;
        let machine = SlaveMachine::Exact(Box::new(MachineStep::new(slave, tick_s)?), rest.state);
        Ok(Self { machine, controller: controller(slave, limits, tick_s, &rest, reference_m) })
    }

    pub fn integrated(
        slave: &SlaveParameters,
        limits: &ActuatorLimits,
        tick_s: f64,
        reference_m: f64,
    ) -> Result<Self, PlantError> {
        let rest = Rest::of(slave, reference_m)?;
        let machine = IntegratedSlave::new(slave, tick_s, (rest.state[0], rest.command))?;
        let machine = SlaveMachine::Integrated(Box::new(machine));
        Ok(Self { machine, controller: controller(slave, limits, tick_s, &rest, reference_m) })
    }

    pub fn output(&self) -> [f64; 2] {
        match &self.machine {
            SlaveMachine::Exact(_, state) => [state[0], state[1]],
            SlaveMachine::Integrated(machine) => machine.output(),
        }
    }

    pub fn step(&mut self, reference_m: f64, force: TissueForce<f64>) -> Result<(), IntegrationError> {
        let motion = self.output();
        let command = self.controller.command(reference_m - motion[0], motion, force.measured_n);
        // The tissue's force is positive when it resists insertion.
        let external_n = -force.on_needle_n;
        match &mut self.machine {
            SlaveMachine::Exact(step, state) => *state = step.advance(state, command, external_n),
            SlaveMachine::Integrated(machine) => machine.advance(command, external_n)?,
        }
        Ok(())
    }
}

fn controller(
    slave: &SlaveParameters,
    limits: &ActuatorLimits,
    tick_s: f64,
    rest: &Rest,
    reference_m: f64,
) -> SampledController {
    let bounds = (limits.max_slave_command(), limits.max_slave_change(tick_s));
    let position_m = rest.state[0];
    SampledController::at_rest(
        SampledGains::of(slave, tick_s),
        bounds,
        reference_m - position_m,
        position_m,
        rest.command,
    )
}

#[derive(Debug, Clone)]
pub struct GeneralPlants {
    master: MasterPlants,
    slave: GeneralSlave,
}

impl GeneralPlants {
    pub fn new(master: MasterPlants, slave: GeneralSlave) -> Self {
        Self { master, slave }
    }
}

impl Plants<f64> for GeneralPlants {
    fn master(&self) -> MasterOutput<f64> {
        match &self.master {
            MasterPlants::Exact(plants) => plants.master(),
            MasterPlants::Limited(plants) => plants.master(),
            MasterPlants::Integrated(plants) => plants.master(),
            MasterPlants::General(master) => master.output(),
        }
    }

    fn slave(&self) -> SlaveOutput<f64> {
        let [position_m, velocity_m_per_s] = self.slave.output();
        SlaveOutput { position_m, velocity_m_per_s }
    }

    fn step(
        &mut self,
        desired: f64,
        desired_next: f64,
        feedback: f64,
        reference: f64,
        deflection: f64,
        force: TissueForce<f64>,
    ) -> Result<(), IntegrationError> {
        let none = TissueForce::zero();
        match &mut self.master {
            MasterPlants::Exact(plants) => plants.step(desired, desired_next, feedback, 0.0, 0.0, none)?,
            MasterPlants::Limited(plants) => plants.step(desired, desired_next, feedback, 0.0, 0.0, none)?,
            MasterPlants::Integrated(plants) => plants.step(desired, desired_next, feedback, 0.0, 0.0, none)?,
            MasterPlants::General(master) => master.step([desired, desired_next], feedback)?,
        }
        self.slave.step(reference - deflection, force)
    }
}
