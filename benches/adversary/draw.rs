//! Random numbers for the settings of a case.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 11;

/// The random numbers of one case.
pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(case: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(case);
        Self(random)
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Draws log-uniformly.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.0.random::<f64>())
    }

    /// Returns 0 in `share` of the cases, else draws log-uniformly.
    pub fn zero_or_log(&mut self, share: f64, low: f64, high: f64) -> f64 {
        if self.chance(share) { 0.0 } else { self.log(low, high) }
    }

    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.0.random_range(0..of.len())]
    }
}
