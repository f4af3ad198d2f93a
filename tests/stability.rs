//! The linearised loop, held against the engine, the reference limits, the eigenvalues and closed forms.

mod support;

use nalgebra::DVector;
use trocar::engine::Trace;
use trocar::lti::{Complex64, eigenvalues};
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar::stability::{ClosedLoop, Hybrid, LoopSettings, Parameter, Ports, Search, largest_stable};

/// A ramp into a tissue that begins where the needle starts, so that it stays in contact.
const BASE: [&str; 9] = [
    "operator.kind=ramp",
    "operator.start_m=0",
    "operator.end_m=0.01",
    "operator.speed_m_per_s=0.02",
    "tissue.kind=kelvin-voigt",
    "tissue.contact_m=0",
    "augmentation.enabled=false",
    "simulation.duration_s=1.5",
    "passivity.scheme=none",
];

fn scenario(settings: &[&str]) -> Scenario {
    let all: Vec<String> = BASE.iter().chain(settings).map(|setting| (*setting).to_owned()).collect();
    Scenario::load(&Source::parse("builtin:21_late_wall.toml"), &all).expect("loads")
}

fn settings(settings: &[&str]) -> LoopSettings {
    LoopSettings::of(&scenario(settings))
}

/// The loops of the tests: architecture, timing, delays, what lags.
const LOOPS: [&[&str]; 13] = [
    &["channel.forward_delay_s=0", "channel.backward_delay_s=0"],
    &["channel.forward_delay_s=0.005", "channel.backward_delay_s=0.002", "tissue.damping_n_s_per_m=5"],
    &["channel.forward_delay_s=0.0037", "channel.backward_delay_s=0.0021"],
    &["channel.forward_delay_s=0.0007", "channel.backward_delay_s=0.002", "scaling.force=0.6", "scaling.position=0.5"],
    &["channel.forward_delay_s=0.05", "channel.backward_delay_s=0.0505"],
    &["simulation.control=sampled", "channel.forward_delay_s=0.0031", "channel.backward_delay_s=0"],
    &["simulation.control=sampled", "actuator.master_lag_s=0.003", "actuator.slave_lag_s=0.002"],
    &["sensor.force_bandwidth_hz=40", "simulation.tick_s=0.002"],
    &["slave.compliance_m_per_n=0.0002", "channel.forward_delay_s=0.001", "channel.backward_delay_s=0.001"],
    &[
        "controller.kind=local-force",
        "controller.slave_force_gain=1",
        "channel.forward_delay_s=0",
        "channel.backward_delay_s=0.001",
    ],
    &["controller.kind=position-position", "channel.forward_delay_s=0.003", "channel.backward_delay_s=0.002"],
    &["controller.kind=four-channel", "channel.forward_delay_s=0", "channel.backward_delay_s=0", "arm.grip=firm"],
    &[
        "controller.kind=four-channel",
        "simulation.control=sampled",
        "channel.forward_delay_s=0.002",
        "scaling.force=0.5",
    ],
];

fn softly(settings: &[&'static str]) -> Vec<&'static str> {
    let mut all = settings.to_vec();
    all.push("tissue.stiffness_n_per_m=100");
    all
}

#[test]
fn powers_of_the_matrix_are_the_trajectory_of_the_engine() {
    for case in LOOPS {
        let scenario = scenario(&softly(case));
        let closed = ClosedLoop::new(&LoopSettings::of(&scenario)).expect("built");
        let (matrix, [now, next], slave) = closed.matrix().expect("not too long");
        let trace: Trace = run(scenario).expect("runs").trace;
        assert!(trace.slave_position_m.iter().skip(1).all(|&x| x >= 0.0), "{case:?}: contact is lost");
        // Until the hand has stopped tick by tick, then by powers of the matrix alone.
        let ticks = trace.time_s.len();
        let stops = 2 * ticks / 5;
        let desired = &trace.desired_position_m;
        assert_eq!(desired[stops], desired[ticks - 1]);
        let mut state = DVector::zeros(matrix.nrows());
        for k in 0..stops {
            state = &matrix * state + &now * desired[k] + &next * desired[k + 1];
        }
        let n = matrix.nrows();
        let mut held = matrix.clone().resize(n + 1, n + 1, 0.0);
        held.view_mut((0, n), (n, 1)).copy_from(&((&now + &next) * desired[stops]));
        held[(n, n)] = 1.0;
        let mut state = state.push(1.0);
        let mut power = held;
        // After 1, 2, 4, ... ticks more.
        let mut at = stops;
        let peak = |column: &[f64]| column.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        for squarings in 0.. {
            let further = 1 << squarings;
            if at + further >= ticks {
                break;
            }
            state = &power * state;
            at += further;
            for (name, computed, column) in [
                ("x_h", state[0], &trace.master_position_m),
                ("v_h", state[1], &trace.master_velocity_m_per_s),
                ("x_e", state[slave], &trace.slave_position_m),
                ("v_e", state[slave + 1], &trace.slave_velocity_m_per_s),
            ] {
                let difference = (computed - column[at]).abs() / peak(column);
                assert!(difference < 1e-9, "{case:?} {name} at tick {at}: {difference:e}");
            }
            power = &power * &power;
        }
        assert!(at > stops + 200);
    }
}

#[test]
fn oracle_the_largest_stable_stiffness_is_the_references() {
    let table = support::table("tests/reference/stability_limits.csv");
    for row in 0..8 {
        let column = |name: &str| table[name][row];
        let delay_s = 1e-3 * column("delay_ticks_each_way");
        let settings =
            settings(&[]).with(Parameter::Delay, delay_s).with(Parameter::Damping, column("tissue_damping_n_s_per_m"));
        let limit = largest_stable(&settings, Parameter::Stiffness, Search::of(Parameter::Stiffness)).expect("found");
        let (found, expected) = (limit.largest().expect("stable"), column("largest_stable_stiffness_n_per_m"));
        assert!((found / expected - 1.0).abs() < 1e-8, "{delay_s}: {found} {expected}");
        assert_eq!(limit.stable.len(), 1);
    }
}

#[test]
fn at_fifty_milliseconds_each_way_the_wall_may_have_907_newtons_a_metre() {
    let limit = largest_stable(&settings(&[]), Parameter::Stiffness, Search::of(Parameter::Stiffness)).expect("found");
    let largest = limit.largest().expect("stable");
    assert_eq!(largest.floor(), 907.0);
}

#[test]
fn poles_counted_by_turns_are_the_eigenvalues_outside() {
    let mut seen = [0; 4];
    for case in LOOPS {
        for (k, stiffness) in [3.0, 60.0, 300.0, 900.0, 1600.0, 4000.0, 30_000.0].into_iter().enumerate() {
            for force in [0.3, 1.0, 2.5] {
                let settings = settings(case).with(Parameter::Stiffness, stiffness).with(Parameter::ForceScale, force);
                let closed = ClosedLoop::new(&settings).expect("built");
                let poles = eigenvalues(&closed.matrix().expect("not too long").0).expect("found");
                for radius in [1.0, 0.99, 1.02] {
                    let outside = poles.iter().filter(|pole| pole.norm() >= radius).count();
                    let clear = poles.iter().all(|pole| (pole.norm() - radius).abs() > 1e-7);
                    if clear {
                        let counted = closed.poles_outside(radius).expect("counted");
                        assert_eq!(counted, outside, "{case:?} {k} {force} {radius}");
                        seen[outside.min(3)] += 1;
                    }
                }
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 5), "{seen:?}");
}
