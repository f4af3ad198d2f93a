//! Tissues, arms and masters.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use trocar_identify::{Part, PartRequest, Signals, identify_part};

use super::{ENCODER_M, FORCE_NOISE_N, Found, INTERVAL_S, RIPPLE_N, SAMPLES, STEPS, uniform};

/// Sizes in m, rates in rad/s and phases of sines.
struct Waves(Vec<[f64; 3]>);

impl Waves {
    /// Sines of a size with a random rate each.
    fn random(random: &mut ChaCha8Rng, sizes: &[(f64, f64, f64)]) -> Self {
        let wave = |(size_m, slow, fast): &(f64, f64, f64)| {
            [*size_m, uniform(random, *slow, *fast), uniform(random, 0.0, 6.3)]
        };
        Self(sizes.iter().map(wave).collect())
    }

    fn place_m(&self, t_s: f64) -> f64 {
        self.0.iter().map(|[size, rate, phase]| size * (rate * t_s + phase).sin()).sum()
    }

    fn speed(&self, t_s: f64) -> f64 {
        self.0.iter().map(|[size, rate, phase]| size * rate * (rate * t_s + phase).cos()).sum()
    }
}

/// The motion of a hand.
const HAND: [(f64, f64, f64); 3] = [(0.012, 2.0, 6.0), (0.004, 8.0, 20.0), (0.001, 25.0, 60.0)];

/// A perturbation of a hand by a device, up to 24 Hz.
const PERTURBATION: [(f64, f64, f64); 6] = [
    (0.008, 2.0, 6.0),
    (0.004, 8.0, 20.0),
    (0.002, 20.0, 45.0),
    (0.001, 45.0, 75.0),
    (0.0008, 75.0, 110.0),
    (0.0005, 110.0, 150.0),
];

/// Returns a recording with the encoder's positions, and the noise and the ripple of the force sensor.
fn recorded(part: Part, place_m: &[f64], force_n: &[f64], input: Option<Vec<f64>>, random: &mut ChaCha8Rng) -> Signals {
    let normal = Normal::new(0.0, 1.0).expect("positive");
    let ripple_rate = uniform(random, 20.0, 60.0);
    let read = |(k, force_n): (usize, &f64)| {
        force_n + RIPPLE_N * (ripple_rate * k as f64 * INTERVAL_S).sin() + FORCE_NOISE_N * normal.sample(random)
    };
    let force_n = force_n.iter().enumerate().map(read).collect();
    let position_m = place_m.iter().map(|x| (x / ENCODER_M).round() * ENCODER_M).collect();
    Signals::new("synthetic", part, INTERVAL_S, position_m, force_n, input).expect("a recording")
}

/// Identifies a recording, and returns each truth with what was found; nothing is found with another structure.
fn found(part: Part, recording: Signals, structures: &[&str], truths: &[(&'static str, f64)]) -> Option<Found> {
    let request = PartRequest { training: vec![recording], predictions: vec![] };
    let identified = identify_part(part, request, |_, _| ()).ok()?;
    let is_right = structures.contains(&identified.structure);
    Some(truths.iter().map(|(key, truth)| (*key, *truth, identified.parameter(key).filter(|_| is_right))).collect())
}

/// Identifies a random spring and damper with the errors of its force sensor. The forces are in closed form.
pub(super) fn tissue(random: &mut ChaCha8Rng) -> Option<Found> {
    let stiffness_n_per_m = uniform(random, 100.0, 3000.0);
    let damping_n_s_per_m = uniform(random, 1.0, 40.0);
    let contact_m = uniform(random, -0.004, 0.006);
    let lag_s = uniform(random, 0.0, 3e-3);
    let zero_n = uniform(random, -0.3, 0.3);
    let hand = Waves::random(random, &HAND);
    let reading_n = |k: usize| {
        let t_s = k as f64 * INTERVAL_S - lag_s;
        let depth_m = hand.place_m(t_s) - contact_m;
        let force_n = stiffness_n_per_m * depth_m + damping_n_s_per_m * hand.speed(t_s);
        if depth_m > 0.0 { force_n + zero_n } else { zero_n }
    };
    let force_n: Vec<f64> = (0..SAMPLES).map(reading_n).collect();
    let place_m: Vec<f64> = (0..SAMPLES).map(|k| hand.place_m(k as f64 * INTERVAL_S)).collect();
    let truths = [
        ("stiffness_n_per_m", stiffness_n_per_m),
        ("damping_n_s_per_m", damping_n_s_per_m),
        ("contact_m", contact_m),
        ("force_lag_s", lag_s),
        ("force_zero_n", zero_n),
    ];
    let recording = recorded(Part::Tissue, &place_m, &force_n, None, random);
    found(Part::Tissue, recording, &["kelvin-voigt"], &truths)
}

/// Identifies a random arm that a device perturbs while it holds a position: semi-implicit steps of 2.5 µs.
pub(super) fn arm(random: &mut ChaCha8Rng) -> Option<Found> {
    let (k_a, b_a) = (uniform(random, 400.0, 1500.0), uniform(random, 10.0, 40.0));
    let (k_h, b_h) = (uniform(random, 1000.0, 15_000.0), uniform(random, 20.0, 180.0));
    let mass_kg = uniform(random, 0.8, 2.5);
    let desired_m = uniform(random, -0.002, 0.002);
    let hand = Waves::random(random, &PERTURBATION);
    let step_s = INTERVAL_S / STEPS as f64;
    let (mut position_m, mut velocity) = (desired_m, 0.0);
    let (mut places, mut forces) = (vec![], vec![]);
    // The recording begins after the first second, when the transient has decayed.
    let before = (1.0 / INTERVAL_S) as usize * STEPS;
    for k in 0..before + SAMPLES * STEPS {
        let t_s = k as f64 * step_s;
        let (hand_m, rate) = (hand.place_m(t_s), hand.speed(t_s));
        let force_n = k_a * (position_m - hand_m) + b_a * (velocity - rate);
        if k >= before && k % STEPS == 0 {
            places.push(hand_m);
            forces.push(force_n);
        }
        velocity += step_s * (k_h * (desired_m - position_m) - b_h * velocity - force_n) / mass_kg;
        position_m += step_s * velocity;
    }
    let truths = [
        ("k_a_n_per_m", k_a),
        ("b_a_n_s_per_m", b_a),
        ("k_h_n_per_m", k_h),
        ("b_h_n_s_per_m", b_h),
        ("m_h_kg", mass_kg),
        ("desired_offset_m", desired_m),
    ];
    found(Part::Arm, recorded(Part::Arm, &places, &forces, None, random), &["two-springs"], &truths)
}

/// Identifies a random master between a hand and a motor: semi-implicit steps of 2.5 µs.
pub(super) fn master(random: &mut ChaCha8Rng) -> Option<Found> {
    let (mass_kg, viscous) = (uniform(random, 0.1, 0.6), uniform(random, 0.5, 6.0));
    let (coulomb_n, constant_n) = (uniform(random, 0.1, 0.6), uniform(random, -0.3, 0.3));
    let delay_s = uniform(random, 0.0, 4e-3);
    let (hand_stiffness, motor_stiffness) = (uniform(random, 200.0, 600.0), uniform(random, 50.0, 200.0));
    let hand = Waves::random(random, &HAND);
    let tremor = Waves::random(random, &[(0.5, 20.0, 60.0)]);
    let step_s = INTERVAL_S / STEPS as f64;
    let late = (delay_s / step_s).round() as usize;
    let (mut position_m, mut velocity) = (0.0, 0.0);
    let (mut places, mut hands, mut motors, mut commands) = (vec![], vec![], vec![], vec![]);
    for k in 0..SAMPLES * STEPS {
        let t_s = k as f64 * step_s;
        let hand_n = hand_stiffness * (hand.place_m(t_s) - position_m) - 10.0 * velocity;
        // The motor holds its command for a sample.
        if k % STEPS == 0 {
            let command_n = tremor.place_m(t_s) - motor_stiffness * position_m;
            places.push(position_m);
            hands.push(hand_n);
            motors.push(command_n);
        }
        commands.push(motors[motors.len() - 1]);
        let impulse_n = mass_kg / step_s * velocity + hand_n + commands[k.saturating_sub(late)] + constant_n;
        let remaining_n = impulse_n - impulse_n.clamp(-coulomb_n, coulomb_n);
        velocity = remaining_n / (mass_kg / step_s + viscous);
        position_m += step_s * velocity;
    }
    let truths = [
        ("mass_kg", mass_kg),
        ("viscous_n_s_per_m", viscous),
        ("coulomb_n", coulomb_n),
        ("constant_force_n", constant_n),
        ("motor_delay_s", delay_s),
    ];
    let recording = recorded(Part::Master, &places, &hands, Some(motors), random);
    found(Part::Master, recording, &["coulomb", "coulomb-delay"], &truths)
}
