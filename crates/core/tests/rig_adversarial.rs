//! No sequence of samples makes a rig's commands exceed the settings `safety.*`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trocar_core::rig::{Command, HapticController, Limits, Sample, Settings, VelocitySource};
use trocar_core::safety::{SafetySettings, SafetyState};

struct Random(ChaCha8Rng);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0.random_range(0..end)
    }

    fn share(&mut self) -> f64 {
        self.0.random()
    }

    /// A positive number between two powers of ten.
    fn magnitude(&mut self, low: i32, high: i32) -> f64 {
        let exponent = f64::from(low) + f64::from(high - low) * self.share();
        10.0_f64.powf(exponent)
    }

    /// A position, velocity or force: plausible, a jump, absurd, or no number.
    fn reading(&mut self, near: f64) -> f64 {
        match self.below(12) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => -self.magnitude(-3, 8),
            3 => self.magnitude(-12, 8),
            4 => 0.0,
            5 => near + self.magnitude(-3, 0),
            _ => near + 1e-4 * (self.share() - 0.5),
        }
    }
}

/// Settings of which some are absurd but valid.
fn settings(random: &mut Random) -> Settings {
    let default = Settings::default();
    let limit = |random: &mut Random, usual: f64| if random.below(3) == 0 { random.magnitude(-12, 6) } else { usual };
    let safety = SafetySettings {
        force_limit_n: limit(random, 20.0),
        force_rate_n_per_s: limit(random, 2000.0),
        reference_speed_m_per_s: limit(random, 0.5),
        lead_m: limit(random, 0.05),
        start_tolerance_m: limit(random, 2e-3),
        alignment_speed_m_per_s: limit(random, 0.03),
        bad_samples: 1 + random.below(12),
        decay_s: limit(random, 0.2),
        checks_sensors: random.below(2) == 0,
        ..SafetySettings::DEFAULT
    };
    let limits = Limits {
        position_m: if random.below(4) == 0 { 1e6 } else { 1.0 },
        force_n: if random.below(4) == 0 { 1e6 } else { 100.0 },
        bridged_samples: random.below(12),
        ..default.limits
    };
    let filtered = VelocitySource::Filtered { resolution_m: 1e-6, acceleration_std_m_per_s2: 1.0 };
    Settings {
        tick_s: [1e-3, 1e-6, 1.0, 0.02][random.below(4) as usize],
        force_scale: limit(random, 1.0),
        position_scale: limit(random, 1.0),
        velocity: if random.below(2) == 0 { VelocitySource::Measured } else { filtered },
        limits,
        safety,
        ..default
    }
}

/// The greatest excess by rounding of a difference of numbers of this magnitude.
fn rounding(value: f64) -> f64 {
    4.0 * f64::EPSILON * value.abs()
}

/// Checks a command against the one before it, from the first good sample on.
fn check(settings: &Settings, before: &Command, now: &Command, slave_m: f64) -> Result<(), &'static str> {
    let Settings { tick_s, safety, .. } = settings;
    let numbers = [
        now.slave_reference_m,
        now.master_force_n,
        now.allowed_force_step_n,
        now.stiffness_n_per_m,
        now.damping_n_s_per_m,
        now.predicted_force_n,
        now.residual_n,
        now.distance,
        now.decision,
        now.slave_velocity_m_per_s,
    ];
    if !numbers.iter().all(|number| number.is_finite()) {
        return Err("a number is not finite");
    }
    if now.master_force_n.abs() > safety.force_limit_n {
        return Err("the force is beyond its limit");
    }
    let force_step_n = (now.master_force_n - before.master_force_n).abs();
    let largest_n = now.master_force_n.abs().max(before.master_force_n.abs());
    if force_step_n > safety.force_rate_n_per_s * tick_s + rounding(largest_n) {
        return Err("the force is faster than its rate");
    }
    let step_m = now.slave_reference_m - before.slave_reference_m;
    let farthest_m = now.slave_reference_m.abs().max(before.slave_reference_m.abs());
    let largest_step_m = safety.reference_speed_m_per_s * tick_s;
    if step_m.abs() > largest_step_m + rounding(farthest_m) {
        return Err("the reference is faster than its speed");
    }
    let holds = matches!(now.state, SafetyState::Disabled | SafetyState::Fault);
    if holds && step_m != 0.0 {
        return Err("the reference moves without being allowed to");
    }
    let lead_m = now.slave_reference_m - slave_m;
    let far = lead_m.abs() > safety.lead_m + rounding(farthest_m.max(slave_m.abs()));
    // Beyond the distance the reference only returns.
    if far && step_m * lead_m > 0.0 {
        return Err("the reference leaves the slave");
    }
    Ok(())
}

#[test]
fn no_sequence_of_samples_makes_a_command_exceed_its_limits() {
    check_sequences(20_000);
}

#[test]
#[ignore = "minutes"]
fn a_million_sequences_make_no_command_exceed_its_limits() {
    check_sequences(1_000_000);
}

fn check_sequences(count: u64) {
    let mut states = [0_u64; 4];
    let mut limits = [0_u64; 4];
    for seed in 0..count {
        let mut random = Random(ChaCha8Rng::seed_from_u64(seed));
        let settings = settings(&mut random);
        let mut controller = HapticController::new(&settings).expect("valid");
        let (mut near, mut number) = (0.1 * random.share(), 0);
        let mut before: Option<Command> = None;
        let mut slave_m = 0.0;
        for tick in 0..10 + random.below(30) {
            near += 1e-4;
            number += random.below(4);
            match random.below(40) {
                0 => controller.stop(),
                1 => controller.enable(),
                2 => number = random.0.random(),
                _ => {}
            }
            let sample = Sample {
                master_position_m: random.reading(near),
                slave_position_m: random.reading(near),
                slave_velocity_m_per_s: random.reading(0.01),
                force_n: random.reading(1.0),
            };
            let is_numbered = random.below(2) == 0;
            let command =
                if is_numbered { controller.step_numbered(&sample, number) } else { controller.step(&sample) };
            if !command.faults.slave_position {
                slave_m = sample.slave_position_m;
            }
            if let Some(before) = before {
                let result = check(&settings, &before, &command, slave_m);
                assert_eq!(result, Ok(()), "seed {seed}, tick {tick}: {before:?} {command:?} {settings:?}");
            }
            // From the first good sample on: before it the slave's position is not known.
            if before.is_some() || !command.faults.any() {
                before = Some(command);
            }
            states[usize::from(command.state.code())] += 1;
            let limited = command.limited;
            for (count, acted) in
                limits.iter_mut().zip([limited.force, limited.force_rate, limited.reference_speed, limited.lead])
            {
                *count += u64::from(acted);
            }
        }
    }
    assert!(states.iter().all(|ticks| *ticks > count / 10), "every state is reached: {states:?}");
    assert!(limits.iter().all(|ticks| *ticks > count / 10), "every limit acts: {limits:?}");
}
