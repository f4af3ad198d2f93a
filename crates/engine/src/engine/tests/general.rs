//! General slaves: three descriptions of one machine, the second engine, and closed forms of friction in a run.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::super::{ExactPlants, GeneralPlants, GeneralSlave, MasterPlants, Plants, TissueForce};
use crate::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, MasterParameters, MasterStep, SlaveController, SlaveModel,
    SlaveParameters, SlaveStep,
};

const TICK_S: f64 = 1e-3;
const NONE: ActuatorLimits = ActuatorLimits::NONE;

fn pid(slave: SlaveParameters) -> SlaveParameters {
    SlaveParameters {
        controller: SlaveController::Pid,
        proportional_gain: 700.0,
        derivative_gain: 6.0,
        integral_gain: 900.0,
        velocity_gain: 9.0,
        force_feed_forward: 0.4,
        ..slave
    }
}

fn mass_damper(mass_kg: f64, damping_n_s_per_m: f64, coulomb_friction_n: f64) -> SlaveParameters {
    let model = SlaveModel::MassDamper;
    pid(SlaveParameters { model, mass_kg, damping_n_s_per_m, coulomb_friction_n, ..Default::default() })
}

/// Positions and velocities of a slave that follows a moving reference against a spring.
fn trace(mut slave: GeneralSlave, ticks: u32) -> Vec<[f64; 2]> {
    let mut motions = vec![];
    for tick in 0..ticks {
        let t = TICK_S * f64::from(tick);
        let [position_m, velocity] = slave.output();
        motions.push([position_m, velocity]);
        let force_n = 300.0 * (position_m - 0.004).max(0.0) + 0.5 * (30.0 * t).sin();
        let reference_m = 0.002 + 0.01 * (7.0 * t).sin() + if tick > 200 { 1e-3 } else { 0.0 };
        let force = TissueForce { on_needle_n: force_n, measured_n: 0.9 * force_n };
        slave.step(reference_m, force).expect("a step");
    }
    motions
}

fn exact(slave: &SlaveParameters) -> GeneralSlave {
    GeneralSlave::exact(slave, &NONE, TICK_S, 0.002).expect("valid")
}

fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> [f64; 2] {
    let of = |i: usize| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs()).fold(0.0, f64::max);
    assert!(a.iter().flatten().chain(b.iter().flatten()).all(|value| value.is_finite()));
    [of(0), of(1)]
}

#[test]
fn ten_random_machines_move_alike_in_every_description() {
    let mut random = ChaCha8Rng::seed_from_u64(59);
    for case in 0..10 {
        let (mass_kg, damping) = (random.random_range(0.1..1.0), random.random_range(0.0..6.0));
        // A mass, and in every second case a lag of its motor.
        let lag_s = if case % 2 == 0 { 0.0 } else { random.random_range(0.002..0.02) };
        let plain = mass_damper(mass_kg, damping, 0.0);
        let base = pid(SlaveParameters::default());
        let (denominator, a, b, c);
        if lag_s == 0.0 {
            denominator = vec![mass_kg, damping, 0.0];
            // Scaled states: micrometres and cm/s.
            a = vec![0.0, 1e4, 0.0, -damping / mass_kg];
            b = vec![0.0, 0.0, 1e2 / mass_kg, 1e2 / mass_kg];
            c = vec![1e-6, 0.0];
        } else {
            // Both forces pass the lag, as in the transfer function.
            denominator = vec![mass_kg * lag_s, mass_kg + damping * lag_s, damping, 0.0];
            a = vec![0.0, 1.0, 0.0, 0.0, -damping / mass_kg, 1.0 / mass_kg, 0.0, 0.0, -1.0 / lag_s];
            b = vec![0.0, 0.0, 0.0, 0.0, 1.0 / lag_s, 1.0 / lag_s];
            c = vec![1.0, 0.0, 0.0];
        }
        let function =
            SlaveParameters { model: SlaveModel::TransferFunction, numerator: vec![1.0], denominator, ..base.clone() };
        let matrices = SlaveParameters { model: SlaveModel::StateSpace, a, b, c, ..base };
        let traces = [&function, &matrices, &plain].map(|slave| trace(exact(slave), 600));
        let [position, velocity] = difference(&traces[0], &traces[1]);
        assert!(position < 1e-9 && velocity < 1e-9, "{case}: {position:e} {velocity:e}");
        if lag_s == 0.0 {
            let [position, velocity] = difference(&traces[0], &traces[2]);
            assert!(position < 1e-9 && velocity < 1e-9, "{case}: {position:e} {velocity:e}");
        }
        let second = GeneralSlave::integrated(&matrices, &NONE, TICK_S, 0.002).expect("valid");
        let [position, velocity] = difference(&traces[1], &trace(second, 600));
        assert!(position < 1e-9 && velocity < 1e-7, "{case}: second engine {position:e} {velocity:e}");
    }
}

#[test]
fn machines_of_many_states_agree_with_the_second_engine() {
    // Two flexible modes and a lag behind a mass: 8 states with coefficients over many decades.
    let multiply = |a: &[f64], b: &[f64]| {
        let mut product = vec![0.0; a.len() + b.len() - 1];
        for (i, x) in a.iter().enumerate() {
            for (j, y) in b.iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        product
    };
    let factors = [vec![0.4, 3.0, 0.0], vec![1.0 / 9e4, 0.1 / 300.0, 1.0], vec![1.0 / 4e6, 0.1 / 2000.0, 1.0]];
    let mut denominator = factors.iter().fold(vec![1.0], |product, factor| multiply(&product, factor));
    denominator = multiply(&multiply(&denominator, &[1e-3, 1.0]), &[5e-4, 1.0]);
    let slave = SlaveParameters {
        model: SlaveModel::TransferFunction,
        numerator: vec![1.0],
        denominator,
        ..SlaveParameters { proportional_gain: 300.0, velocity_gain: 8.0, ..Default::default() }
    };
    let second = GeneralSlave::integrated(&slave, &NONE, TICK_S, 0.002).expect("valid");
    let [position, velocity] = difference(&trace(exact(&slave), 600), &trace(second, 600));
    assert!(position < 1e-9 && velocity < 1e-7, "{position:e} {velocity:e}");
}

#[test]
fn friction_agrees_with_the_second_engine_at_a_tenth_of_the_tick() {
    for limit_n in [0.1, 0.6, 3.0] {
        let slave = mass_damper(0.4, 2.0, limit_n);
        let second = GeneralSlave::integrated(&slave, &NONE, TICK_S, 0.002).expect("valid");
        let [position, _] = difference(&trace(exact(&slave), 800), &trace(second, 800));
        assert!(position < 2e-6, "{limit_n}: {position:e}");
        // The comparison is meaningful only if friction acts.
        let [without, _] = difference(&trace(exact(&slave), 800), &trace(exact(&mass_damper(0.4, 2.0, 0.0)), 800));
        assert!(without > 1e-5, "{limit_n}: {without:e}");
    }
}

#[test]
fn friction_holds_at_rest_without_chatter() {
    let slave = SlaveParameters { force_feed_forward: 0.0, integral_gain: 0.0, ..mass_damper(0.4, 2.0, 1.0) };
    let mut held = exact(&slave);
    for tick in 0..500 {
        // Up to 0.99 N in both directions.
        let force_n = 0.99 * (0.1 * f64::from(tick)).sin();
        held.step(0.002, TissueForce { on_needle_n: force_n, measured_n: force_n }).expect("a step");
        assert_eq!(held.output(), [0.002, 0.0], "{tick}");
    }
    // Beyond the limit it moves against the force.
    held.step(0.002, TissueForce { on_needle_n: 1.01, measured_n: 1.01 }).expect("a step");
    assert!(held.output()[1] < 0.0);
}

#[test]
fn a_load_acts_only_where_it_is_declared() {
    let loaded = mass_damper(0.4, 2.0, 0.0);
    let free = SlaveParameters { load: false, force_feed_forward: 0.0, ..loaded.clone() };
    let push = |slave: &SlaveParameters| {
        let mut slave = exact(slave);
        slave.step(0.002, TissueForce { on_needle_n: 2.0, measured_n: 0.0 }).expect("a step");
        slave.output()[1]
    };
    assert!((push(&loaded) + 2.0 / 0.4 * 1e-3).abs() < 1e-4);
    assert_eq!(push(&free), 0.0);
    let second = |slave: &SlaveParameters| GeneralSlave::integrated(slave, &NONE, TICK_S, 0.002).expect("valid");
    let difference = difference(&trace(exact(&free), 300), &trace(second(&free), 300));
    assert!(difference[0] < 1e-10, "{difference:?}");
}

#[test]
fn a_constant_force_shifts_a_slave_at_rest_by_the_gain_of_its_controller() {
    let rests = |load, integral_gain| {
        let slave = SlaveParameters { constant_force_n: 7.0, load, integral_gain, ..mass_damper(0.4, 2.0, 0.0) };
        let second = GeneralSlave::integrated(&slave, &NONE, TICK_S, 0.002).expect("valid");
        for mut slave in [exact(&slave), second.clone()] {
            let start = slave.output();
            for _ in 0..100 {
                slave.step(0.002, TissueForce::zero()).expect("a step");
            }
            assert!((slave.output()[0] - start[0]).abs() < 1e-12, "stays where it rests");
        }
        let [position, velocity] = difference(&trace(exact(&slave), 300), &trace(second, 300));
        assert!(position < 1e-10 && velocity < 1e-8, "{position:e} {velocity:e}");
        exact(&slave).output()[0]
    };
    for load in [true, false] {
        assert!((rests(load, 0.0) - (0.002 + 7.0 / 700.0)).abs() < 1e-12);
        assert!((rests(load, 900.0) - 0.002).abs() < 1e-12);
    }
    // Friction holds the mass under the force.
    let slave = SlaveParameters {
        constant_force_n: 0.5,
        proportional_gain: 0.0,
        integral_gain: 0.0,
        ..mass_damper(0.4, 2.0, 1.0)
    };
    let mut held = exact(&slave);
    held.step(0.002, TissueForce::zero()).expect("a step");
    assert_eq!(held.output(), [0.002, 0.0]);
}

#[test]
fn the_appendix_machine_as_a_transfer_function_equals_the_sampled_slave_of_the_appendix() {
    let timing = ControlTiming::Sampled;
    let appendix = SlaveParameters::default();
    let slave = SlaveParameters { model: SlaveModel::TransferFunction, load: false, ..appendix.clone() };
    let (master, arm) = (MasterParameters::default(), ArmParameters::default());
    let master = MasterStep::new(&master, &arm, timing, TICK_S).expect("valid");
    let step = SlaveStep::new(&appendix, timing, TICK_S).expect("valid");
    let of_appendix = ExactPlants::<f64>::new(&master, &step, 0.0, 0.002);
    let mut general = GeneralPlants::new(MasterPlants::Exact(Box::new(of_appendix.clone())), exact(&slave));
    let mut of_appendix = of_appendix;
    for tick in 0..500 {
        let reference_m = 0.002 + 0.01 * (0.02 * f64::from(tick)).sin();
        let force = TissueForce { on_needle_n: 1.0, measured_n: 1.0 };
        for plants in [&mut general as &mut dyn Plants<f64>, &mut of_appendix] {
            plants.step(0.0, 0.0, 0.3, reference_m, 1e-4, force).expect("a step");
        }
        let (a, b) = (general.slave(), of_appendix.slave());
        assert!((a.position_m - b.position_m).abs() < 1e-12, "{tick}: {a:?} {b:?}");
        assert!((a.velocity_m_per_s - b.velocity_m_per_s).abs() < 1e-10, "{tick}: {a:?} {b:?}");
        assert_eq!(general.master().position_m.to_bits(), of_appendix.master().position_m.to_bits());
    }
}

#[test]
fn a_limited_command_stops_the_integral() {
    let slave = mass_damper(0.4, 2.0, 0.0);
    let limits = ActuatorLimits { slave_command: Some(0.5), ..NONE };
    let mut limited = GeneralSlave::exact(&slave, &limits, TICK_S, 0.0).expect("valid");
    for _ in 0..2000 {
        limited.step(0.05, TissueForce::zero()).expect("a step");
        assert!(limited.output()[1] < 0.5 / 2.0, "a force of 0.5 N drives the mass at most at 0.25 m/s");
    }
    assert!((limited.output()[0] - 0.05).abs() < 1e-3, "{:?}", limited.output());
}
