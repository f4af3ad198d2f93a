//! Tissues, arms and masters with known parameters are identified from simulated and from real recordings.

use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};
use trocar_identify::{IdentifyError, Part, PartColumns, PartIdentification, PartRequest, Signals, identify_part};
use trocar_recording::{Column, Limits};

const INTERVAL_S: f64 = 1e-3;
const SAMPLES: usize = 5000;

/// Steps of a simulation per sample.
const STEPS: usize = 100;

/// Step of the encoders in m, and noise of the force sensor in N.
const ENCODER_M: f64 = 2e-6;
const NOISE_N: f64 = 0.01;

/// Returns the encoder's positions and the noisy forces of exact ones.
fn measured(part: Part, positions: &[f64], forces: &[f64], input: Option<Vec<f64>>) -> Signals {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let noise = Normal::new(0.0, NOISE_N).expect("positive");
    let position_m = positions.iter().map(|x| (x / ENCODER_M).round() * ENCODER_M).collect();
    let force_n = forces.iter().map(|force_n| force_n + noise.sample(&mut random)).collect();
    Signals::new("synthetic", part, INTERVAL_S, position_m, force_n, input).expect("a recording")
}

fn identified(part: Part, training: Vec<Signals>) -> PartIdentification {
    identify_part(part, PartRequest { training, predictions: vec![] }, |_, _| ()).expect("a part")
}

/// Checks that a value is within a tolerance of the truth, and that the truth is within twice the interval: 95 %
/// intervals may miss it.
fn assert_found(found: &PartIdentification, key: &str, truth: f64, tolerance: f64) {
    let (value, [low, high]) = found.parameter(key).unwrap_or_else(|| panic!("{key} in {}", found.structure));
    assert!((value - truth).abs() <= tolerance * truth.abs(), "{key} is {value} [{low}, {high}], truth {truth}");
    let half = 0.5 * (high - low);
    assert!((low - half..=high + half).contains(&truth), "{key} is {value} [{low}, {high}], truth {truth}");
}

fn place_m(t_s: f64) -> f64 {
    0.008 * (5.0 * t_s).sin() + 0.003 * (13.0 * t_s + 1.0).sin() + 0.0008 * (37.0 * t_s).sin()
}

/// A needle in a tissue with a force of depth, velocity and travel.
fn insertion(mut force_n: impl FnMut(f64, f64, f64) -> f64) -> Signals {
    let mut forces = vec![];
    let mut positions = vec![];
    let step_s = INTERVAL_S / STEPS as f64;
    for k in 0..SAMPLES * STEPS {
        let t_s = k as f64 * step_s;
        let (before_m, here_m, next_m) = (place_m(t_s - step_s), place_m(t_s), place_m(t_s + step_s));
        let force_n = force_n(here_m, (next_m - before_m) / (2.0 * step_s), here_m - before_m);
        if k % STEPS == 0 {
            positions.push(here_m);
            forces.push(force_n);
        }
    }
    measured(Part::Tissue, &positions, &forces, None)
}

#[test]
fn the_power_of_the_depth_is_found() {
    let (mu, lambda, power, contact_m) = (20_000.0, 60_000.0, 1.5, -0.001);
    let training = insertion(|x, v, _| (x - contact_m).max(0.0_f64).powf(power) * (mu + lambda * v) + 0.1);
    let found = identified(Part::Tissue, vec![training]);
    assert_eq!(found.structure, "hunt-crossley");
    for (key, truth) in [("power", power), ("mu", mu), ("contact_m", contact_m), ("force_zero_n", 0.1)] {
        assert_found(&found, key, truth, 0.05);
    }
    let text = found.scenario();
    assert!(text.contains("kind = \"hunt-crossley\"") && text.contains("power = 1.5\n"), "{text}");
}

#[test]
fn friction_of_the_shaft_is_told_from_damping() {
    let mut grip_n = 0.0_f64;
    let training = insertion(|x, v, moved_m| {
        grip_n = if x > 0.0 { (grip_n + 3000.0 * moved_m).clamp(-0.4, 0.4) } else { 0.0 };
        if x > 0.0 { 500.0 * x + 5.0 * v + grip_n } else { 0.0 }
    });
    let found = identified(Part::Tissue, vec![training]);
    assert_eq!(found.structure, "kelvin-voigt-friction");
    assert_found(&found, "stiffness_n_per_m", 500.0, 0.03);
    assert_found(&found, "damping_n_s_per_m", 5.0, 0.05);
    assert_found(&found, "grip_n", 0.4, 0.05);
}

#[test]
fn forces_that_fall_with_the_depth_are_no_tissue() {
    let training = vec![insertion(|x, _, _| -500.0 * x.max(0.0))];
    let error = identify_part(Part::Tissue, PartRequest { training, predictions: vec![] }, |_, _| ()).expect_err("no");
    assert!(matches!(error, IdentifyError::Unexplained { .. }), "{error}");
}

/// The paper's arm, whose hand is moved by a perturbation with these frequencies in rad/s.
fn perturbed_arm(frequencies: &[f64]) -> Signals {
    let [k_a, b_a, k_h, b_h, mass] = [733.0, 37.3, 14_998.0, 178.0, 1.88];
    let wave =
        |t_s: f64| -> f64 { frequencies.iter().map(|rate| 0.01 / (1.0 + 0.02 * rate) * (rate * t_s).sin()).sum() };
    let step_s = INTERVAL_S / STEPS as f64;
    let (mut positions, mut forces) = (vec![], vec![]);
    let (mut arm_m, mut velocity) = (0.0_f64, 0.0_f64);
    // The recording begins after a second, when the transient has decayed.
    let before = 1000 * STEPS;
    for k in 0..before + SAMPLES * STEPS {
        let t_s = k as f64 * step_s;
        let (hand_m, rate) = (wave(t_s), (wave(t_s + step_s) - wave(t_s - step_s)) / (2.0 * step_s));
        let force_n = k_a * (arm_m - hand_m) + b_a * (velocity - rate);
        if k >= before && k % STEPS == 0 {
            positions.push(hand_m);
            forces.push(force_n);
        }
        velocity += step_s * (-k_h * arm_m - b_h * velocity - force_n) / mass;
        arm_m += step_s * velocity;
    }
    measured(Part::Arm, &positions, &forces, None)
}

#[test]
fn fast_perturbations_tell_the_two_springs_of_an_arm_apart() {
    let found = identified(Part::Arm, vec![perturbed_arm(&[3.0, 7.0, 17.0, 31.0, 53.0, 79.0, 101.0, 127.0])]);
    assert_eq!(found.structure, "two-springs");
    for (key, truth) in [("k_a_n_per_m", 733.0), ("b_a_n_s_per_m", 37.3), ("k_h_n_per_m", 14_998.0), ("m_h_kg", 1.88)] {
        assert_found(&found, key, truth, 0.05);
    }
    assert!(found.scenario().contains("k_h_n_per_m = "), "{}", found.scenario());
}

#[test]
fn slow_perturbations_give_the_static_stiffness_of_an_arm() {
    let found = identified(Part::Arm, vec![perturbed_arm(&[1.0, 2.3, 3.7])]);
    assert_ne!(found.structure, "two-springs");
    let series = 733.0 * 14_998.0 / (733.0 + 14_998.0);
    let (value, _) = found.parameter("static_stiffness_n_per_m").expect("a stiffness");
    assert!((value / series - 1.0).abs() < 0.03, "{value} against {series}");
}

/// A master with friction between a hand and a motor that acts 4 ms late.
#[test]
fn mass_friction_constant_force_and_delay_of_a_master_are_found() {
    let (mass, viscous, coulomb_n, constant_n, delay_s) = (0.3, 2.0, 0.4, -0.2, 4e-3);
    let step_s = INTERVAL_S / STEPS as f64;
    let late = (delay_s / step_s).round() as usize;
    let (mut positions, mut hands, mut motors, mut commands) = (vec![], vec![], vec![], vec![]);
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    for k in 0..SAMPLES * STEPS {
        let t_s = k as f64 * step_s;
        let hand_n = 300.0 * (place_m(t_s) - x) - 10.0 * v;
        commands.push(-100.0 * x + 0.5 * (40.0 * t_s).sin());
        let other_n = hand_n + commands[k.saturating_sub(late)] + constant_n;
        if k % STEPS == 0 {
            positions.push(x);
            hands.push(hand_n);
            motors.push(commands[k]);
        }
        let impulse_n = mass / step_s * v + other_n;
        let remaining_n = impulse_n - impulse_n.clamp(-coulomb_n, coulomb_n);
        v = remaining_n / (mass / step_s + viscous);
        x += step_s * v;
    }
    let found = identified(Part::Master, vec![measured(Part::Master, &positions, &hands, Some(motors))]);
    assert_eq!(found.structure, "coulomb-delay");
    for (key, truth, tolerance) in [
        ("mass_kg", mass, 0.05),
        ("viscous_n_s_per_m", viscous, 0.1),
        ("coulomb_n", coulomb_n, 0.05),
        ("constant_force_n", constant_n, 0.05),
        ("motor_delay_s", delay_s, 0.1),
    ] {
        assert_found(&found, key, truth, tolerance);
    }
    let text = found.scenario();
    assert!(text.contains("model = \"mass-damper\"") && text.contains("constant_force_n = -0.2"), "{text}");
}

/// Opens a recording of a lever of 0.075 m.
fn lever(path: &str, torque: &str) -> Signals {
    let column = |name: &str, scale: f64| Column::new(name, scale).expect("a column");
    let columns = PartColumns {
        time: column("t_s", 1.0),
        position: column("xs_rad", 0.075),
        force: column(torque, 1.0 / 0.075),
        input: None,
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    Signals::open(&path, Part::Tissue, &columns, &Limits::default()).expect("a recording")
}

#[test]
fn oracle_the_virtual_layer_has_3000_n_per_m_and_40_n_s_per_m_up_to_its_rupture() {
    let recording = lever("scenarios/recordings/own_ctrl_pop.csv", "env_out_Nm_derived");
    let found = identified(Part::Tissue, vec![recording]);
    assert_eq!(found.structure, "kelvin-voigt");
    for (key, truth) in [("stiffness_n_per_m", 3000.0), ("damping_n_s_per_m", 40.0)] {
        let (value, [low, high]) = found.parameter(key).expect("a parameter");
        assert!((low..=high).contains(&truth), "{key} is {value} [{low}, {high}], truth {truth}");
        assert!((value / truth - 1.0).abs() < 0.1, "{key} is {value}, truth {truth}");
    }
    // The label is sample 3558, the last one under load.
    let samples = found.fits[0].signals.len() as i64;
    assert!((samples - 3559).abs() <= 2, "{samples}");
}

#[test]
fn oracle_the_spring_has_610_to_707_n_per_m() {
    let found = identified(Part::Tissue, vec![lever("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm")]);
    let (value, [low, high]) = found.parameter("stiffness_n_per_m").expect("a stiffness");
    assert!(low <= 707.0 && high >= 610.0 && (580.0..740.0).contains(&value), "{value} [{low}, {high}]");
}

#[test]
fn an_identification_is_deterministic_and_needs_training() {
    let twice = [(); 2].map(|()| identified(Part::Arm, vec![perturbed_arm(&[3.0, 20.0])]));
    assert_eq!(twice[0], twice[1]);
    let nothing = PartRequest { training: vec![], predictions: vec![] };
    assert!(matches!(identify_part(Part::Arm, nothing, |_, _| ()), Err(IdentifyError::NoTraining)));
}

#[test]
fn recordings_without_excitation_or_of_unequal_lengths_are_refused() {
    let wave: Vec<f64> = (0..400).map(|k| (0.02 * f64::from(k)).sin()).collect();
    let refused = |part, position: &[f64], force: &[f64], input: Option<Vec<f64>>| {
        let new = Signals::new("a.csv", part, 1e-3, position.to_vec(), force.to_vec(), input);
        new.expect_err("refused").to_string()
    };
    for part in [Part::Tissue, Part::Arm, Part::Master] {
        assert!(refused(part, &[0.1; 400], &wave, None).contains("does not move"));
        assert!(refused(part, &wave, &[2.0; 400], None).contains("the force does not change"));
        assert!(refused(part, &wave, &wave[..300], None).contains("the force has 300 values and the time has 400"));
        assert!(refused(part, &wave[..100], &wave[..100], None).contains("100 samples"));
        let mut wild = wave.clone();
        wild[3] = f64::NAN;
        assert!(refused(part, &wave, &wild, None).contains("NaN at sample 3"));
    }
    let desired = Some(vec![0.0; 7]);
    assert!(refused(Part::Arm, &wave, &wave, desired.clone()).contains("the desired position has 7 values"));
    assert!(refused(Part::Master, &wave, &wave, desired).contains("the actuator's force has 7 values"));
}
