//! Dormand-Prince 8(5,3) as an independent check of the exact step: the equations use the paper's letters and no code
//! of `lti`.

use nalgebra::SVector;

use super::integrator::integrate;
use super::{Differential, IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, Coupling, Damping, MasterParameters, SlaveParameters,
};

/// `x_h, v_h, x_a, v_a, ∫(F_ed - F_h)`, the slave in observer form `z_1 = x_e, z_2, z_3`, and `x_d`.
type State = SVector<f64, 9>;

type LaggedState = SVector<f64, 11>;

#[derive(Debug, Clone)]
struct Equations {
    master: MasterParameters,
    arm: ArmParameters,
    timing: ControlTiming,
    /// `x_e''' + a[2] x_e'' + a[1] x_e' + a[0] x_e = b[1] u' + b[0] u`
    a: [f64; 3],
    b: [f64; 2],
    proportional_gain: f64,
    velocity_gain: f64,
    damping: Damping,
    limits: ActuatorLimits,
    desired_velocity: f64,
    feedback: f64,
    reference: f64,
    motor: f64,
    held_slave_control: f64,
}

/// The two extra states would affect the integrator's step size without a lag.
struct Lagged<'a>(&'a Equations);

impl Equations {
    fn hand_force(&self, s: &State) -> f64 {
        self.arm.k_a_n_per_m * (s[2] - s[0]) + self.arm.b_a_n_s_per_m * (s[3] - s[1])
    }

    fn motor(&self, s: &State) -> f64 {
        self.feedback + self.master.force_integral_gain * s[4]
    }

    fn slave_velocity(&self, s: &State) -> f64 {
        s[6] - self.a[2] * s[5]
    }

    fn slave_control(&self, s: &State) -> f64 {
        let damped = match self.damping {
            Damping::Velocity => self.slave_velocity(s),
            Damping::AsPrinted => s[5],
        };
        self.proportional_gain * (self.reference - s[5]) - self.velocity_gain * damped
    }

    fn derivatives(&self, s: &State, motor: f64, control: f64, derivative: &mut State) {
        let hand_force = self.hand_force(s);
        let desired = s[8];
        let push = match self.master.coupling {
            Coupling::Physical => hand_force - motor,
            Coupling::AsPrinted => motor,
        };
        let arm = &self.arm;
        derivative[0] = s[1];
        derivative[1] = (push - self.master.damping_n_s_per_m * s[1]) / self.master.mass_kg;
        derivative[2] = s[3];
        derivative[3] = (arm.k_h_n_per_m * (desired - s[2]) + arm.b_h_n_s_per_m * (self.desired_velocity - s[3])
            - hand_force)
            / arm.m_h_kg;
        derivative[4] = match self.timing {
            ControlTiming::Continuous => self.feedback - hand_force,
            ControlTiming::Sampled => 0.0,
        };
        derivative[5] = self.slave_velocity(s);
        derivative[6] = s[7] - self.a[1] * s[5] + self.b[1] * control;
        derivative[7] = self.b[0] * control - self.a[0] * s[5];
        derivative[8] = self.desired_velocity;
    }
}

impl Differential<State> for &Equations {
    fn system(&self, s: &State, derivative: &mut State) {
        let (motor, control) = match self.timing {
            ControlTiming::Continuous => (self.motor(s), self.slave_control(s)),
            ControlTiming::Sampled => (self.motor, self.held_slave_control),
        };
        self.derivatives(s, motor, control, derivative);
    }
}

impl Differential<LaggedState> for Lagged<'_> {
    fn system(&self, s: &LaggedState, derivative: &mut LaggedState) {
        let Self(equations) = self;
        let lags = [equations.limits.master_lag_s, equations.limits.slave_lag_s];
        let held = [equations.motor, equations.held_slave_control];
        let mut acting = held;
        for side in 0..2 {
            derivative[9 + side] = 0.0;
            if lags[side] > 0.0 {
                acting[side] = s[9 + side];
                derivative[9 + side] = (held[side] - s[9 + side]) / lags[side];
            }
        }
        let mut machines = State::zeros();
        equations.derivatives(&s.fixed_rows::<9>(0).into_owned(), acting[0], acting[1], &mut machines);
        derivative.fixed_rows_mut::<9>(0).copy_from(&machines);
    }
}

#[derive(Debug, Clone)]
pub struct IntegratedPlants {
    equations: Equations,
    tick_s: f64,
    state: State,
    actual: [f64; 2],
    arrivals: [f64; 2],
    /// Without the deflection of the slave.
    received: f64,
}

impl IntegratedPlants {
    pub fn new(
        (master, arm, slave): (&MasterParameters, &ArmParameters, &SlaveParameters),
        timing: ControlTiming,
        tick_s: f64,
        master_m: f64,
        reference_m: f64,
    ) -> Self {
        let (a, b) = third_order(&slave.numerator, &slave.denominator);
        let stiffness = match slave.damping {
            Damping::Velocity => slave.proportional_gain,
            Damping::AsPrinted => slave.proportional_gain + slave.velocity_gain,
        };
        let (held, pushed) = (slave.denominator.last().unwrap_or(&0.0), slave.numerator.last().unwrap_or(&0.0));
        let load = held + pushed * stiffness;
        let gain = if load == 0.0 { 1.0 } else { pushed * slave.proportional_gain / load };
        let position = gain * reference_m;
        let control = slave.proportional_gain * reference_m - stiffness * position;
        let mut state = State::zeros();
        (state[0], state[2]) = (master_m, master_m);
        (state[5], state[6], state[7]) = (position, a[2] * position, a[1] * position - b[1] * control);
        let equations = Equations {
            master: *master,
            arm: *arm,
            timing,
            a,
            b,
            proportional_gain: slave.proportional_gain,
            velocity_gain: slave.velocity_gain,
            damping: slave.damping,
            limits: ActuatorLimits::NONE,
            desired_velocity: 0.0,
            feedback: 0.0,
            reference: reference_m,
            motor: 0.0,
            held_slave_control: control,
        };
        Self { equations, tick_s, state, actual: [0.0; 2], arrivals: [0.0; 2], received: reference_m }
    }

    /// As fractions of each tick; continuous control only.
    pub fn split(mut self, feedback_share: f64, reference_share: f64) -> Self {
        self.arrivals = [feedback_share, reference_share];
        self
    }

    fn integrate(&mut self, duration_s: f64) -> Result<(), IntegrationError> {
        let ActuatorLimits { master_lag_s, slave_lag_s, .. } = self.equations.limits;
        if self.equations.timing == ControlTiming::Sampled && (master_lag_s > 0.0 || slave_lag_s > 0.0) {
            return self.integrate_lagged(duration_s);
        }
        Ok(integrate(&self.equations, duration_s, &mut self.state)?)
    }

    fn integrate_lagged(&mut self, duration_s: f64) -> Result<(), IntegrationError> {
        let mut state = LaggedState::zeros();
        state.fixed_rows_mut::<9>(0).copy_from(&self.state);
        (state[9], state[10]) = (self.actual[0], self.actual[1]);
        integrate(Lagged(&self.equations), duration_s, &mut state)?;
        self.state = state.fixed_rows::<9>(0).into_owned();
        self.actual = [state[9], state[10]];
        Ok(())
    }

    pub fn limited(mut self, limits: &ActuatorLimits) -> Self {
        let equations = &mut self.equations;
        equations.limits = *limits;
        let limit = limits.max_slave_command();
        equations.held_slave_control = equations.held_slave_control.clamp(-limit, limit);
        self.actual = [equations.motor, equations.held_slave_control];
        self
    }
}

fn limited(wanted: f64, last: f64, range: f64, rate: Option<f64>, tick_s: f64) -> f64 {
    let within = wanted.clamp(-range, range);
    let Some(rate) = rate else { return within };
    let way = within - last;
    if way.abs() > rate * tick_s { last + rate * tick_s * way.signum() } else { within }
}

fn third_order(numerator: &[f64], denominator: &[f64]) -> ([f64; 3], [f64; 2]) {
    let trim = |c: &[f64]| c.iter().copied().skip_while(|&v| v == 0.0).collect::<Vec<f64>>();
    let (mut numerator, mut denominator) = (trim(numerator), trim(denominator));
    if denominator.len() == 3 {
        numerator.push(0.0);
        denominator.push(0.0);
    }
    let leading = denominator.first().copied().unwrap_or(1.0);
    let power = |c: &[f64], p: usize| c.iter().rev().nth(p).map_or(0.0, |v| v / leading);
    (std::array::from_fn(|p| power(&denominator, p)), std::array::from_fn(|p| power(&numerator, p)))
}

impl Plants<f64> for IntegratedPlants {
    fn master(&self) -> MasterOutput<f64> {
        MasterOutput {
            position_m: self.state[0],
            velocity_m_per_s: self.state[1],
            hand_force_n: self.equations.hand_force(&self.state),
        }
    }

    fn slave(&self) -> SlaveOutput<f64> {
        SlaveOutput { position_m: self.state[5], velocity_m_per_s: self.equations.slave_velocity(&self.state) }
    }

    fn step(
        &mut self,
        desired: f64,
        next: f64,
        feedback: f64,
        reference: f64,
        deflection: f64,
        _: TissueForce<f64>,
    ) -> Result<(), IntegrationError> {
        self.state[8] = desired;
        self.equations.desired_velocity = (next - desired) / self.tick_s;
        let [feedback_share, reference_share] = self.arrivals;
        self.equations.reference = self.received - deflection;
        let mut past = 0.0;
        for share in [feedback_share.min(reference_share), feedback_share.max(reference_share)] {
            if share > past {
                self.integrate((share - past) * self.tick_s)?;
                past = share;
            }
            if share >= feedback_share {
                self.equations.feedback = feedback;
            }
            if share >= reference_share {
                self.equations.reference = reference - deflection;
            }
        }
        self.received = reference;
        let equations = &mut self.equations;
        let limits = equations.limits;
        let wanted = equations.motor(&self.state);
        let (motor_range, motor_rate) = (limits.max_master_force_n(), limits.master_force_rate_n_per_s);
        equations.motor = limited(wanted, equations.motor, motor_range, motor_rate, self.tick_s);
        let (slave_range, slave_rate) = (limits.max_slave_command(), limits.slave_command_rate_per_s);
        let slave_wanted = equations.slave_control(&self.state);
        equations.held_slave_control =
            limited(slave_wanted, equations.held_slave_control, slave_range, slave_rate, self.tick_s);
        let error = feedback - equations.hand_force(&self.state);
        // While the motor is limited, the integral may only change towards the limited command.
        let winds_up = (wanted > equations.motor && error > 0.0) || (wanted < equations.motor && error < 0.0);
        let sampled_integral = if winds_up { self.state[4] } else { self.state[4] + self.tick_s * error };

        self.integrate((1.0 - past) * self.tick_s)?;
        if self.equations.timing == ControlTiming::Sampled {
            self.state[4] = sampled_integral;
        }
        Ok(())
    }
}
