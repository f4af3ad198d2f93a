//! Motors with saturation, rate limit and lag, compared with numerical integration, closed forms and motors without
//! limits. Their limits are never exceeded.

use crate::support;
use trocar::engine::{ExactPlants, IntegratedPlants, LimitedPlants, Plants, TissueForce};
use trocar::lane::Lane;
use trocar::metrics::RuptureMetrics;
use trocar::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, Coupling, Damping, MasterParameters, MasterStep, SlaveParameters,
    SlaveStep,
};
use trocar::run::{measure, run};
use trocar::scenario::{Scenario, Source};

#[path = "../../benches/table/counted.rs"]
#[allow(dead_code, reason = "its counts are not used here")]
mod counted;
use counted::Counted;

const TICK_S: f64 = 1e-3;
const TICKS: usize = 800;
const TIGHT: ActuatorLimits =
    ActuatorLimits { master_force_n: Some(1.2), slave_command: Some(0.4), ..ActuatorLimits::NONE };
const LOOSE: ActuatorLimits =
    ActuatorLimits { master_force_n: Some(1e6), slave_command: Some(1e6), ..ActuatorLimits::NONE };

/// Returns `x_d, F_ed, x_ref`: forces up to 3 N that change sign, and steps of the reference.
fn input(k: usize) -> (f64, f64, f64) {
    let t = k as f64 * TICK_S;
    (0.02 * t, 3.0 * (9.0 * t).sin(), if (k / 150).is_multiple_of(2) { 0.002 } else { -0.001 })
}

fn drive(plants: impl Plants<f64>, input: impl Fn(usize) -> (f64, f64, f64)) -> [Vec<f64>; 5] {
    support::drive(plants, TICKS, input)
}

fn difference(a: &[Vec<f64>; 5], b: &[Vec<f64>; 5]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn limited(limits: &ActuatorLimits, coupling: Coupling, damping: Damping) -> LimitedPlants<f64> {
    let master = MasterParameters { coupling, ..MasterParameters::default() };
    let slave = SlaveParameters { damping, ..SlaveParameters::default() };
    LimitedPlants::new((&master, &ArmParameters::default(), &slave), limits, TICK_S, 0.0, 0.0).expect("valid")
}

fn integrated(limits: &ActuatorLimits, damping: Damping) -> IntegratedPlants {
    let slave = SlaveParameters { damping, ..SlaveParameters::default() };
    let machines = (&MasterParameters::default(), &ArmParameters::default(), &slave);
    IntegratedPlants::new(machines, ControlTiming::Sampled, TICK_S, 0.0, 0.0).limited(limits)
}

fn unlimited(damping: Damping) -> ExactPlants<f64> {
    let (timing, slave) = (ControlTiming::Sampled, SlaveParameters { damping, ..SlaveParameters::default() });
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&slave, timing, TICK_S);
    ExactPlants::new(&master.expect("valid"), &slave.expect("valid"), 0.0, 0.0)
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

/// All limits of both plants together, and each is reached: the range, the rate and a lag of some ticks.
const ALL: ActuatorLimits = ActuatorLimits {
    master_force_n: Some(1.2),
    slave_command: Some(0.4),
    master_force_rate_n_per_s: Some(20.0),
    slave_command_rate_per_s: Some(15.0),
    master_lag_s: 4e-3,
    slave_lag_s: 2.5e-3,
};

#[test]
fn range_rate_and_lag_agree_with_numerical_integration() {
    let of_each_side = [
        ALL,
        TIGHT,
        ActuatorLimits { master_lag_s: 0.0, slave_command_rate_per_s: None, ..ALL },
        ActuatorLimits { slave_lag_s: 0.0, master_force_rate_n_per_s: None, ..ALL },
        // Lags far shorter than the tick and far longer.
        ActuatorLimits { master_lag_s: 5e-6, slave_lag_s: 30.0, ..ActuatorLimits::NONE },
        ActuatorLimits { master_lag_s: 30.0, slave_lag_s: 5e-6, ..ActuatorLimits::NONE },
    ];
    for damping in [Damping::Velocity, Damping::AsPrinted] {
        for limits in of_each_side {
            let exact = drive(limited(&limits, Coupling::Physical, damping), input);
            let error = difference(&exact, &drive(integrated(&limits, damping), input));
            assert!(error < 1e-8, "{damping:?} {limits:?}: {error:e}");
        }
        // Each limit affects its own side.
        let exact = drive(limited(&ALL, Coupling::Physical, damping), input);
        for (without, columns) in [
            (ActuatorLimits { master_force_n: None, ..ALL }, 0..3),
            (ActuatorLimits { master_force_rate_n_per_s: None, ..ALL }, 0..3),
            (ActuatorLimits { master_lag_s: 0.0, ..ALL }, 0..3),
            (ActuatorLimits { slave_command: None, ..ALL }, 3..5),
            (ActuatorLimits { slave_command_rate_per_s: None, ..ALL }, 3..5),
            (ActuatorLimits { slave_lag_s: 0.0, ..ALL }, 3..5),
        ] {
            let other = drive(limited(&without, Coupling::Physical, damping), input);
            for column in columns {
                assert!(difference_of(&exact[column], &other[column]) > 1e-5, "{damping:?} {without:?} {column}");
            }
        }
    }
}

/// Returns plants with closed forms: a master of 1 kg without damping and without a hand, and a given slave.
fn simple(slave: &SlaveParameters, limits: &ActuatorLimits) -> LimitedPlants<f64> {
    let master = MasterParameters { mass_kg: 1.0, damping_n_s_per_m: 0.0, ..MasterParameters::default() };
    let arm = ArmParameters { k_a_n_per_m: 0.0, b_a_n_s_per_m: 0.0, ..ArmParameters::default() };
    LimitedPlants::new((&master, &arm, slave), limits, TICK_S, 0.0, 0.0).expect("valid")
}

/// Returns a slave `2 / ((s + 2) (s + 30))` with so high a gain that its command stays at the limit.
fn overdriven() -> SlaveParameters {
    SlaveParameters {
        numerator: vec![2.0],
        denominator: vec![1.0, 32.0, 60.0],
        proportional_gain: 1e6,
        velocity_gain: 0.0,
        damping: Damping::Velocity,
        ..SlaveParameters::default()
    }
}

/// Returns a slave `1 / s²`, whose velocity changes by the mean of its command over the tick.
fn free_mass(proportional_gain: f64) -> SlaveParameters {
    SlaveParameters { numerator: vec![1.0], denominator: vec![1.0, 0.0, 0.0], proportional_gain, ..overdriven() }
}

#[test]
fn the_step_response_of_a_lagging_slave_agrees_with_partial_fractions() {
    for lag_s in [1e-5, 7e-4, 0.02, 5.0] {
        let limits = ActuatorLimits { slave_command: Some(3.0), slave_lag_s: lag_s, ..ActuatorLimits::NONE };
        let [.., position, velocity] = drive(simple(&overdriven(), &limits), |_| (0.0, 0.0, 1.0));
        // 3 · 2 / (s (s + 2) (s + 30) (τ s + 1)) has one residue per pole.
        let poles = [0.0, -2.0, -30.0, -1.0 / lag_s];
        let residue = |p: f64| poles.iter().filter(|&&q| q != p).fold(6.0 / lag_s, |product, q| product / (p - q));
        for k in 0..TICKS {
            let t = k as f64 * TICK_S;
            let x: f64 = poles.iter().map(|&p| residue(p) * (p * t).exp()).sum();
            let v: f64 = poles.iter().map(|&p| residue(p) * p * (p * t).exp()).sum();
            assert!((position[k] - x).abs() < 1e-12, "{lag_s} {k}: {} {x}", position[k]);
            assert!((velocity[k] - v).abs() < 1e-11, "{lag_s} {k}: {} {v}", velocity[k]);
        }
        assert!(position[TICKS - 1] > 1e-3, "{lag_s}");
    }
}

/// Returns the force on a mass of 1 kg over each tick, from its velocity.
fn pushes(velocity: &[f64]) -> Vec<f64> {
    velocity.windows(2).map(|pair| (pair[1] - pair[0]) / TICK_S).collect()
}

#[test]
fn no_command_changes_faster_than_its_rate() {
    let limits = ActuatorLimits {
        master_force_rate_n_per_s: Some(20.0),
        slave_command_rate_per_s: Some(10.0),
        ..ActuatorLimits::NONE
    };
    let [_, master_velocity, _, _, slave_velocity] = drive(simple(&free_mass(300.0), &limits), input);
    for (velocity, per_tick) in [(master_velocity, 0.02), (slave_velocity, 0.01)] {
        let steps: Vec<f64> = pushes(&velocity).windows(2).map(|pair| pair[1] - pair[0]).collect();
        let largest = steps.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
        assert!((largest - per_tick).abs() < 1e-9, "{largest} of {per_tick}");
        let (up, down) =
            (steps.iter().any(|&step| step > 0.99 * per_tick), steps.iter().any(|&step| step < -0.99 * per_tick));
        assert!(up && down, "{per_tick} is reached either way");
    }
    // Towards a distant command, every tick changes by the maximum, until the range is reached.
    let limits = ActuatorLimits { slave_command: Some(1.5), ..limits };
    let [.., velocity] = drive(simple(&free_mass(1e6), &limits), |_| (0.0, 0.0, 10.0));
    for (k, push) in pushes(&velocity).into_iter().enumerate() {
        let expected = (0.01 * (k + 1) as f64).min(1.5);
        assert!((push - expected).abs() < 1e-9, "{k}: {push} {expected}");
    }
}

#[test]
fn the_master_leaves_a_limit_as_soon_as_the_error_changes_sign() {
    const OVERLOAD: usize = 500;
    let turning = |k: usize| (0.0, if k < OVERLOAD { 4.0 } else { -0.5 }, 0.0);
    let motor = |limits: &ActuatorLimits| -> Vec<f64> {
        let [_, velocity, ..] = drive(simple(&free_mass(0.0), limits), turning);
        pushes(&velocity).into_iter().map(|push| -push).collect()
    };
    // No hand holds this master, so F_ed is the whole error. With windup, the integral would have added 12 · 4 N ·
    // 0.5 s = 24 N, and at -0.5 N it would have kept the motor at its limit for the rest of the run.
    let at =
        |k: usize, motor_n: f64, expected: f64| assert!((motor_n - expected).abs() < 1e-9, "{k}: {motor_n} {expected}");
    let ranged = motor(&ActuatorLimits { master_force_n: Some(1.2), ..ActuatorLimits::NONE });
    let rated = motor(&ActuatorLimits {
        master_force_n: Some(1.2),
        master_force_rate_n_per_s: Some(10.0),
        ..ActuatorLimits::NONE
    });
    for (k, (&ranged, &rated)) in ranged.iter().zip(&rated).enumerate() {
        // After the overload the integral starts from 0: first -0.5 N, then K_i T of it more each tick, down to the
        // limit.
        let after = |k: usize| (-0.5 * (1.0 + 12.0 * TICK_S * (k - OVERLOAD) as f64)).max(-1.2);
        at(k, ranged, if k < OVERLOAD { 1.2 } else { after(k) });
        if k < OVERLOAD {
            at(k, rated, (0.01 * (k + 1) as f64).min(1.2));
        } else {
            // While the motor force falls and exceeds the command, the integral is constant.
            at(k, rated, (1.2 - 0.01 * (k + 1 - OVERLOAD) as f64).max(rated_end(k - OVERLOAD)));
        }
    }
    // Without a range, only the rate limits the integral. The motor reverses at this tick.
    let rate_alone = motor(&ActuatorLimits { master_force_rate_n_per_s: Some(10.0), ..ActuatorLimits::NONE });
    let (before, turned) = (rate_alone[OVERLOAD - 1], rate_alone[OVERLOAD]);
    assert!(before > 4.0, "{before}: the overload was followed");
    at(OVERLOAD, turned, before - 0.01);
}

/// Returns the motor force of the case above after it reaches the command. `k` counts the ticks after the turn; the
/// motor needs 170 ticks of 0.01 N.
fn rated_end(k: usize) -> f64 {
    const DOWN: usize = 169;
    (-0.5 * (1.0 + 12.0 * TICK_S * k.saturating_sub(DOWN) as f64)).max(-1.2)
}

#[test]
fn a_limit_out_of_range_is_refused() {
    for limits in [
        ActuatorLimits { master_force_n: Some(0.0), ..ActuatorLimits::NONE },
        ActuatorLimits { slave_command: Some(f64::NAN), ..ActuatorLimits::NONE },
        ActuatorLimits { master_force_rate_n_per_s: Some(0.0), ..ActuatorLimits::NONE },
        ActuatorLimits { slave_command_rate_per_s: Some(f64::INFINITY), ..ActuatorLimits::NONE },
        ActuatorLimits { master_lag_s: -1e-3, ..ActuatorLimits::NONE },
        ActuatorLimits { slave_lag_s: f64::NAN, ..ActuatorLimits::NONE },
    ] {
        assert!(limits.validate().is_err(), "{limits:?}");
    }
}

#[test]
fn lanes_are_identical_bit_for_bit_to_single_runs() {
    let machines = (&MasterParameters::default(), &ArmParameters::default(), &SlaveParameters::default());
    let mut together = LimitedPlants::<Counted<2>>::new(machines, &ALL, TICK_S, 0.0, 0.0).expect("valid");
    let mut alone = [(); 2].map(|()| limited(&ALL, Coupling::Physical, Damping::Velocity));
    for k in 0..TICKS {
        let [now, next] = [k, k + 1].map(|k| [input(k), input(k + 70)]);
        let (master, slave) = (together.master(), together.slave());
        for (lane, one) in alone.iter_mut().enumerate() {
            let (m, s) = (one.master(), one.slave());
            let wide = [master.position_m, master.hand_force_n, slave.position_m, slave.velocity_m_per_s];
            let single = [m.position_m, m.hand_force_n, s.position_m, s.velocity_m_per_s];
            assert_eq!(wide.map(|value| value.lane(lane).to_bits()), single.map(f64::to_bits), "{lane} {k}");
            let (desired, feedback, reference) = now[lane];
            one.step(desired, next[lane].0, feedback, reference, 0.0, TissueForce::zero()).expect("steps");
        }
        let [desired, desired_next, feedback, reference] = [
            Counted::from_lanes(|lane| now[lane].0),
            Counted::from_lanes(|lane| next[lane].0),
            Counted::from_lanes(|lane| now[lane].1),
            Counted::from_lanes(|lane| now[lane].2),
        ];
        let none = Counted::splat(0.0);
        together.step(desired, desired_next, feedback, reference, none, TissueForce::zero()).expect("steps");
    }
}

#[test]
fn a_slave_held_at_rest_stays_at_rest() {
    // A slave with a spring needs a command even at rest, which its motor must have from the start.
    let slave = SlaveParameters { proportional_gain: 500.0, ..overdriven() };
    let machines = (&MasterParameters::default(), &ArmParameters::default(), &slave);
    let limits = ActuatorLimits { slave_lag_s: 0.05, slave_command_rate_per_s: Some(1.0), ..ActuatorLimits::NONE };
    let exact = LimitedPlants::<f64>::new(machines, &limits, TICK_S, 0.0, 0.01).expect("valid");
    let integrated = IntegratedPlants::new(machines, ControlTiming::Sampled, TICK_S, 0.0, 0.01).limited(&limits);
    let rest = 0.01 * 1000.0 / 1060.0;
    for columns in [drive(exact, |_| (0.0, 0.0, 0.01)), drive(integrated, |_| (0.0, 0.0, 0.01))] {
        assert!(columns[3].iter().all(|x| (x - rest).abs() < 1e-12), "{:?}", columns[3].last());
    }
}

#[test]
fn a_weak_and_slow_master_delays_the_felt_rupture_and_the_needle_moves_faster() {
    let skin = |settings: &[&str]| {
        measure(&support::scenario("link/saturating-master", settings)).expect("runs").ruptures[0].clone()
    };
    let strong = "actuator.master_force_limit_n=1e6";
    let weak_and_slow = skin(&[]);
    let weak = skin(&["actuator.master_lag_s=0"]);
    let slow = skin(&[strong]);
    let able = skin(&[strong, "actuator.master_lag_s=0"]);
    let fall = |rupture: &RuptureMetrics| rupture.felt_fall_s.expect("felt");
    assert!(fall(&weak) > fall(&able) + 0.025, "{} {}", fall(&weak), fall(&able));
    assert!(fall(&weak_and_slow) > fall(&weak) + 0.005 && fall(&slow) > fall(&able) + 0.005);
    let overshoot = |rupture: &RuptureMetrics| rupture.slave_overshoot_m.expect("ruptured");
    assert!(overshoot(&weak_and_slow) > 1.5 * overshoot(&able), "{} {}", overshoot(&weak_and_slow), overshoot(&able));
    assert!(weak_and_slow.time_s < able.time_s - 0.1, "the skin gives way earlier");
}

#[test]
fn motors_with_any_limits_give_finite_values() {
    let base = [
        "simulation.control=sampled",
        "simulation.duration_s=0.1",
        "operator.kind=ramp",
        "operator.speed_m_per_s=0.1",
        "tissue.kind=kelvin-voigt",
    ];
    let lags = ["0", "1e-320", "1e-12", "1e-6", "1e-3", "1", "1e12"];
    let limits = ["1e-12", "1e-3", "1", "1e12"];
    for (i, lag) in lags.iter().enumerate() {
        for (j, range) in limits.iter().enumerate() {
            for rate in limits {
                // The limits of the other side differ, so that all combinations occur.
                let (other_lag, other) = (lags[(i + j) % lags.len()], limits[(i + j) % limits.len()]);
                let settings: Vec<String> = base
                    .iter()
                    .map(|&setting| setting.to_owned())
                    .chain([
                        format!("actuator.master_lag_s={lag}"),
                        format!("actuator.slave_lag_s={other_lag}"),
                        format!("actuator.master_force_limit_n={range}"),
                        format!("actuator.slave_command_limit={other}"),
                        format!("actuator.master_force_rate_limit_n_per_s={rate}"),
                        format!("actuator.slave_command_rate_limit_per_s={range}"),
                    ])
                    .collect();
                let scenario =
                    Scenario::load(&Source::parse("builtin:paper/classical.toml"), &settings).expect("loads");
                let run = run(scenario).expect("runs");
                let finite = run.trace.numbers().iter().all(|column| column.iter().all(|value| value.is_finite()));
                assert!(finite, "{settings:?}");
            }
        }
    }
}
