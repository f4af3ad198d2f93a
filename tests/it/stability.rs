//! The linearised loop agrees with the engine, the reference limits, the eigenvalues and closed forms.

use crate::support;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trocar::engine::Trace;
use trocar::lti::{Complex64, eigenvalues};
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar::stability::{
    AbsoluteOver, Axis, Bounded, ClosedLoop, Hybrid, Limit, LinearLoop, Parameter, Ports, SampledBound, SampledWall,
    Search, Spacing, Terminations, ZWidth, arm_impedance, largest_stable, sensitivities,
};

/// A ramp into a tissue that begins at the start of the needle, so that contact is permanent.
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
    Scenario::load(&Source::parse("builtin:passivity/late-wall.toml"), &all).expect("loads")
}

fn limit(settings: &LinearLoop, parameter: Parameter) -> Limit {
    largest_stable(settings, parameter, Search::of(parameter)).expect("found")
}

fn settings(settings: &[&str]) -> LinearLoop {
    support::linear_loop(&scenario(settings))
}

/// The loops of the tests: architecture, timing, delays and lags, as settings.
const LOOPS: [&str; 17] = [
    "channel.forward_delay_s=0 channel.backward_delay_s=0",
    "channel.forward_delay_s=0.005 channel.backward_delay_s=0.002 tissue.damping_n_s_per_m=5",
    "channel.forward_delay_s=0.0037 channel.backward_delay_s=0.0021",
    "channel.forward_delay_s=0.0007 channel.backward_delay_s=0.002 scaling.force=0.6 scaling.position=0.5",
    "channel.forward_delay_s=0.05 channel.backward_delay_s=0.0505",
    "simulation.control=sampled channel.forward_delay_s=0.0031 channel.backward_delay_s=0",
    "simulation.control=sampled actuator.master_lag_s=0.003 actuator.slave_lag_s=0.002",
    "sensor.force_bandwidth_hz=40 simulation.tick_s=0.002",
    "slave.compliance_m_per_n=0.0002 channel.forward_delay_s=0.001 channel.backward_delay_s=0.001",
    "controller.kind=local-force controller.slave_force_gain=1 channel.forward_delay_s=0 channel.backward_delay_s=0.001",
    "controller.kind=position-position channel.forward_delay_s=0.003 channel.backward_delay_s=0.002",
    "controller.kind=four-channel channel.forward_delay_s=0 channel.backward_delay_s=0 arm.grip=firm",
    "controller.kind=four-channel simulation.control=sampled channel.forward_delay_s=0.002 scaling.force=0.5",
    "slave.compliance_m_per_n=0.0002 channel.forward_delay_s=0.0037 channel.backward_delay_s=0.0021",
    "slave.model=mass-damper slave.mass_kg=0.4 slave.damping_n_s_per_m=3 slave.controller=pid slave.derivative_gain=6 \
     slave.integral_gain=300 slave.force_feed_forward=0.3 sensor.force_bandwidth_hz=60 channel.forward_delay_s=0.0013 \
     channel.backward_delay_s=0.002",
    "slave.model=state-space slave.a=[0.0,1.0,0.0,0.0,-5.0,2.5,0.0,0.0,-400.0] slave.b=[0.0,0.0,0.0,2.5,400.0,0.0] \
     slave.c=[1.0,0.0,0.0] simulation.control=sampled actuator.master_lag_s=0.002 controller.kind=local-force \
     controller.slave_force_gain=0.5 slave.compliance_m_per_n=0.0002",
    "slave.model=transfer-function slave.load=false slave.controller=pid slave.derivative_gain=2 \
     controller.kind=position-position channel.forward_delay_s=0.003",
];

/// The readings of the appendix as it is printed.
const AS_PRINTED: [&str; 2] = [
    "slave.damping=as-printed channel.forward_delay_s=0 channel.backward_delay_s=0.003",
    "master.coupling=as-printed channel.forward_delay_s=0 channel.backward_delay_s=0.003",
];

fn split(settings: &str) -> Vec<&str> {
    settings.split(' ').collect()
}

#[test]
fn powers_of_the_matrix_agree_with_the_trajectory_of_the_engine() {
    for case in LOOPS {
        let scenario = scenario(&split(&format!("{case} tissue.stiffness_n_per_m=100")));
        let closed = ClosedLoop::new(&support::linear_loop(&scenario)).expect("built");
        let (matrix, [now, next], slave) = closed.matrix().expect("not too long");
        let trace: Trace = run(scenario).expect("runs").trace;
        assert!(trace.slave_position_m.iter().skip(1).all(|&x| x >= 0.0), "{case:?}: contact is lost");
        // Advance tick by tick until the hand has stopped, then only by powers of the matrix.
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
        // After 1, 2, 4, ... additional ticks.
        let mut at = stops;
        let peak = |column: &[f64]| column.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        for squarings in 0.. {
            let step = 1 << squarings;
            if at + step >= ticks {
                break;
            }
            state = &power * state;
            at += step;
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
fn oracle_the_largest_stable_stiffness_agrees_with_the_reference() {
    let table = support::table("tests/reference/stability_limits.csv");
    let rows = table["largest_stable_stiffness_n_per_m"].len();
    assert_eq!(rows, 8);
    for row in (0..rows).rev() {
        let column = |name: &str| table[name][row];
        let delay_s = 1e-3 * column("delay_ticks_each_way");
        let settings =
            settings(&[]).with(Parameter::Delay, delay_s).with(Parameter::Damping, column("tissue_damping_n_s_per_m"));
        let limit = limit(&settings, Parameter::Stiffness);
        let (found, expected) = (limit.largest().expect("stable"), column("largest_stable_stiffness_n_per_m"));
        assert!((found / expected - 1.0).abs() < 1e-8, "{delay_s}: {found} {expected}");
        assert_eq!(limit.stable.len(), 1);
    }
}

#[test]
fn oracle_the_limits_of_ten_general_slaves_agree_with_python_control_in_every_description() {
    let table = support::table("tests/reference/general_slave_limits.csv");
    assert_eq!(table["mass_kg"].len(), 10);
    for (row, &m) in table["mass_kg"].iter().enumerate() {
        let column = |name: &str| table[name][row];
        let (b, lag) = (column("damping_n_s_per_m"), column("lag_s"));
        let mut descriptions = vec![vec![
            "slave.model=transfer-function".to_owned(),
            "slave.numerator=[1.0]".to_owned(),
            format!("slave.denominator=[{:?}, {:?}, {b:?}, 0.0]", m * lag, m + b * lag),
        ]];
        if lag == 0.0 {
            descriptions[0][2] = format!("slave.denominator=[{m:?}, {b:?}, 0.0]");
            descriptions.push(vec![
                "slave.model=mass-damper".to_owned(),
                format!("slave.mass_kg={m}"),
                format!("slave.damping_n_s_per_m={b}"),
            ]);
            descriptions.push(vec![
                "slave.model=state-space".to_owned(),
                format!("slave.a=[0.0, 100.0, 0.0, {:?}]", -b / m),
                format!("slave.b=[0.0, 0.0, {0:?}, {0:?}]", 0.01 / m),
                "slave.c=[1.0, 0.0]".to_owned(),
            ]);
        } else {
            descriptions.push(vec![
                "slave.model=state-space".to_owned(),
                format!("slave.a=[0.0, 1.0, 0.0, 0.0, {:?}, {:?}, 0.0, 0.0, {:?}]", -b / m, 1.0 / m, -1.0 / lag),
                format!("slave.b=[0.0, 0.0, 0.0, 0.0, {0:?}, {0:?}]", 1.0 / lag),
                "slave.c=[1.0, 0.0, 0.0]".to_owned(),
            ]);
        }
        for mut description in descriptions {
            description.push("slave.controller=pid".to_owned());
            for name in ["proportional_gain", "derivative_gain", "integral_gain", "velocity_gain", "force_feed_forward"]
            {
                description.push(format!("slave.{name}={}", column(name)));
            }
            let keys: Vec<&str> = description.iter().map(String::as_str).collect();
            let settings = settings(&keys).with(Parameter::Delay, 1e-3 * column("delay_ticks_each_way"));
            let limit = limit(&settings, Parameter::Stiffness);
            let (found, expected) = (limit.stable[0].1, column("largest_stable_stiffness_n_per_m"));
            assert!((found / expected - 1.0).abs() < 1e-6, "{row} {description:?}: {found} {expected}");
        }
    }
}

#[test]
fn a_general_master_has_the_limits_of_the_appendix_in_every_description() {
    // The master of eq. 28 with its controller on the tick.
    let slave = ["slave.model=mass-damper", "slave.controller=pid", "slave.mass_kg=0.3", "slave.damping_n_s_per_m=2"];
    let with = |description: &[&str]| {
        limit(&settings(&[slave.as_slice(), description].concat()), Parameter::Stiffness).stable[0].1
    };
    let expected = with(&["simulation.control=sampled"]);
    for description in [
        &["master.model=mass-damper"][..],
        &["master.model=transfer-function", "master.numerator=[2.0]", "master.denominator=[0.49, 8.2, 0.0]"],
        &[
            "master.model=state-space",
            "master.a=[0.0, 1.0, 0.0, -16.73469387755102]",
            "master.b=[0.0, 0.0, 4.081632653061225, 4.081632653061225]",
            "master.c=[1.0, 0.0]",
        ],
    ] {
        let found = with(description);
        assert!((found / expected - 1.0).abs() < 1e-6, "{description:?}: {found} {expected}");
    }
    // The test can tell masters apart.
    assert!((with(&["master.model=mass-damper", "master.mass_kg=0.5"]) / expected - 1.0).abs() > 0.01);
}

#[test]
fn friction_is_assumed_passive_and_not_left_out() {
    use trocar::stability::{assumed_passive, left_out};
    for friction in ["slave.coulomb_friction_n", "master.coulomb_friction_n"] {
        let value = format!("{friction}=0.3");
        let scenario = scenario(&["master.model=mass-damper", "slave.model=mass-damper", &value]);
        assert_eq!(left_out(&scenario, None), []);
        assert!(assumed_passive(&scenario).iter().map(|part| part.key).eq([friction]));
    }
}

#[test]
fn the_winding_number_equals_the_number_of_unstable_eigenvalues() {
    let mut seen = [0; 4];
    for case in LOOPS.into_iter().chain(AS_PRINTED) {
        for (k, stiffness) in [3.0, 60.0, 300.0, 900.0, 1600.0, 4000.0, 30_000.0].into_iter().enumerate() {
            for force in [0.3, 1.0, 2.5] {
                let settings =
                    settings(&split(case)).with(Parameter::Stiffness, stiffness).with(Parameter::ForceScale, force);
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

#[test]
fn the_mode_of_a_long_delay_agrees_with_its_matrix() {
    for stiffness in [100.0, 600.0, 1500.0] {
        let settings = settings(&[]).with(Parameter::Delay, 0.15).with(Parameter::Stiffness, stiffness);
        let closed = ClosedLoop::new(&settings).expect("built");
        assert!(closed.states() > 300);
        let mode = closed.dominant_mode().expect("found");
        let poles = eigenvalues(&closed.matrix().expect("fits").0).expect("found");
        let greatest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        assert!((mode.spectral_radius - greatest).abs() < 1e-9, "{} {greatest}", mode.spectral_radius);
        assert!(poles.iter().any(|pole| (pole - mode.pole).norm() < 1e-8), "{mode:?}");
        assert_eq!(closed.is_stable().expect("counted"), greatest < 1.0);
    }
}

#[test]
fn the_gain_and_delay_margins_are_the_allowed_increases_of_force_scale_and_delay() {
    let settings = settings(&[]).with(Parameter::Delay, 0.005).with(Parameter::Stiffness, 1000.0);
    let margins = ClosedLoop::new(&settings).expect("built").margins().expect("followed");
    let largest = |parameter| limit(&settings, parameter).largest().expect("stable");
    let gain = margins.gain.expect("some");
    assert!((gain - largest(Parameter::ForceScale)).abs() < 1e-9 * gain, "{gain}");
    // A single continuous delay equals two delays that divide their ticks, to far less than a tick.
    let further_s = 2.0 * (largest(Parameter::Delay) - 0.005);
    let delay_s = margins.delay_s.expect("some");
    assert!((delay_s - further_s).abs() < 1e-5, "{delay_s} {further_s}");
    let unstable = settings.with(Parameter::Stiffness, 1e4);
    assert_eq!(ClosedLoop::new(&unstable).expect("built").margins().expect("followed").gain, None);
}

#[test]
fn without_damping_the_limits_are_inversely_proportional() {
    let settings = settings(&[]).with(Parameter::Delay, 0.0037);
    let limits = [Parameter::Stiffness, Parameter::ForceScale].map(|parameter| limit(&settings, parameter));
    let found = sensitivities(&settings, &limits).expect("found");
    let relative = |limit, parameter| {
        let entry = found.iter().find(|s| s.limit == limit && s.parameter == parameter).expect("there");
        entry.relative.expect("smooth")
    };
    for (limit, parameter) in [
        (Parameter::Stiffness, Parameter::ForceScale),
        (Parameter::Stiffness, Parameter::PositionScale),
        (Parameter::ForceScale, Parameter::Stiffness),
    ] {
        assert!((relative(limit, parameter) + 1.0).abs() < 1e-6, "{limit:?} {parameter:?}");
    }
    assert!(relative(Parameter::Stiffness, Parameter::ForwardDelay) < 0.0);
    assert!(found.iter().all(|s| s.parameter != Parameter::MasterForceGain));
}

/// Returns all hands with at least this damping (N·s/m), and tissues of these stiffnesses and dampings.
fn terminations(hand_n_s_per_m: f64, stiffness_n_per_m: (f64, f64), damping_n_s_per_m: (f64, f64)) -> Terminations {
    Terminations { hand_n_s_per_m: (hand_n_s_per_m, f64::INFINITY), stiffness_n_per_m, damping_n_s_per_m }
}

fn point(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

#[test]
fn a_mass_damper_pair_has_the_hybrid_parameters_of_its_closed_form() {
    let pair = [
        "master.force_integral_gain=0",
        "slave.numerator=[1.0]",
        "slave.denominator=[0.3, 2.0, 0.0]",
        "slave.proportional_gain=1300",
        "slave.velocity_gain=15",
        "scaling.force=0.7",
        "scaling.position=0.4",
        "channel.forward_delay_s=0.003",
        "channel.backward_delay_s=0.0065",
    ];
    let ports = Ports::new(&settings(&pair)).expect("built");
    for hz in [0.2, 1.0, 7.0, 40.0] {
        let s = point(0.0, std::f64::consts::TAU * hz);
        let h = ports.at(s.im).expect("computed").expect("there").h;
        let hold = (point(1.0, 0.0) - (-s * 1e-3).exp()) / (s * 1e-3);
        let follows = point(1300.0, 0.0) / (s * s * 0.3 + s * 17.0 + 1300.0);
        let expected = [
            [s * 0.245 + 4.1, (-s * 0.0065).exp() * hold * 0.7],
            [-(-s * 0.003).exp() * hold * follows * 0.4, point(0.0, 0.0)],
        ];
        for (found, expected) in h.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).norm() < 1e-12 * (1.0 + expected.norm()), "{hz}: {found} {expected}");
        }
        // With a slave without compliance, the loop must have no lag.
        let around = expected[0][1] * expected[1][0];
        let hybrid = Hybrid { h };
        assert!((hybrid.llewellyn() + around.arg().cos()).abs() < 1e-12);
        assert!(!hybrid.is_absolutely_stable() && !hybrid.is_passive((0.7, 0.4)));
    }
}

#[test]
fn a_loaded_slave_has_the_admittance_of_its_closed_form_at_the_needle() {
    let slave = [
        "slave.model=mass-damper",
        "slave.mass_kg=0.3",
        "slave.damping_n_s_per_m=2",
        "slave.controller=pid",
        "slave.derivative_gain=4",
        "slave.integral_gain=100",
        "slave.force_feed_forward=0.2",
        "channel.delay_s=0",
    ];
    let ports = Ports::new(&settings(&slave)).expect("built");
    for hz in [0.2, 1.0, 7.0, 40.0] {
        let s = point(0.0, std::f64::consts::TAU * hz);
        let h = ports.at(s.im).expect("computed").expect("there").h;
        let late = (-s * 1e-3).exp();
        let one = point(1.0, 0.0);
        let hold = (one - late) / (s * 1e-3);
        let on_error = one * 1300.0 + (one - late) * 4000.0 + late / (one - late) * 0.1;
        let dynamics = s * (s * 0.3 + 2.0) + hold * (on_error + s * 15.0);
        // (m s² + b s) x = hold (C (r - x) - K_v s x + K_f f - f)
        let expected = s * hold * (1.0 - 0.2) / dynamics;
        assert!((h[1][1] - expected).norm() < 1e-12 * expected.norm(), "{hz}: {} {expected}", h[1][1]);
        let follows = -hold * on_error / dynamics;
        assert!((h[1][0] - follows).norm() < 1e-12 * (1.0 + follows.norm()), "{hz}: {} {follows}", h[1][0]);
    }
}

#[test]
fn an_ideal_two_port_is_absolutely_stable_and_a_delayed_one_without_damping_is_not() {
    let zero = point(0.0, 0.0);
    let ideal = Hybrid { h: [[zero, point(1.0, 0.0)], [point(-1.0, 0.0), zero]] };
    assert!(ideal.is_absolutely_stable() && ideal.is_passive((1.0, 1.0)));
    assert!((ideal.llewellyn() - 1.0).abs() < 1e-15);
    assert_eq!(ideal.transmitted(point(3.0, -40.0)), point(3.0, -40.0));
    assert_eq!(ideal.stiffest(), None);
    for delay_s in [1e-4, 1e-3, 0.02, 0.3] {
        let delayed = |omega: f64, master: f64, slave: f64| {
            let late = Complex64::from_polar(1.0, -omega * delay_s);
            Hybrid { h: [[point(master, 0.0), late], [-late, point(slave, 0.0)]] }
        };
        for share in [0.05, 0.3, 0.7] {
            // The phase of the loop reaches -π at π / (2 delay).
            let omega = share * std::f64::consts::PI / delay_s;
            let bare = delayed(omega, 0.0, 0.0);
            assert!((bare.llewellyn() - (2.0 * omega * delay_s).cos()).abs() < 1e-12);
            assert!(!bare.is_absolutely_stable() && !bare.is_passive((1.0, 1.0)), "{delay_s} {share}");
            // The damping suffices if 2 r g >= 1 - cos(2ωτ) (Llewellyn). The right side is at most 2, so r g = 1
            // always suffices.
            assert!(delayed(omega, 2.0, 0.5).is_absolutely_stable());
            let just = 0.5 * (1.0 - (2.0 * omega * delay_s).cos());
            assert!(!delayed(omega, 0.999 * just, 1.0).is_absolutely_stable());
            assert!(delayed(omega, 1.001 * just, 1.0).is_absolutely_stable());
        }
    }
}

#[test]
fn the_two_port_with_arm_and_tissue_gives_the_loop() {
    let late = ["channel.forward_delay_s=0.0125", "channel.backward_delay_s=0.02", "tissue.damping_n_s_per_m=5"];
    let settings = settings(&late).with(Parameter::Tick, 1e-4).with(Parameter::ForceScale, 0.8);
    let closed = ClosedLoop::new(&settings).expect("built");
    let ports = Ports::new(&settings).expect("built");
    for hz in [0.3, 2.0, 9.0, 25.0] {
        let s = point(0.0, std::f64::consts::TAU * hz);
        let [[h11, h12], [h21, h22]] = ports.at(s.im).expect("computed").expect("there").h;
        assert_eq!(h22.norm(), 0.0);
        let hand = s.inv() * 733.0 + 37.3;
        let body = s.inv() * 14998.0 + 178.0 + s * 1.88;
        let arm = hand * body / (hand + body);
        let expected = h12 * h21 * ports.tissue(s.im) / (h11 + arm);
        let found = closed.loop_gain(1.0, s.im * 1e-4);
        assert!((found - expected).norm() < 1e-4 * expected.norm(), "{hz} Hz: {found} {expected}");
    }
}

#[test]
fn a_sampled_loop_without_an_integral_has_the_condition_of_colgate_and_schenkel() {
    let bare = ["master.force_integral_gain=0", "simulation.control=sampled", "tissue.damping_n_s_per_m=0"];
    let with = |stiffness: f64, delay_s: f64| {
        settings(&bare).with(Parameter::Stiffness, stiffness).with(Parameter::Delay, delay_s)
    };
    let bound = |stiffness, delay_s| SampledBound::of(&with(stiffness, delay_s)).expect("built").expect("applies");
    // The bound is linear in the stiffness, grows with the delay, and suffices for stability of the loop with the
    // arm.
    let (one, ten) = (bound(10.0, 0.0), bound(100.0, 0.0));
    assert!((ten.min_damping_n_s_per_m - 10.0 * one.min_damping_n_s_per_m).abs() < 1e-9);
    assert!(bound(100.0, 0.02).min_damping_n_s_per_m > ten.min_damping_n_s_per_m);
    let passive = 0.99 * 100.0 * ten.damping_n_s_per_m / ten.min_damping_n_s_per_m;
    assert!(bound(passive, 0.0).is_passive());
    assert!(ClosedLoop::new(&with(passive, 0.0)).expect("built").is_stable().expect("counted"));
    assert_eq!(SampledBound::of(&settings(&[])).expect("built"), None);
}

/// Returns the Z-width over damping of the walls from 0 to 10 N·s/m.
fn z_width(settings: &LinearLoop) -> ZWidth {
    let axis = Axis::parse("tissue.damping_n_s_per_m=0:10:6").expect("an axis");
    ZWidth::of(settings, &axis).expect("computed")
}

#[test]
fn virtual_walls_are_passive_up_to_the_condition_of_colgate_and_schenkel_and_stable_beyond() {
    for (tick_s, damping) in [("0.001", 4.1), ("0.002", 20.0)] {
        let tick = format!("simulation.tick_s={tick_s}");
        let master = format!("master.damping_n_s_per_m={damping}");
        let settings = settings(&["master.force_integral_gain=0", &tick, &master]);
        let found = z_width(&settings);
        let wall = SampledWall { tick_s: settings.tick_s };
        for (&b, walls) in found.damping_n_s_per_m.iter().zip(found.virtual_walls.as_ref().expect("they apply")) {
            let Some(passive) = walls.passive_n_per_m else {
                assert!(b >= damping, "{b}");
                continue;
            };
            // The general condition over the frequencies, for the same wall.
            let needed = wall.min_damping_n_s_per_m(|angle| {
                let before = Complex64::from_polar(1.0, -angle);
                (Complex64::new(1.0, 0.0) - before) * (b / settings.tick_s) + passive
            });
            assert!((needed / damping - 1.0).abs() < 1e-5, "{b}: {needed}");
            assert!(walls.stable_n_per_m.is_some_and(|stable| stable > passive), "{b}: {walls:?}");
        }
    }
}

#[test]
fn without_an_arm_virtual_walls_are_stable_up_to_both_dampings() {
    // K T / 2 = b + B for a mass much heavier than b T and B T (Gil, Avello, Rubio and Florez 2004).
    let mut alone = settings(&["master.force_integral_gain=0", "master.damping_n_s_per_m=4"]);
    for parameter in [Parameter::ArmKa, Parameter::ArmBa, Parameter::ArmKh, Parameter::ArmBh] {
        alone = alone.with(parameter, 0.01);
    }
    alone = alone.with(Parameter::MasterMass, 10.0);
    let found = z_width(&alone);
    for (b, walls) in found.damping_n_s_per_m.iter().zip(found.virtual_walls.expect("they apply")) {
        let stable = walls.stable_n_per_m.expect("stable walls");
        let expected = 2.0 * (4.0 + b) / alone.tick_s;
        assert!((stable / expected - 1.0).abs() < 0.01, "{b}: {stable} {expected}");
    }
}

#[test]
fn walls_in_the_tissue_end_at_the_limits_of_the_loop_and_of_the_sampled_condition() {
    let settings = settings(&["master.force_integral_gain=0", "channel.forward_delay_s=0.002"]);
    let found = z_width(&settings);
    for (&b, walls) in found.damping_n_s_per_m.iter().zip(&found.tissue) {
        let here = settings.with(Parameter::Damping, b);
        let limit = limit(&here, Parameter::Stiffness);
        let stable = walls.stable_n_per_m.expect("stable walls");
        assert!((stable / limit.stable[0].1 - 1.0).abs() < 1e-9, "{b}: {stable} {:?}", limit.stable);
        let Some(passive) = walls.passive_n_per_m else { continue };
        assert!(passive < stable);
        // The two-port of continuous time is passive, so this holds up to the error of a hold near the sampling rate.
        for (share, is_passive) in [(0.97, true), (1.03, false)] {
            let near = here.with(Parameter::Stiffness, share * passive);
            let bound = SampledBound::of(&near).expect("computed").expect("it applies");
            assert_eq!(bound.is_passive(), is_passive, "{b}: {share} of {passive}: {bound:?}");
        }
    }
    assert!(found.tissue[0].passive_n_per_m.is_some());
}

#[test]
fn every_segment_of_the_boundary_of_a_map_lies_on_a_change_of_the_verdict() {
    let axis = |parameter, low, high| Axis { parameter, low, high, count: 14, spacing: Spacing::Logarithmic };
    let x = axis(Parameter::ForceScale, 0.1, 10.0);
    let y = axis(Parameter::Stiffness, 30.0, 5000.0);
    for case in [LOOPS[0], LOOPS[3], LOOPS[6]] {
        let settings = settings(&split(case));
        let map = trocar::stability::map(&settings, x, y).expect("mapped");
        let share = map.stable_share();
        assert!(share > 0.2 && share < 0.95 && !map.boundary.is_empty(), "{case:?}: {share}");
        for end in map.boundary.iter().flatten() {
            let stable = |factor: f64| {
                let there = settings.with(x.parameter, end.0 * factor).with(y.parameter, end.1 * factor);
                ClosedLoop::new(&there).expect("built").is_stable().expect("counted")
            };
            assert!(stable(0.999) && !stable(1.001), "{end:?}");
        }
    }
}

#[test]
fn the_command_writes_its_files_and_refuses_invalid_axes() {
    let folder = crate::support::test_folder::TestFolder::new();
    let small = ["--x", "channel.delay_s=0:0.1:12", "--y", "scaling.force=0.1:10:10:log"];
    let printed =
        folder.good(&[&["stability", "builtin:passivity/late-wall.toml"][..], &small, &["--simulate"]].concat());
    for phrase in ["late-wall: not stable", "spectral radius", "907.5", "delay_s by scaling.force", "all 120 points"] {
        assert!(printed.contains(phrase), "no {phrase:?} in\n{printed}");
    }
    let names = ["stability.json", "stability_map.csv", "stability_boundary.csv", "sensitivities.csv", "ports.csv"];
    for name in names.into_iter().chain(["stability.svg", "stability.png", "ports.svg", "ports.png"]) {
        assert!(folder.path("out/late-wall").join(name).is_file(), "{name}");
    }
    assert_eq!(folder.text("out/late-wall/stability_map.csv").lines().count(), 121);
    let more = ["--z-width", "0:10:5", "--locus", "channel.delay_s=0:0.1:5"];
    let json = folder.json(&[&["stability", "builtin:passivity/late-wall.toml", "--json"][..], &small, &more].concat());
    assert_eq!(json["is_stable"], false);
    assert_eq!(json["z_width"]["tissue"].as_array().map(Vec::len), Some(5));
    for name in ["z_width.csv", "z_width.png", "locus.csv", "locus.png"] {
        assert!(folder.path("out/late-wall").join(name).is_file(), "{name}");
    }
    folder.refused(&["stability", "--z-width", "0:10"], &["LOW:HIGH:COUNT"]);
    assert_eq!(json["limits"][2]["parameter"], "tissue.stiffness_n_per_m");
    for (axis, phrase) in [("scaling.fore=1:2:3", "scaling.force"), ("tissue.stiffness_n_per_m=1:2:3", "differ")] {
        folder.refused(&["stability", "--x", axis], &[phrase]);
    }
}

/// Returns a loop with a hand that is a damper and either a spring or a mass, with the given impedance at a
/// frequency. A mass is added to the master in front of the damper.
fn hand(settings: &LinearLoop, impedance: Complex64, frequency_hz: f64) -> LinearLoop {
    let omega = std::f64::consts::TAU * frequency_hz;
    let mut held = settings.clone();
    // The spring and damper of the hand end at the ground, which is a fixed mass.
    held.arm.b_a_n_s_per_m = impedance.re;
    held.arm.k_a_n_per_m = (-impedance.im * omega).max(0.0);
    held.arm.m_h_kg = 1.0;
    held.arm.k_h_n_per_m = 1e8;
    held.arm.b_h_n_s_per_m = 1e4;
    let mass_kg = (impedance.im / omega).max(0.0);
    held.with(Parameter::MasterMass, settings.master.mass_kg + mass_kg)
}

#[test]
fn oracle_a_hand_with_less_than_the_needed_damping_oscillates() {
    for (delay, integral) in [("0.02", "0"), ("0.05", "0"), ("0.02", "6"), ("0.005", "12")] {
        let delays = [format!("channel.forward_delay_s={delay}"), format!("channel.backward_delay_s={delay}")];
        let integral = format!("master.force_integral_gain={integral}");
        let settings = settings(&[&delays[0], &delays[1], &integral, "tissue.damping_n_s_per_m=2"]);
        let (k, b) = (600.0, 2.0);
        let all = terminations(0.0, (k, k), (b, b));
        let most = Bounded::of(&settings, &all).expect("analysed").most().expect("a two-port");
        assert!(most.damping_n_s_per_m > 1.0 && most.damping_n_s_per_m < 1e4, "{most:?}");
        let omega = std::f64::consts::TAU * most.frequency_hz;
        let hybrid = Ports::new(&settings).expect("built").at(omega).expect("computed").expect("a matrix");
        let transmitted = hybrid.transmitted(Complex64::new(b, -k / omega));
        assert!((transmitted.re + most.damping_n_s_per_m).abs() < 1e-6 * most.damping_n_s_per_m, "{transmitted}");
        let at = |share: f64| {
            let impedance = Complex64::new(-share * transmitted.re, -transmitted.im);
            let held = hand(&settings.with(Parameter::Stiffness, k), impedance, most.frequency_hz);
            ClosedLoop::new(&held).expect("built").dominant_mode().expect("computed")
        };
        if transmitted.im > 0.0 {
            // The hand is a spring. With a mass, the force integral would get the force that the mass takes.
            assert!(at(0.97).spectral_radius > 1.0, "{delay} {most:?}");
            assert!(at(1.03).spectral_radius < 1.0, "{delay} {most:?}");
            assert!((at(1.0).frequency_hz / most.frequency_hz - 1.0).abs() < 0.02, "{delay} {most:?}");
        }
    }
}

#[test]
fn every_hand_with_the_needed_damping_is_stable_with_every_tissue_of_the_range() {
    let settings = settings(&["channel.forward_delay_s=0.01", "channel.backward_delay_s=0.01"]);
    let all = terminations(0.0, (50.0, 600.0), (0.0, 10.0));
    let needed = Bounded::of(&settings, &all).expect("analysed").needed_damping().expect("a two-port");
    assert!(needed.is_finite());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (mut counts, mut softer_and_unstable) = ([0, 0], 0);
    for _ in 0..400 {
        let mut between = |low: f64, high: f64| low * (high / low).powf(rng.random_range(0.0..1.0));
        let mut other = settings.clone();
        other.arm.k_a_n_per_m = between(1.0, 1e4);
        other.arm.b_a_n_s_per_m = between(0.3, 8.0) * needed;
        other.arm.k_h_n_per_m = between(100.0, 1e6);
        other.arm.b_h_n_s_per_m = between(10.0, 1e4);
        other.arm.m_h_kg = between(0.1, 10.0);
        other.stiffness_n_per_m = between(50.0, 600.0);
        other.damping_n_s_per_m = between(0.01, 10.0);
        let least = (0..400)
            .map(|k| arm_impedance(&other.arm, 0.1 * 2500.0_f64.powf(f64::from(k) / 399.0)).re)
            .fold(f64::INFINITY, f64::min);
        let is_stable = ClosedLoop::new(&other).expect("built").is_stable().expect("computed");
        let has_enough = least >= needed;
        counts[usize::from(has_enough)] += 1;
        assert!(is_stable || !has_enough, "{:?} {} {needed}", other.arm, other.stiffness_n_per_m);
        softer_and_unstable += usize::from(!is_stable);
    }
    assert!(counts.iter().all(|count| *count > 50) && softer_and_unstable > 5, "{counts:?} {softer_and_unstable}");
}

#[test]
fn a_longer_delay_needs_a_hand_with_more_damping() {
    let axis = Axis { parameter: Parameter::Delay, low: 0.0, high: 0.05, count: 6, spacing: Spacing::Linear };
    let over = |hand: f64| {
        AbsoluteOver::of(&settings(&[]), &axis, &terminations(hand, (50.0, 600.0), (0.0, 0.0)))
            .expect("analysed")
            .points
    };
    let all = over(0.0);
    let needed: Vec<f64> = all.iter().map(|point| point.bounded.most().expect("known").damping_n_s_per_m).collect();
    assert!(needed.windows(2).all(|pair| pair[1] > pair[0]), "{needed:?}");
    assert!(all.iter().all(|point| point.min_llewellyn < 1.0 && !point.is_absolutely_stable));
    // Hands of a bounded range need no more than all hands, and exactly as much as the range's minimum allows.
    assert!(over(1.01 * needed[5]).iter().all(|point| point.bounded.is_stable() == Some(true)));
}
