//! Motors that saturate: against numerical integration, against motors without a limit, and by what they may not do.

use trocar::engine::{ExactSides, IntegratedSides, LimitedSides, Sides};
use trocar::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, Coupling, Damping, MasterParameters, MasterStep, SlaveParameters,
    SlaveStep,
};

const TICK_S: f64 = 1e-3;
const TICKS: usize = 800;
const TIGHT: ActuatorLimits = ActuatorLimits { master_force_n: Some(1.2), slave_command: Some(0.4) };
const LOOSE: ActuatorLimits = ActuatorLimits { master_force_n: Some(1e6), slave_command: Some(1e6) };

/// `x_d, F_ed, x_ref`: forces to 3 N that change sign, and steps of the reference.
fn input(k: usize) -> (f64, f64, f64) {
    let t = k as f64 * TICK_S;
    (0.02 * t, 3.0 * (9.0 * t).sin(), if (k / 150).is_multiple_of(2) { 0.002 } else { -0.001 })
}

fn drive(mut sides: impl Sides<f64>, input: impl Fn(usize) -> (f64, f64, f64)) -> [Vec<f64>; 5] {
    let mut columns: [Vec<f64>; 5] = Default::default();
    for k in 0..TICKS {
        let (master, slave) = (sides.master(), sides.slave());
        let row =
            [master.position_m, master.velocity_m_per_s, master.hand_force_n, slave.position_m, slave.velocity_m_per_s];
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
        let (desired, feedback, reference) = input(k);
        sides.step(desired, input(k + 1).0, feedback, reference).expect("steps");
    }
    columns
}

fn difference(a: &[Vec<f64>; 5], b: &[Vec<f64>; 5]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn limited(limits: &ActuatorLimits, coupling: Coupling, damping: Damping) -> LimitedSides<f64> {
    let master = MasterParameters { coupling, ..MasterParameters::default() };
    let slave = SlaveParameters { damping, ..SlaveParameters::default() };
    LimitedSides::new((&master, &ArmParameters::default(), &slave), limits, TICK_S, 0.0, 0.0).expect("valid")
}

fn integrated(limits: &ActuatorLimits, damping: Damping) -> IntegratedSides {
    let slave = SlaveParameters { damping, ..SlaveParameters::default() };
    let machines = (&MasterParameters::default(), &ArmParameters::default(), &slave);
    IntegratedSides::new(machines, ControlTiming::Sampled, TICK_S, 0.0, 0.0).limited(limits)
}

fn unlimited(damping: Damping) -> ExactSides<f64> {
    let (timing, slave) = (ControlTiming::Sampled, SlaveParameters { damping, ..SlaveParameters::default() });
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&slave, timing, TICK_S);
    ExactSides::new(&master.expect("valid"), &slave.expect("valid"), 0.0, 0.0)
}

#[test]
fn saturated_steps_agree_with_numerical_integration() {
    for damping in [Damping::Velocity, Damping::AsPrinted] {
        let exact = drive(limited(&TIGHT, Coupling::Physical, damping), input);
        let integrated = drive(integrated(&TIGHT, damping), input);
        let error = difference(&exact, &integrated);
        assert!(error < 1e-8, "{damping:?}: {error:e}");
        let free = drive(unlimited(damping), input);
        assert!((0..5).all(|column| difference_of(&exact[column], &free[column]) > 1e-4), "the limits are reached");
    }
}

fn difference_of(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_limit_that_is_never_reached_changes_nothing() {
    for damping in [Damping::Velocity, Damping::AsPrinted] {
        let error =
            difference(&drive(limited(&LOOSE, Coupling::Physical, damping), input), &drive(unlimited(damping), input));
        assert!(error < 1e-12, "{damping:?}: {error:e}");
    }
}

/// `U_m` over a tick, told from the motion alone: the master's equation solved for it, to the tick's accuracy.
fn motor_forces(columns: &[Vec<f64>; 5]) -> Vec<f64> {
    let MasterParameters { mass_kg, damping_n_s_per_m, .. } = MasterParameters::default();
    let [x_h, v_h, f_h, ..] = columns;
    let at = |k: usize| {
        // Over a tick: m Δv + b Δx = ∫F_h - U_m T, the integral by the trapezium.
        let impulse = TICK_S * (f_h[k] + f_h[k + 1]) / 2.0;
        let momentum = mass_kg * (v_h[k + 1] - v_h[k]) + damping_n_s_per_m * (x_h[k + 1] - x_h[k]);
        (impulse - momentum) / TICK_S
    };
    (0..TICKS - 1).map(at).collect()
}

#[test]
fn the_motor_never_exceeds_its_limit() {
    let largest =
        |columns: &[Vec<f64>; 5]| motor_forces(columns).into_iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let (clipped, free) = (
        largest(&drive(limited(&TIGHT, Coupling::Physical, Damping::Velocity), input)),
        largest(&drive(unlimited(Damping::Velocity), input)),
    );
    // The trapezium over a tick is good to some 1e-3 N here.
    assert!((clipped - 1.2).abs() < 5e-3, "{clipped}");
    assert!(free > 2.5, "{free}");
}

#[test]
fn the_force_integral_does_not_wind_up() {
    // Half a second of more than the motor can give, then nothing: the motor has to let go as if that had not lasted.
    let motor_after = |overload_ticks: usize| {
        let push = |k: usize| (0.0, if k < overload_ticks { 4.0 } else { 0.0 }, 0.0);
        let columns = drive(limited(&TIGHT, Coupling::Physical, Damping::Velocity), push);
        motor_forces(&columns)[overload_ticks + 100]
    };
    let (short, long) = (motor_after(300), motor_after(600));
    assert!((short - long).abs() < 0.05, "{short} {long}");
}

#[test]
fn a_limit_of_nothing_is_refused() {
    for limits in [
        ActuatorLimits { master_force_n: Some(0.0), ..Default::default() },
        ActuatorLimits { slave_command: Some(f64::NAN), ..Default::default() },
    ] {
        assert!(limits.validate().is_err(), "{limits:?}");
    }
}
