use super::integrated_master::IntegratedMaster;
use super::{IntegrationError, MasterOutput};
use crate::plant::{ActuatorLimits, ArmedColumn, ArmedRest, ArmedStep, GeneralMaster, PlantError};

#[derive(Debug, Clone)]
enum Machine {
    Exact(Box<ArmedStep>, ArmedColumn),
    Integrated(Box<IntegratedMaster>),
}

/// ```text
/// U_k = F_ed + K_i I_k, limited in range and in change per tick
/// I_{k+1} = I_k + T (F_ed - F_h) unless this would increase what a limit cuts off
/// ```
#[derive(Debug, Clone)]
pub struct ControlledMaster {
    machine: Machine,
    integral_gain: f64,
    tick_s: f64,
    bounds: (f64, f64),
    integral: f64,
    motor_n: f64,
}

impl ControlledMaster {
    pub fn exact(
        master: &GeneralMaster<'_>,
        limits: &ActuatorLimits,
        tick_s: f64,
        desired_m: f64,
    ) -> Result<Self, PlantError> {
        let rest = ArmedRest::of(master, desired_m)?;
        let machine = Machine::Exact(Box::new(ArmedStep::new(master, tick_s)?), rest.state);
        Ok(Self::with(machine, master, limits, tick_s, &rest))
    }

    pub fn integrated(
        master: &GeneralMaster<'_>,
        limits: &ActuatorLimits,
        tick_s: f64,
        desired_m: f64,
    ) -> Result<Self, PlantError> {
        let rest = ArmedRest::of(master, desired_m)?;
        let n = master.machine()?.system().states();
        let machine = IntegratedMaster::new(master, tick_s, [rest.state[0], rest.state[n], rest.motor_n], desired_m)?;
        Ok(Self::with(Machine::Integrated(Box::new(machine)), master, limits, tick_s, &rest))
    }

    fn with(
        machine: Machine,
        master: &GeneralMaster<'_>,
        limits: &ActuatorLimits,
        tick_s: f64,
        rest: &ArmedRest,
    ) -> Self {
        let integral_gain = master.parameters.force_integral_gain;
        // The force in the direction of insertion is -U_m.
        let motor_n = -rest.motor_n;
        let bounds = (limits.max_master_force_n(), limits.max_master_change_n(tick_s));
        Self {
            machine,
            integral_gain,
            tick_s,
            bounds,
            integral: if integral_gain > 0.0 { motor_n / integral_gain } else { 0.0 },
            motor_n: motor_n.clamp(-bounds.0, bounds.0),
        }
    }

    pub fn output(&self) -> MasterOutput<f64> {
        match &self.machine {
            Machine::Exact(step, state) => MasterOutput {
                position_m: state[0],
                velocity_m_per_s: state[1],
                hand_force_n: step.hand_force_n(state),
            },
            Machine::Integrated(machine) => machine.output(),
        }
    }

    pub fn step(&mut self, desired_m: [f64; 2], feedback_n: f64) -> Result<(), IntegrationError> {
        let wanted_n = feedback_n + self.integral_gain * self.integral;
        let (range, change) = self.bounds;
        // Unlike `clamp`, they accept NaN.
        let within = wanted_n.max(-range).min(range);
        let limited = within.max(self.motor_n - change).min(self.motor_n + change);
        self.motor_n = if wanted_n.is_nan() { wanted_n } else { limited };
        let error_n = feedback_n - self.output().hand_force_n;
        let winds_up = (wanted_n - self.motor_n) * error_n > 0.0;
        if !winds_up {
            self.integral += self.tick_s * error_n;
        }
        match &mut self.machine {
            Machine::Exact(step, state) => *state = step.advance(state, desired_m, -self.motor_n),
            Machine::Integrated(machine) => machine.advance(desired_m, -self.motor_n)?,
        }
        Ok(())
    }
}
