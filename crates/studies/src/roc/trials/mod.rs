//! Synthetic recordings from the ranges of recorded needle insertions and teleoperators.
//!
//! Integrated in steps of 0.1 ms and then sampled, so a fast fall lies between two samples of a slow sensor.

mod hand;
mod matter;
mod noise;
mod ring;

pub use hand::Hand;
pub use matter::{Fall, Matter};
pub use noise::Noise;
pub use ring::{Machine, Ring};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use self::matter::Contact;
use super::samples::Samples;
use trocar_core::error::InvalidValue;
use trocar_core::estimation::VelocityFilter;

const STEP_S: f64 = 1e-4;

const RATES_HZ: [f64; 8] = [100.0, 200.0, 333.0, 500.0, 1000.0, 2000.0, 5000.0, 10_000.0];

const WITHOUT_RUPTURE: f64 = 0.4;

/// The analyst's knowledge of the contact position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactKnowledge {
    Known,
    /// The error is some millimetres.
    Wrong,
    /// Every sample counts as in contact.
    FromFirstSample,
}

#[derive(Debug, Clone)]
pub struct Trial {
    pub seed: u64,
    pub tick_s: f64,
    /// Positive into the tissue.
    pub position_m: Vec<f64>,
    /// Positive when resisting insertion.
    pub force_n: Vec<f64>,
    pub contact_m: f64,
    pub knowledge: ContactKnowledge,
    pub falls: Vec<Fall>,
    pub noise_std_n: f64,
    pub noise: Noise,
    pub machine: Machine,
    pub hand: Hand,
    pub matter: Matter,
    pub contact_s: f64,
}

fn log_uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low * libm::pow(high / low, uniform(random, 0.0, 1.0))
}

fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    use rand::RngExt;
    low + (high - low) * random.random::<f64>()
}

fn one_of<T: Copy>(random: &mut ChaCha8Rng, all: &[T]) -> T {
    use rand::RngExt;
    all[random.random_range(0..all.len())]
}

impl Trial {
    /// The detectors' settings were chosen on seeds below; studies use seeds above.
    pub const BEFORE_FIRST: u64 = 2_000_000;

    pub fn new(seed: u64) -> Self {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let rate_hz = one_of(random, &RATES_HZ);
        let matter = if uniform(random, 0.0, 1.0) < WITHOUT_RUPTURE {
            one_of(random, &[Matter::Foam, Matter::Spring, Matter::RigidStop, Matter::Nothing])
        } else {
            Matter::Membranes
        };
        let hand = Hand::drawn(random, matter);
        let mut contact = Contact::drawn(random, matter);
        let path = hand.path(random, &contact);
        let compliance = contact.hand_compliance_m_per_n(random);
        let lag_s = uniform(random, 2e-3, 15e-3);
        let steps = (path.duration_s / STEP_S) as usize;
        let stride = ((1.0 / (rate_hz * STEP_S)).round() as usize).max(1);
        let mut position_m = path.at(0.0);
        let (mut positions, mut forces) = (vec![], vec![]);
        let mut contact_steps = 0_u64;
        for step in 0..steps {
            let time_s = step as f64 * STEP_S;
            // The hand is a spring with a lag: it advances when the force falls.
            let (velocity_m_per_s, force_n) = contact.step(time_s, position_m, path.at(time_s), (compliance, lag_s));
            contact_steps += u64::from(position_m > contact.surface_m);
            if step % stride == 0 {
                positions.push(position_m);
                forces.push(force_n);
            }
            position_m += velocity_m_per_s * STEP_S;
        }
        let tick_s = stride as f64 * STEP_S;
        let falls = Fall::merged(contact.falls, &forces, tick_s);
        let machine = Machine::drawn(seed, tick_s);
        machine.add(&falls, tick_s, &mut forces);
        let noise_std_n = log_uniform(random, 0.002, 0.2);
        let noise = Noise::drawn(random);
        noise.add(random, noise_std_n, tick_s, &mut forces);
        encode(random, &mut positions);
        let knowledge =
            one_of(random, &[ContactKnowledge::Known, ContactKnowledge::Wrong, ContactKnowledge::FromFirstSample]);
        let contact_m = match knowledge {
            ContactKnowledge::Known => contact.surface_m,
            ContactKnowledge::Wrong => contact.surface_m + uniform(random, -5e-3, 5e-3),
            ContactKnowledge::FromFirstSample => positions.iter().copied().fold(f64::MAX, f64::min) - 1e-3,
        };
        Self {
            seed,
            tick_s,
            position_m: positions,
            force_n: forces,
            contact_m,
            knowledge,
            falls,
            noise_std_n,
            noise,
            machine,
            hand,
            matter,
            contact_s: contact_steps as f64 * STEP_S,
        }
    }
}

/// Smaller falls may be missed.
const MIN_NOISE_STDS: f64 = 6.0;

const MIN_DROP_N: f64 = 0.2;

const ACCELERATION_M_PER_S2: f64 = 10.0;

impl Trial {
    pub fn is_above_noise(&self, fall: &Fall) -> bool {
        fall.drop_n > MIN_NOISE_STDS * self.noise_std_n && fall.drop_n > MIN_DROP_N
    }

    pub(super) fn samples(self) -> Result<Samples, InvalidValue> {
        let steps = self.position_m.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let step_m = steps.filter(|step_m| *step_m > ROUNDING_M).fold(MAX_STEP_M, f64::min);
        let mut filter = VelocityFilter::<f64>::new(self.tick_s, step_m, ACCELERATION_M_PER_S2)?;
        Ok(Samples {
            tick_s: self.tick_s,
            velocity_m_per_s: self.position_m.iter().map(|position_m| filter.update(*position_m)).collect(),
            force_n: self.force_n,
            position_m: self.position_m,
            ruptures_s: self.falls.iter().map(|fall| fall.start_s).collect(),
        })
    }
}

/// Smaller changes of the position are rounding.
const ROUNDING_M: f64 = 1e-9;
const MAX_STEP_M: f64 = 1e-3;

fn encode(random: &mut ChaCha8Rng, positions: &mut [f64]) {
    let step_m = one_of(random, &[0.0, 1e-6, 5e-6, 2e-5, 5e-5]);
    if step_m > 0.0 {
        positions.iter_mut().for_each(|position_m| *position_m = (*position_m / step_m).round() * step_m);
    }
}
