use std::collections::HashMap;
use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Drawing a number costs as much as a tick.
#[derive(Debug)]
pub struct NoiseBank {
    kept: HashMap<Stream, Drawn>,
    room: usize,
}

type Stream = ([u8; 32], u64, usize);

type Drawn = (Arc<[f64]>, ChaCha8Rng);

impl NoiseBank {
    /// Beyond `max_numbers` (8 bytes each) runs draw further streams themselves.
    pub fn new(max_numbers: usize) -> Self {
        Self { kept: HashMap::new(), room: max_numbers }
    }

    pub(super) fn numbers(&mut self, rng: &ChaCha8Rng, count: usize) -> Option<Drawn> {
        let stream = (rng.get_seed(), rng.get_stream(), count);
        if let Some(drawn) = self.kept.get(&stream) {
            return Some(drawn.clone());
        }
        self.room = self.room.checked_sub(count)?;
        let mut rng = rng.clone();
        let numbers = (0..count).map(|_| StandardNormal.sample(&mut rng)).collect();
        self.kept.insert(stream, (numbers, rng));
        self.kept.get(&stream).cloned()
    }
}
