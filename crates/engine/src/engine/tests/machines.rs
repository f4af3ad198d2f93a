//! The exact steps against the numerical integration, which shares no code with them.

use super::super::{ExactPlants, FractionalDelayPlants, IntegratedPlants, LimitedPlants, Plants, TissueForce};
use crate::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, Coupling, Damping, MasterParameters, MasterStep, SlaveParameters,
    SlaveStep,
};

const TICK_S: f64 = 1e-3;
const START_M: f64 = 0.012;
const REFERENCE_M: f64 = 0.006;

fn exact(
    (master, arm, slave): (&MasterParameters, &ArmParameters, &SlaveParameters),
    timing: ControlTiming,
) -> ExactPlants<f64> {
    let master = MasterStep::new(master, arm, timing, TICK_S).expect("valid");
    let slave = SlaveStep::new(slave, timing, TICK_S).expect("valid");
    ExactPlants::new(&master, &slave, START_M, REFERENCE_M)
}

fn inputs(tick: u32) -> [f64; 3] {
    let t = TICK_S * f64::from(tick);
    let force_n = if tick < 60 { 0.0 } else { 1.5 + (40.0 * t).sin() };
    [START_M + 0.02 * t, force_n, REFERENCE_M + 0.004 * (25.0 * t).sin() + if tick > 100 { 2e-3 } else { 0.0 }]
}

fn deflection(tick: u32) -> f64 {
    3e-4 * (60.0 * TICK_S * f64::from(tick)).sin() + if tick > 70 { 1e-3 } else { 0.0 }
}

/// Runs both plants side by side. Returns the largest differences of position, velocity and force of the master, and of
/// position and velocity of the slave.
fn differences(mut a: impl Plants<f64>, mut b: impl Plants<f64>, ticks: u32) -> [f64; 5] {
    let mut largest = [0.0_f64; 5];
    for tick in 0..=ticks {
        let (m, n) = (a.master(), b.master());
        let (s, t) = (a.slave(), b.slave());
        let now = [
            m.position_m - n.position_m,
            m.velocity_m_per_s - n.velocity_m_per_s,
            m.hand_force_n - n.hand_force_n,
            s.position_m - t.position_m,
            s.velocity_m_per_s - t.velocity_m_per_s,
        ];
        largest = std::array::from_fn(|i| if now[i].is_nan() { f64::INFINITY } else { largest[i].max(now[i].abs()) });
        let ([desired, force, reference], [next, ..]) = (inputs(tick), inputs(tick + 1));
        a.step(desired, next, force, reference, deflection(tick), TissueForce::zero()).expect("a step");
        b.step(desired, next, force, reference, deflection(tick), TissueForce::zero()).expect("a step");
    }
    largest
}

#[track_caller]
fn assert_alike(differences: [f64; 5], label: &str) {
    let bounds = [1e-11, 1e-9, 1e-8, 1e-11, 1e-9];
    assert!((0..5).all(|i| differences[i] <= bounds[i]), "{label}: {differences:?}");
}

#[test]
fn the_exact_step_agrees_with_numerical_integration() {
    let arm = ArmParameters::default();
    for timing in [ControlTiming::Continuous, ControlTiming::Sampled] {
        for (coupling, damping, ticks) in [
            (Coupling::Physical, Damping::Velocity, 250),
            (Coupling::Physical, Damping::AsPrinted, 250),
            // Unstable: the motion grows.
            (Coupling::AsPrinted, Damping::Velocity, 40),
        ] {
            let master = MasterParameters { coupling, ..MasterParameters::default() };
            let slave = SlaveParameters { damping, ..SlaveParameters::default() };
            let machines = (&master, &arm, &slave);
            let integrated = IntegratedPlants::new(machines, timing, TICK_S, START_M, REFERENCE_M);
            let found = differences(exact(machines, timing), integrated, ticks);
            assert_alike(found, &format!("{timing:?} {coupling:?} {damping:?}"));
        }
    }
}

#[test]
fn slaves_of_second_order_and_held_slaves_are_stepped_exactly_too() {
    let (master, arm) = (MasterParameters::default(), ArmParameters::default());
    let (numerator, denominator) = (vec![0.0, 12.6], vec![2.0, 3.0, 0.5]);
    let second = SlaveParameters { numerator, denominator, ..SlaveParameters::default() };
    // Every coefficient acts, and the rest position differs from the reference.
    let (numerator, denominator) = (vec![9.0, 700.0], vec![1.0, 104.0, 60.0, 4e4]);
    let third = SlaveParameters { numerator, denominator, ..SlaveParameters::default() };
    for slave in [second, third] {
        for timing in [ControlTiming::Continuous, ControlTiming::Sampled] {
            let machines = (&master, &arm, &slave);
            let integrated = IntegratedPlants::new(machines, timing, TICK_S, START_M, REFERENCE_M);
            let found = differences(exact(machines, timing), integrated, 250);
            assert_alike(found, &format!("{timing:?} {:?}", slave.denominator));
        }
    }
}

#[test]
fn at_the_start_the_machines_are_at_rest_at_the_given_positions() {
    let (master, arm, slave) = (MasterParameters::default(), ArmParameters::default(), SlaveParameters::default());
    let machines = (&master, &arm, &slave);
    let limited = LimitedPlants::<f64>::new(machines, &ActuatorLimits::NONE, TICK_S, START_M, REFERENCE_M);
    let all: [Box<dyn Plants<f64>>; 4] = [
        Box::new(exact(machines, ControlTiming::Continuous)),
        Box::new(exact(machines, ControlTiming::Sampled)),
        Box::new(IntegratedPlants::new(machines, ControlTiming::Continuous, TICK_S, START_M, REFERENCE_M)),
        Box::new(limited.expect("valid")),
    ];
    for mut plants in all {
        for _ in 0..50 {
            let (master, slave) = (plants.master(), plants.slave());
            assert!((master.position_m - START_M).abs() < 1e-12 && master.velocity_m_per_s.abs() < 1e-10, "{master:?}");
            assert!(master.hand_force_n.abs() < 1e-8, "{master:?}");
            assert!((slave.position_m - REFERENCE_M).abs() < 1e-10 && slave.velocity_m_per_s.abs() < 1e-8, "{slave:?}");
            plants.step(START_M, START_M, 0.0, REFERENCE_M, 0.0, TissueForce::zero()).expect("a step");
        }
    }
}

#[test]
fn samples_that_arrive_within_a_tick_act_from_their_arrival() {
    let (master, arm, slave) = (MasterParameters::default(), ArmParameters::default(), SlaveParameters::default());
    let timing = ControlTiming::Continuous;
    for (force_share, reference_share) in [(0.7, 0.2), (0.25, 0.25), (0.1, 0.9)] {
        let rest = |share: f64| TICK_S * (1.0 - share);
        let late_master = MasterStep::new(&master, &arm, timing, rest(force_share)).expect("valid");
        let late_slave = SlaveStep::new(&slave, timing, rest(reference_share)).expect("valid");
        let machines = (&master, &arm, &slave);
        let split = FractionalDelayPlants::new(exact(machines, timing), &late_master, &late_slave, REFERENCE_M);
        let integrated = IntegratedPlants::new(machines, timing, TICK_S, START_M, REFERENCE_M);
        let found = differences(split, integrated.split(force_share, reference_share), 200);
        assert_alike(found, &format!("{force_share} {reference_share}"));
    }
}
