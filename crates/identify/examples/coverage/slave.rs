//! Slaves against a spring.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;
use rand_distr::{Distribution as _, Normal};
use trocar_identify::{Load, Machine, Measured, Request, identify};

use super::{ENCODER_M, FORCE_NOISE_N, Found, INTERVAL_S, RIPPLE_N, SAMPLES, STEPS, uniform};

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

pub(super) fn slave(random: &mut ChaCha8Rng) -> Option<Found> {
    let machine = machine(random);
    let stiffness_n_per_m = uniform(random, 200.0, 1500.0);
    let mut new = |name: &str, share: f64| recording(name, &machine, share * stiffness_n_per_m, random);
    let training = vec![new("free", 0.0), new("contact", 1.0)];
    let identified = identify(Request { training, predictions: vec![] }, || ()).ok()?;
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
    Some(truths.map(|(key, truth)| (key, truth, identified.parameter(key))).into())
}
