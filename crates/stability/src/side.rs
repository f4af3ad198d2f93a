use nalgebra::{DMatrix, DVector};

use super::machines::Machines;
use super::{LinearLoop, StabilityError};
use trocar_engine::plant::{ArmedColumn, ArmedStep, MachineColumn, MachineStep, SLAVE_STATES, SampledGains};
use trocar_engine::tissue::Relaxation;

/// `x_{k+1} = A x_k + b_now w_k + b_before w_{k-1}`, `y_k = c x_k`: receives `w` and sends `y` at the tick.
///
/// The sent signals are summed. `b_before` is nonzero if a sample arrives within a tick.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Side {
    pub(super) a: DMatrix<f64>,
    pub(super) now: DVector<f64>,
    pub(super) before: Option<DVector<f64>>,
    pub(super) c: DVector<f64>,
    /// The side's part of its command (`F_ed` at the master, the reference at the slave); `a` contains it.
    pub(super) local: DVector<f64>,
    /// Scaled to the master, in N.
    pub(super) force: DVector<f64>,
    /// At this tick and the next; `None` for the slave.
    pub(super) desired: Option<(DVector<f64>, DVector<f64>)>,
    pub(super) external: External,
}

/// On the next states, and on `c`, `local` and `force` of a [`Side`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct External {
    pub(super) next: DVector<f64>,
    pub(super) sent: f64,
    pub(super) local: f64,
    pub(super) measured: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LocalCommand {
    Closed,
    /// A supervisor determines the whole command.
    Open,
}

struct States {
    a: DMatrix<f64>,
    used: usize,
}

impl States {
    fn new(max: usize) -> Self {
        Self { a: DMatrix::zeros(max, max), used: 0 }
    }

    fn add(&mut self, count: usize) -> usize {
        self.used += count;
        self.used - count
    }

    fn set(&mut self, to: usize, weights: &DVector<f64>) {
        for (j, &weight) in weights.iter().enumerate() {
            self.a[(to, j)] = weight;
        }
    }
}

/// Ten of the machine with the arm, two of motor or controller, two of acceleration or force reading, one of
/// relaxation, and [`EXTERNAL`] or the last sample.
pub(super) const MAX_STATES: usize = 16;

const EXTERNAL: usize = MAX_STATES - 1;

fn zero() -> DVector<f64> {
    DVector::zeros(MAX_STATES)
}

fn unit(state: usize) -> DVector<f64> {
    DVector::from_fn(MAX_STATES, |i, _| f64::from(u8::from(i == state)))
}

fn first(column: &[f64]) -> DVector<f64> {
    let mut all = zero();
    all.rows_mut(0, column.len()).copy_from_slice(column);
    all
}

fn of_master(
    settings: &LinearLoop,
    [position, velocity, hand]: [&DVector<f64>; 3],
) -> Result<[DVector<f64>; 2], StabilityError> {
    let link = &settings.link;
    let (at_master, at_slave) = link.controller.gains(&link.machines)?;
    let scale = link.machines.position_scale;
    let local =
        position * (at_master.position * scale) + velocity * (at_master.velocity * scale) - hand * at_master.hand;
    let sent = position * scale + velocity * at_slave.velocity + hand * at_slave.hand_force;
    Ok([local, sent])
}

/// `a_k = a_{k-1} + w ((v_k - v_{k-1}) / T - a_{k-1})`.
fn acceleration(states: &mut States, velocity: &DVector<f64>, settings: &LinearLoop) -> DVector<f64> {
    let bandwidth_hz = settings.link.controller.four_channel.acceleration_bandwidth_hz;
    let weight = -libm::expm1(-std::f64::consts::TAU * bandwidth_hz * settings.tick_s);
    let at = states.add(2);
    let now = unit(at + 1) * (1.0 - weight) + (velocity - unit(at)) * (weight / settings.tick_s);
    states.set(at, velocity);
    states.set(at + 1, &now);
    now
}

/// A spring that relaxes adds the state `s`; with `e = exp(-T/τ)`, `c = (1 - e) τ/T`, the relaxed share `ρ` and
/// deflections that are linear within a tick:
///
/// ```text
/// f = K ((ρ + (1 - ρ) c) x - (1 - ρ) s) + B v,   s ← e s + c (1 - e) x
/// ```
fn tissue(states: &mut States, settings: &LinearLoop) -> DVector<f64> {
    let (position, damping) = (unit(0), unit(1) * settings.damping_n_s_per_m);
    let Some(Relaxation { relaxed_share, time_s }) = settings.relaxation else {
        return position * settings.stiffness_n_per_m + damping;
    };
    let ratio = settings.tick_s / time_s;
    let (keep, ramp_share) = (libm::exp(-ratio), -libm::expm1(-ratio) / ratio);
    let at = states.add(1);
    states.set(at, &(unit(at) * keep + &position * (ramp_share * (1.0 - keep))));
    let deflection = position * (relaxed_share + (1.0 - relaxed_share) * ramp_share) - unit(at) * (1.0 - relaxed_share);
    deflection * settings.stiffness_n_per_m + damping
}

/// With a bandwidth: `y_k = a y_{k-1} + b_0 f_{k-1} + b_1 f_k`.
fn measurement(states: &mut States, force: &DVector<f64>, settings: &LinearLoop) -> DVector<f64> {
    let ticks = std::f64::consts::TAU * settings.force_bandwidth_hz * settings.tick_s;
    if settings.force_bandwidth_hz <= 0.0 {
        return force.clone();
    }
    let keep = libm::exp(-ticks);
    let mean = if ticks > f64::MIN_POSITIVE { -libm::expm1(-ticks) / ticks } else { 1.0 };
    let at = states.add(2);
    let now = unit(at) * keep + unit(at + 1) * (mean - keep) + force * (1.0 - mean);
    states.set(at, &now);
    states.set(at + 1, force);
    now
}

fn motion_of_appendix(states: &mut States, machines: &Machines, settings: &LinearLoop) -> DVector<f64> {
    let step = &machines.slave;
    states.add(SLAVE_STATES);
    for (i, row) in step.transition.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            states.a[(i, j)] = value;
        }
    }
    match &machines.motors {
        None => first(&step.reference),
        Some((_, motor)) => {
            let mut command = first(&motor.from_command);
            let lagging = (settings.actuators.slave_lag_s > 0.0).then(|| states.add(1));
            if let Some(at) = lagging {
                states.a.set_column(at, &first(&motor.from_actual));
                states.a[(at, at)] = motor.kept;
                command[at] = motor.gained;
            }
            let [to_reference, to_position, to_velocity] = settings.slave.control();
            states.a += &command * (unit(0) * to_position + unit(1) * to_velocity).transpose();
            command * to_reference
        }
    }
}

/// Ignores Coulomb friction.
fn motion_of_general(
    states: &mut States,
    (step, gains): (&MachineStep, &SampledGains),
    [force, read, deflection]: [&DVector<f64>; 3],
) -> DVector<f64> {
    let place = |column: &MachineColumn| first(&column[..step.states]);
    for (j, column) in step.transition[..step.states].iter().enumerate() {
        for (i, &value) in column[..step.states].iter().enumerate() {
            states.a[(i, j)] = value;
        }
    }
    if step.is_loaded {
        states.a -= place(&step.external) * force.transpose();
    }
    let error = -unit(0) - deflection;
    let mut command =
        &error * (gains.proportional + gains.difference) - unit(1) * gains.velocity - unit(0) * gains.position
            + read * gains.force;
    let of_command = place(&step.command);
    let mut now = &of_command * (gains.proportional + gains.difference);
    if gains.difference != 0.0 {
        let last = states.add(1);
        command -= unit(last) * gains.difference;
        states.set(last, &error);
        now[last] = 1.0;
    }
    if gains.sum != 0.0 {
        let integral = states.add(1);
        command += unit(integral);
        states.set(integral, &(unit(integral) + error * gains.sum));
        now[integral] = gains.sum;
    }
    states.a += of_command * command.transpose();
    now
}

#[cfg(test)]
impl External {
    pub(super) fn none(n: usize) -> Self {
        Self { next: DVector::zeros(n), sent: 0.0, local: 0.0, measured: 0.0 }
    }
}

impl Side {
    /// `w` is the slave's part of `F_ed`, `y` the master's part of the slave's reference.
    pub(super) fn master(machines: &Machines, settings: &LinearLoop) -> Result<Self, StabilityError> {
        Self::master_with(machines, settings, LocalCommand::Closed)
    }

    pub(super) fn master_with(
        machines: &Machines,
        settings: &LinearLoop,
        local_command: LocalCommand,
    ) -> Result<Self, StabilityError> {
        if let Some(step) = &machines.general_master {
            return Self::general_master(step, settings, local_command);
        }
        let (_, at_slave) = settings.link.controller.gains(&settings.link.machines)?;
        let step = &machines.master;
        let mut states = States::new(MAX_STATES);
        let motion = states.add(4);
        let integral_gain = settings.master.force_integral_gain;
        let integral = (integral_gain != 0.0).then(|| states.add(1));
        let place = |column: &[f64]| -> DVector<f64> {
            let mut all = zero();
            for (i, &value) in column.iter().enumerate() {
                match integral {
                    Some(at) if i == 4 => all[at] = value,
                    None if i == 4 => {}
                    _ => all[motion + i] = value,
                }
            }
            all
        };
        let (position, velocity, hand) = (unit(motion), unit(motion + 1), place(&step.hand_force));
        let [local, mut sent] = of_master(settings, [&position, &velocity, &hand])?;
        for j in 0..5 {
            let column: Vec<f64> = step.transition.iter().map(|row| row[j]).collect();
            let to = match (j, integral) {
                (4, None) => continue,
                (4, Some(at)) => at,
                _ => motion + j,
            };
            states.a.set_column(to, &place(&column));
        }
        let now = match &machines.motors {
            None => place(&step.feedback),
            Some((motor, _)) => {
                let mut command = place(&motor.from_command);
                let lagging = (settings.actuators.master_lag_s > 0.0).then(|| states.add(1));
                if let Some(at) = lagging {
                    states.a.set_column(at, &place(&motor.from_actual));
                    states.a[(at, at)] = motor.kept;
                    command[at] = motor.gained;
                }
                let mut input = command.clone();
                if let Some(at) = integral {
                    for i in 0..MAX_STATES {
                        states.a[(i, at)] = if i == at { 1.0 } else { command[i] * integral_gain };
                    }
                    for j in 0..MAX_STATES {
                        states.a[(at, j)] -= settings.tick_s * hand[j];
                    }
                    input[at] = settings.tick_s;
                }
                input
            }
        };
        if local_command == LocalCommand::Closed {
            states.a += &now * local.transpose();
        }
        if at_slave.acceleration != 0.0 {
            sent += acceleration(&mut states, &velocity, settings) * at_slave.acceleration;
        }
        let split = machines.late_master.as_ref().map(|late| place(&late.feedback));
        let desired = (place(&step.desired_now), place(&step.desired_next));
        Ok(Self::of(states, now, split, [sent, local, zero()], Some(desired)))
    }

    /// Ignores Coulomb friction and the constant force.
    fn general_master(
        step: &ArmedStep,
        settings: &LinearLoop,
        local_command: LocalCommand,
    ) -> Result<Self, StabilityError> {
        let place = |column: &ArmedColumn| first(&column[..step.states]);
        let mut states = States::new(MAX_STATES);
        states.add(step.states);
        for (j, column) in step.transition[..step.states].iter().enumerate() {
            states.a.set_column(j, &place(column));
        }
        let (position, velocity, hand) = (unit(0), unit(1), place(&step.hand_force));
        // The motor resists: its force in the direction of insertion is -U_m.
        let command = -place(&step.motor);
        let mut now = command.clone();
        let gain = settings.master.force_integral_gain;
        if gain != 0.0 {
            let integral = states.add(1);
            states.a += &command * (unit(integral) * gain).transpose();
            states.set(integral, &(unit(integral) - &hand * settings.tick_s));
            now[integral] = settings.tick_s;
        }
        let [local, sent] = of_master(settings, [&position, &velocity, &hand])?;
        if local_command == LocalCommand::Closed {
            states.a += &now * local.transpose();
        }
        let desired = (place(&step.desired_now), place(&step.desired_next));
        Ok(Self::of(states, now, None, [sent, local, zero()], Some(desired)))
    }

    /// `w` is the received part of the reference, `y` the sent part of `F_ed`.
    pub(super) fn slave(machines: &Machines, settings: &LinearLoop) -> Result<Self, StabilityError> {
        Self::slave_with(machines, settings, LocalCommand::Closed)
    }

    pub(super) fn slave_with(
        machines: &Machines,
        settings: &LinearLoop,
        local_command: LocalCommand,
    ) -> Result<Self, StabilityError> {
        let link = &settings.link;
        let (at_master, at_slave) = link.controller.gains(&link.machines)?;
        let mut states = States::new(MAX_STATES);
        let (position, velocity) = (unit(0), unit(1));
        let reading = |states: &mut States| {
            let spring_and_damper = tissue(states, settings);
            let force = &spring_and_damper + unit(EXTERNAL);
            let read = if settings.adds_to_reading() {
                measurement(states, &spring_and_damper, settings) + unit(EXTERNAL)
            } else {
                measurement(states, &force, settings)
            };
            let local = &read * -at_slave.local_force;
            let mut deflection = &force * link.machines.compliance_m_per_n;
            if local_command == LocalCommand::Closed {
                deflection -= &local;
            }
            (force, read, local, deflection)
        };
        let (read, local, now) = match &machines.general {
            None => {
                let now = motion_of_appendix(&mut states, machines, settings);
                let (_, read, local, deflection) = reading(&mut states);
                states.a -= &now * deflection.transpose();
                (read, local, now)
            }
            Some((step, gains)) => {
                states.add(step.states);
                let (force, read, local, deflection) = reading(&mut states);
                let now = motion_of_general(&mut states, (step, gains), [&force, &read, &deflection]);
                (read, local, now)
            }
        };
        let mut sent = &read * (at_master.force * link.machines.force_scale)
            - &position * at_master.position
            - &velocity * (at_master.velocity + at_master.drag);
        if at_master.inertia != 0.0 {
            sent -= acceleration(&mut states, &velocity, settings) * at_master.inertia;
        }
        let split = machines.late_slave.as_ref().map(|late| first(&late.reference));
        let measured = read * link.machines.force_scale;
        Ok(Self::of(states, now, split, [sent, local, measured], None))
    }

    /// The last sample becomes a state.
    pub(super) fn with_held(&self) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let states = self.a.nrows();
        let n = states + usize::from(self.before.is_some());
        let mut a = self.a.clone().resize(n, n, 0.0);
        let mut b = self.now.clone().resize_vertically(n, 0.0);
        if let Some(before) = &self.before {
            a.view_mut((0, states), (states, 1)).copy_from(before);
            b[states] = 1.0;
        }
        (a, b, self.c.clone().resize_vertically(n, 0.0))
    }

    /// In a split tick the last sample acts first: `Γ(T) w_{k-1} + Γ_late (w_k - w_{k-1})`.
    fn of(
        states: States,
        whole: DVector<f64>,
        late: Option<DVector<f64>>,
        [sent, local, force]: [DVector<f64>; 3],
        desired: Option<(DVector<f64>, DVector<f64>)>,
    ) -> Self {
        let n = states.used;
        let cut = |vector: DVector<f64>| vector.rows(0, n).into_owned();
        let external = External {
            next: states.a.column(EXTERNAL).rows(0, n).into_owned(),
            sent: sent[EXTERNAL],
            local: local[EXTERNAL],
            measured: force[EXTERNAL],
        };
        let (now, before) = match late {
            None => (whole, None),
            Some(late) => (late.clone(), Some(whole - late)),
        };
        Self {
            a: states.a.view((0, 0), (n, n)).into_owned(),
            now: cut(now),
            before: before.map(cut),
            c: cut(sent),
            local: cut(local),
            force: cut(force),
            desired: desired.map(|(now, next)| (cut(now), cut(next))),
            external,
        }
    }
}
