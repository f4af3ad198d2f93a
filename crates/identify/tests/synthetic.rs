//! Machines with known parameters are identified from simulated recordings.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};
use trocar_identify::{IdentifyError, Load, Machine, Measured, Request, Role, Structure, identify};

const INTERVAL_S: f64 = 1e-3;
const SAMPLES: usize = 5000;

/// Standard deviation of the position's noise in m.
const NOISE_M: f64 = 5e-6;

/// Step of the encoders in m.
const ENCODER_M: f64 = 2e-6;

const TRUTH: Machine = Machine {
    mass_kg: 0.25,
    viscous_n_s_per_m: 4.0,
    coulomb_n: 0.4,
    position_gain_n_per_m: 3000.0,
    velocity_gain_n_s_per_m: 20.0,
    delay_s: 0.0,
    load: Load { scale: 0.9, scaled_up_to_n: f64::INFINITY, offset_n: 0.1, lag_s: 0.0 },
};

/// Simulates a recording in free motion or against a spring of 300 N/m, with noise of the positions.
fn recording(name: &str, seed: u64, has_contact: bool, has_actuator: bool) -> Measured {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, NOISE_M).expect("positive");
    let phase = seed as f64;
    let at = |k: usize| {
        let t = k as f64 * INTERVAL_S;
        0.01 * (7.0 * t + phase).sin() + 0.004 * (17.0 * t).cos() + 0.002 * (31.0 * t + 2.0 * phase).sin()
    };
    let master: Vec<f64> = (0..SAMPLES).map(at).collect();
    let force: Vec<f64> = master.iter().map(|x| if has_contact { 300.0 * x.max(0.0) } else { 0.0 }).collect();
    let new = |master, slave, force, actuator| {
        Measured::new(name, INTERVAL_S, master, slave, force, actuator).expect("a recording")
    };
    let exact = new(master.clone(), master.clone(), force.clone(), None);
    let slave = TRUTH.simulate(&exact, 0.0).expect("finite");
    let difference = |k: usize| master[k] - slave[k];
    let rate = |k: usize| {
        let (from, to) = (k.saturating_sub(1), (k + 1).min(SAMPLES - 1));
        (difference(to) - difference(from)) / ((to - from) as f64 * INTERVAL_S)
    };
    let gains = (TRUTH.position_gain_n_per_m, TRUTH.velocity_gain_n_s_per_m);
    let actuator = has_actuator.then(|| (0..SAMPLES).map(|k| gains.0 * difference(k) + gains.1 * rate(k)).collect());
    let mut noisy = |x: &f64| ((x + normal.sample(&mut random)) / ENCODER_M).round() * ENCODER_M;
    let (master, slave) = (master.iter().map(&mut noisy).collect(), slave.iter().map(&mut noisy).collect());
    new(master, slave, force, actuator)
}

fn request(seed: u64, has_actuator: bool) -> Request {
    let free = recording("free", 100 + seed, false, has_actuator);
    let contact = recording("contact", 200 + seed, true, has_actuator);
    Request { training: vec![free, contact], predictions: vec![recording("other", 300 + seed, true, has_actuator)] }
}

#[test]
fn the_truth_is_within_the_intervals_and_the_gains_are_within_3_percent() {
    let truths = [
        ("mass_kg", TRUTH.mass_kg),
        ("viscous_n_s_per_m", TRUTH.viscous_n_s_per_m),
        ("coulomb_n", TRUTH.coulomb_n),
        ("position_gain_n_per_m", TRUTH.position_gain_n_per_m),
        ("velocity_gain_n_s_per_m", TRUTH.velocity_gain_n_s_per_m),
    ];
    let mut missed = 0;
    for seed in 0..3 {
        let found = identify(request(seed, true), || ()).expect("a machine");
        for (key, truth) in truths {
            let (value, [low, high]) = found.parameter(key).expect("a parameter");
            println!("{seed} {key} {value} [{low}, {high}] truth {truth}");
            missed += usize::from(!(low..=high).contains(&truth));
            let is_gain = key.contains("gain");
            assert!(!is_gain || (value / truth - 1.0).abs() < 0.03, "seed {seed}: {key} is {value}, truth {truth}");
        }
        let predicted = found.mean_fit_percent(Role::Prediction).expect("a prediction");
        assert!(predicted > 99.5, "{predicted}");
    }
    // With 95 % intervals, more than 3 of 15 are missed with a probability of 0.5 %.
    assert!(missed <= 3, "{missed} of 15 intervals miss the truth");
}

#[test]
fn a_zero_that_drifts_from_recording_to_recording_is_found() {
    let drifts_n = [0.2, 0.5, -0.3];
    let mut request = request(5, true);
    let recordings = request.training.iter_mut().chain(&mut request.predictions);
    for (one, drift_n) in recordings.zip(drifts_n) {
        // The sensor also has a ripple, whose range of 0.04 N is how exactly a zero is known.
        let read = |(k, force_n): (usize, &mut f64)| *force_n += drift_n + 0.02 * (0.3 * k as f64).sin();
        one.force_n.iter_mut().enumerate().for_each(read);
    }
    let found = identify(request, || ()).expect("a machine");
    for (fit, drift_n) in found.fits.iter().zip(drifts_n) {
        assert!((fit.sensor_zero_n - drift_n).abs() < 0.04, "{}: {}", fit.measured.name, fit.sensor_zero_n);
    }
    let predicted = found.mean_fit_percent(Role::Prediction).expect("a prediction");
    assert!(predicted > 99.5, "{predicted}");
}

#[test]
fn an_identification_is_deterministic() {
    let twice = [(); 2].map(|()| identify(request(1, false), || ()).expect("a machine"));
    assert_eq!(twice[0], twice[1]);
}

#[test]
fn motion_alone_gives_ratios_per_mass() {
    let training = vec![recording("free", 7, false, false)];
    let found = identify(Request { training, predictions: vec![] }, || ()).expect("a machine");
    assert_eq!(found.structure, Structure::Plain);
    assert_eq!(found.parameter("mass_kg"), Some((1.0, [1.0, 1.0])));
    let (gain, _) = found.parameter("position_gain_n_per_m").expect("a gain");
    let ratio = TRUTH.position_gain_n_per_m / TRUTH.mass_kg;
    assert!((gain / ratio - 1.0).abs() < 0.1, "{gain} against {ratio}");
}

#[test]
fn without_recordings_there_is_nothing_to_train_on() {
    let nothing = Request { training: vec![], predictions: vec![] };
    assert!(matches!(identify(nothing, || ()), Err(IdentifyError::NoTraining)));
}
