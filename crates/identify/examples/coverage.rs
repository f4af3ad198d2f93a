//! Identifies synthetic rigs with the noise and the encoder steps of a real one, and prints how often the 95 % intervals
//! contain the truth, and the median errors: `cargo run --release -p trocar-identify --example coverage [RIGS]`.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use rand_distr::{Distribution as _, Normal};
use trocar_identify::{Load, Machine, Measured, Request, identify};

const INTERVAL_S: f64 = 5e-4;
const SAMPLES: usize = 12_000;

/// Steps of the simulation per sample.
const STEPS: usize = 200;

/// A step of the encoders of the rig in `tests/data/teleop_1dof`: 2π / 300,000 on a lever of 0.075 m.
const ENCODER_M: f64 = 1.57e-6;

/// Noise and ripple of its torque sensor.
const FORCE_NOISE_N: f64 = 0.02;
const RIPPLE_N: f64 = 0.05;

/// A uniform number from `low` to `high`.
fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A random machine with the errors of its force sensor.
fn machine(random: &mut ChaCha8Rng) -> Machine {
    let mass_kg = uniform(random, 0.1, 0.5);
    let position_gain_n_per_m = uniform(random, 1000.0, 6000.0);
    let critical = 2.0 * (mass_kg * position_gain_n_per_m).sqrt();
    Machine {
        mass_kg,
        viscous_n_s_per_m: uniform(random, 0.5, 6.0),
        coulomb_n: uniform(random, 0.1, 0.6),
        position_gain_n_per_m,
        velocity_gain_n_s_per_m: uniform(random, 0.3, 0.7) * critical,
        delay_s: INTERVAL_S * f64::from(1 + random.next_u32() % 3),
        load: Load {
            scale: uniform(random, 0.85, 1.15),
            offset_n: uniform(random, -0.2, 0.2),
            lag_s: uniform(random, 0.0, 3e-3),
            ..Load::EXACT
        },
    }
}

/// A recording of a machine against a spring, which the master touches in a part of its motion.
fn recording(name: &str, machine: &Machine, stiffness_n_per_m: f64, random: &mut ChaCha8Rng) -> Measured {
    let normal = Normal::new(0.0, 1.0).expect("positive");
    let waves: Vec<[f64; 3]> = [(0.012, 2.0, 6.0), (0.004, 8.0, 20.0), (0.001, 25.0, 60.0)]
        .map(|(size_m, slow, fast)| [size_m, uniform(random, slow, fast), uniform(random, 0.0, 6.3)])
        .into();
    let place_m = |t_s: f64| -> f64 { waves.iter().map(|[size, rate, phase]| size * (rate * t_s + phase).sin()).sum() };
    let at = |k: usize| k as f64 * INTERVAL_S;
    let zero_n = uniform(random, -0.1, 0.1);
    let Motion { master, slave, actuator, reading } = simulate(machine, stiffness_n_per_m, &place_m);
    let ripple_rate = uniform(random, 20.0, 60.0);
    let read = |(k, force_n): (usize, &f64)| {
        force_n + zero_n + RIPPLE_N * (ripple_rate * at(k)).sin() + FORCE_NOISE_N * normal.sample(random)
    };
    let force = reading.iter().enumerate().map(read).collect();
    let encoder = |x: &f64| (x / ENCODER_M).round() * ENCODER_M;
    let (master, slave) = (master.iter().map(encoder).collect(), slave.iter().map(encoder).collect());
    Measured::new(name, INTERVAL_S, master, slave, force, Some(actuator)).expect("a recording")
}

/// The samples of a motion: positions in m, the force of the actuator and the reading of an ideal force sensor in N.
struct Motion {
    master: Vec<f64>,
    slave: Vec<f64>,
    actuator: Vec<f64>,
    reading: Vec<f64>,
}

/// Simulates a machine independently of the identification: semi-implicit steps of 2.5 µs, with the controller's delay as
/// it is. The reading lags behind the load and is wrong by the scale and the constant force.
fn simulate(machine: &Machine, stiffness_n_per_m: f64, place_m: &impl Fn(f64) -> f64) -> Motion {
    let step_s = INTERVAL_S / STEPS as f64;
    let later = |delay_s: f64| (delay_s / step_s).round() as usize;
    let (delay, lag) = (later(machine.delay_s), later(machine.load.lag_s));
    let inertia = machine.mass_kg / step_s;
    let (mut position_m, mut velocity) = (place_m(0.0), 0.0);
    let (mut errors, mut loads_n) = (vec![], vec![]);
    let mut motion = Motion { master: vec![], slave: vec![], actuator: vec![], reading: vec![] };
    for k in 0..SAMPLES * STEPS {
        let master_m = place_m(k as f64 * step_s);
        // The velocity of the slave is that half a step before; the controller takes the mean of two.
        let rate = (master_m - place_m((k as f64 - 1.0) * step_s)) / step_s;
        errors.push((master_m - position_m, rate - velocity));
        let load_n = stiffness_n_per_m * position_m.max(0.0);
        loads_n.push(load_n);
        let delayed = k.saturating_sub(delay);
        let (error_m, rate_before) = errors[delayed];
        let error_rate = 0.5 * (rate_before + errors[(delayed + 1).min(k)].1);
        let actuator_n = machine.position_gain_n_per_m * error_m + machine.velocity_gain_n_s_per_m * error_rate;
        if k % STEPS == 0 {
            motion.master.push(master_m);
            motion.slave.push(position_m);
            motion.actuator.push(actuator_n);
            motion.reading.push((loads_n[k.saturating_sub(lag)] - machine.load.offset_n) / machine.load.scale);
        }
        let impulse_n = inertia * velocity + actuator_n - load_n;
        let remaining_n = impulse_n - impulse_n.clamp(-machine.coulomb_n, machine.coulomb_n);
        velocity = remaining_n / (inertia + machine.viscous_n_s_per_m);
        position_m += step_s * velocity;
    }
    motion
}

fn main() {
    let rigs: u64 = std::env::args().nth(1).map_or(200, |text| text.parse().expect("a number of rigs"));
    let mut found: BTreeMap<&str, Vec<(bool, f64)>> = BTreeMap::new();
    for seed in 0..rigs {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let machine = machine(&mut random);
        let stiffness_n_per_m = uniform(&mut random, 200.0, 1500.0);
        let mut new = |name: &str, share: f64| recording(name, &machine, share * stiffness_n_per_m, &mut random);
        let training = vec![new("free", 0.0), new("contact", 1.0)];
        let Ok(identified) = identify(Request { training, predictions: vec![] }, || ()) else {
            println!("rig {seed} is not identified");
            continue;
        };
        let truths = [
            ("mass_kg", machine.mass_kg),
            ("viscous_n_s_per_m", machine.viscous_n_s_per_m),
            ("coulomb_n", machine.coulomb_n),
            ("position_gain_n_per_m", machine.position_gain_n_per_m),
            ("velocity_gain_n_s_per_m", machine.velocity_gain_n_s_per_m),
            ("controller_delay_s", machine.delay_s),
            ("force_scale", machine.load.scale),
            ("force_lag_s", machine.load.lag_s),
        ];
        for (key, truth) in truths {
            let Some((value, [low, high])) = identified.parameter(key) else { continue };
            let error = (value / truth - 1.0).abs();
            found.entry(key).or_default().push(((low..=high).contains(&truth), error));
        }
    }
    println!("{:<28}{:>8}{:>12}{:>16}", "parameter", "rigs", "covered", "median error");
    for (key, mut results) in found {
        results.sort_by(|a, b| a.1.total_cmp(&b.1));
        let covered = results.iter().filter(|(is_covered, _)| *is_covered).count();
        let (share, median) = (covered as f64 / results.len() as f64, results[results.len() / 2].1);
        println!("{key:<28}{:>8}{:>10.1} %{:>14.2} %", results.len(), 100.0 * share, 100.0 * median);
    }
}
