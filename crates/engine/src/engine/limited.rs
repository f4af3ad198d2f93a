use super::exact::combine;
use super::motor::Motor;
use super::{IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::plant::{
    ActuatorLimits, ArmParameters, MASTER_STATES, MasterParameters, MasterStep, PlantError, SLAVE_STATES,
    SlaveParameters, SlaveStep,
};
use trocar_core::lane::Lane;

const MOTIONS: usize = MASTER_STATES - 1;
/// The motions, `x_d` now and next, `U_m`, and a zero column for an even number.
const MASTER_COLUMNS: usize = MOTIONS + 4;
const SLAVE_COLUMNS: usize = SLAVE_STATES + 1;

/// With held commands the machines are linear between ticks:
///
/// ```text
/// W_m = F_ed + K_i I,                     C_m = the last C_m, moved towards clip(W_m) by at most rate · T
/// W_s = K_p (x_ref - x_e) - K_v x_e',     C_s likewise
/// U(t) = C + (U_0 - C) exp(-t/τ) over the tick
/// I += T (F_ed - F_h) unless C_m differs from W_m and this would increase the difference
/// ```
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct LimitedPlants<L> {
    master: [[L; MOTIONS]; MASTER_COLUMNS],
    slave: [[L; SLAVE_STATES]; SLAVE_COLUMNS],
    hand_force: [L; MOTIONS],
    integral_gain: L,
    tick_s: L,
    control: [L; 3],
    master_motor: Motor<L, MOTIONS>,
    slave_motor: Motor<L, SLAVE_STATES>,
    motion: [L; MOTIONS],
    hand_force_n: L,
    integral: L,
    slave_state: [L; SLAVE_STATES],
}

impl<L: Lane> LimitedPlants<L> {
    pub fn new(
        (master, arm, slave): (&MasterParameters, &ArmParameters, &SlaveParameters),
        limits: &ActuatorLimits,
        tick_s: f64,
        master_m: f64,
        reference_m: f64,
    ) -> Result<Self, PlantError> {
        limits.validate()?;
        let step = MasterStep::of_machine(master, arm, tick_s)?;
        let master_motor = MasterStep::of_motor(master, arm, tick_s, limits.master_lag_s)?;
        let master_column = |j: usize| match j {
            0..MOTIONS => std::array::from_fn(|i| step.transition[i][j]),
            4 => step.desired_now,
            5 => step.desired_next,
            6 => master_motor.from_command,
            _ => [0.0; MASTER_STATES],
        };
        let slave_step = SlaveStep::of_machine(slave, tick_s)?;
        let slave_motor = SlaveStep::of_motor(slave, tick_s, limits.slave_lag_s)?;
        let slave_column = |j: usize| match j {
            SLAVE_STATES => slave_motor.from_command,
            _ => std::array::from_fn(|i| slave_step.transition[i][j]),
        };
        let slave_rest = slave_step.rest.map(|share| share * reference_m);
        let control = slave.control();
        let slave_command = control[0] * reference_m + control[1] * slave_rest[0];
        let master_bounds = (limits.max_master_force_n(), limits.max_master_change_n(tick_s));
        let slave_bounds = (limits.max_slave_command(), limits.max_slave_change(tick_s));
        Ok(Self {
            master: std::array::from_fn(|j| std::array::from_fn(|i| L::splat(master_column(j)[i]))),
            slave: std::array::from_fn(|j| slave_column(j).map(L::splat)),
            hand_force: std::array::from_fn(|i| L::splat(step.hand_force[i])),
            integral_gain: L::splat(master.force_integral_gain),
            tick_s: L::splat(tick_s),
            control: control.map(L::splat),
            master_motor: Motor::new(master_bounds, &master_motor, 0.0),
            slave_motor: Motor::new(slave_bounds, &slave_motor, slave_command),
            motion: [master_m, 0.0, master_m, 0.0].map(L::splat),
            hand_force_n: L::zero(),
            integral: L::zero(),
            slave_state: slave_rest.map(L::splat),
        })
    }
}

impl<L: Lane> Plants<L> for LimitedPlants<L> {
    #[inline(always)]
    fn master(&self) -> MasterOutput<L> {
        MasterOutput { position_m: self.motion[0], velocity_m_per_s: self.motion[1], hand_force_n: self.hand_force_n }
    }

    #[inline(always)]
    fn slave(&self) -> SlaveOutput<L> {
        SlaveOutput { position_m: self.slave_state[0], velocity_m_per_s: self.slave_state[1] }
    }

    #[inline(always)]
    fn step(
        &mut self,
        desired: L,
        desired_next: L,
        feedback: L,
        reference: L,
        deflection: L,
        _: TissueForce<L>,
    ) -> Result<(), IntegrationError> {
        let wanted_n = feedback + self.integral_gain * self.integral;
        let motor_n = self.master_motor.command(wanted_n);
        let error_n = feedback - self.hand_force_n;
        let excess_n = wanted_n - motor_n;
        let winds_up = (excess_n * error_n).gt(L::zero());
        self.integral = L::select(winds_up, self.integral, self.integral + self.tick_s * error_n);

        let [x_h, v_h, x_a, v_a] = self.motion;
        let motion = combine(&self.master, [x_h, v_h, x_a, v_a, desired, desired_next, motor_n, L::zero()]);
        let motion = self.master_motor.follow(motion);
        self.motion = motion;
        self.hand_force_n = (self.hand_force[0] * motion[0] + self.hand_force[2] * motion[2])
            + (self.hand_force[1] * motion[1] + self.hand_force[3] * motion[3]);

        let [x_e, v_e, third] = self.slave_state;
        let [to_reference, to_position, to_velocity] = self.control;
        let wanted = to_reference * (reference - deflection) + to_position * x_e + to_velocity * v_e;
        let command = self.slave_motor.command(wanted);
        self.slave_state = self.slave_motor.follow(combine(&self.slave, [x_e, v_e, third, command]));
        Ok(())
    }
}
