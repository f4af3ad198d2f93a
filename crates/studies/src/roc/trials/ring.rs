use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::matter::Fall;
use super::{log_uniform, uniform};

const RINGING: f64 = 0.5;
const UNTARED: f64 = 0.3;

/// Range for sensors that were not tared.
const OFFSETS_N: [f64; 2] = [-12.0, 25.0];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    pub ring: Option<Ring>,
    /// Reading without load.
    pub offset_n: f64,
}

/// A decaying oscillation of the force after each fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Initial amplitude as a share of the fall, 0.05 to 0.3.
    pub share: f64,
    /// From 10 to 60, and at most a third of the Nyquist rate.
    pub frequency_hz: f64,
    /// From 0.05 to 0.5.
    pub decay_s: f64,
}

impl Machine {
    /// Independent of the random numbers of the trial.
    pub(super) fn drawn(seed: u64, tick_s: f64) -> Self {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(1);
        let rings = uniform(random, 0.0, 1.0) < RINGING;
        let ring = Ring {
            share: log_uniform(random, 0.05, 0.3),
            frequency_hz: log_uniform(random, 10.0, 60.0).min(1.0 / (6.0 * tick_s)),
            decay_s: log_uniform(random, 0.05, 0.5),
        };
        let untared = uniform(random, 0.0, 1.0) < UNTARED;
        let offset_n = if untared { uniform(random, OFFSETS_N[0], OFFSETS_N[1]) } else { 0.0 };
        Self { ring: rings.then_some(ring), offset_n }
    }

    pub(super) fn add(&self, falls: &[Fall], tick_s: f64, forces: &mut [f64]) {
        for (sample, force_n) in forces.iter_mut().enumerate() {
            let time_s = sample as f64 * tick_s;
            *force_n += self.offset_n;
            for fall in falls.iter().filter(|fall| fall.end_s() < time_s) {
                *force_n += self.ring.map_or(0.0, |ring| fall.drop_n * ring.at(time_s - fall.end_s()));
            }
        }
    }
}

impl Ring {
    /// Share of the fall. It begins downwards, as a mass does that has lost its load.
    pub fn at(&self, since_s: f64) -> f64 {
        let phase = std::f64::consts::TAU * self.frequency_hz * since_s;
        -self.share * libm::exp(-since_s / self.decay_s) * libm::sin(phase)
    }
}
