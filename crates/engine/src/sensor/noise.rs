use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::bank::NoiseBank;
use trocar_core::lane::Lane;

const BLOCK: usize = 64;

/// Blocks keep the generator's code and state out of most ticks.
#[derive(Debug, Clone)]
pub(super) struct WhiteNoise<L> {
    streams: Box<[Stream]>,
    block: Box<[L; BLOCK]>,
    next: usize,
}

#[derive(Debug, Clone)]
struct Stream {
    rng: ChaCha8Rng,
    /// The bank's numbers, used before the generator's, and the number of used ones.
    drawn: Option<(Arc<[f64]>, usize)>,
}

impl<L: Lane> WhiteNoise<L> {
    pub(super) fn new(seed: u64, first_stream: u64) -> Self {
        let stream = |lane| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(first_stream + lane as u64);
            Stream { rng, drawn: None }
        };
        Self { streams: (0..L::WIDTH).map(stream).collect(), block: Box::new([L::zero(); BLOCK]), next: BLOCK }
    }

    pub(super) fn take_from(&mut self, bank: &mut NoiseBank, count: u64) {
        let whole_blocks = usize::try_from(count).ok().and_then(|count| count.checked_next_multiple_of(BLOCK));
        for stream in &mut self.streams {
            if stream.rng.get_word_pos() == 0
                && let Some((numbers, rng)) = whole_blocks.and_then(|count| bank.numbers(&stream.rng, count))
            {
                *stream = Stream { rng, drawn: Some((numbers, 0)) };
            }
        }
    }

    #[inline(always)]
    pub(super) fn draw(&mut self) -> L {
        if self.next >= BLOCK {
            refill(&mut self.streams, &mut self.block);
            self.next = 0;
        }
        let drawn = self.block[self.next];
        self.next += 1;
        drawn
    }
}

/// The tick need not reload the sensor's state.
#[cold]
#[inline]
fn refill<L: Lane>(streams: &mut [Stream], block: &mut [L; BLOCK]) {
    for (lane, Stream { rng, drawn }) in streams.iter_mut().enumerate() {
        if let Some((numbers, taken)) = drawn
            && let Some(numbers) = numbers.get(*taken..*taken + BLOCK)
        {
            *taken += BLOCK;
            for (number, &drawn) in block.iter_mut().zip(numbers) {
                number.set_lane(lane, drawn);
            }
        } else {
            for number in block.iter_mut() {
                number.set_lane(lane, StandardNormal.sample(rng));
            }
        }
    }
}

impl trocar_core::lane::Gather for WhiteNoise<f64> {
    type Of<L: Lane> = WhiteNoise<L>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<WhiteNoise<L>> {
        let is_fresh = all.iter().all(|one| one.next == BLOCK);
        is_fresh.then(|| WhiteNoise {
            streams: all.iter().flat_map(|one| one.streams.iter().cloned()).collect(),
            block: Box::new([L::zero(); BLOCK]),
            next: BLOCK,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_contains_the_same_numbers_as_single_draws() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        rng.set_stream(3);
        let mut noise = WhiteNoise::<f64>::new(7, 3);
        for k in 0..1000 {
            let expected: f64 = StandardNormal.sample(&mut rng);
            assert_eq!(noise.draw(), expected, "{k}");
        }
    }

    #[test]
    fn a_noise_bank_does_not_change_the_numbers() {
        let mut bank = NoiseBank::new(10 * BLOCK);
        for seed in [7, 8, 7, 9, 8] {
            // The third seed finds no room. All streams continue after the bank's numbers.
            let mut separate = WhiteNoise::<f64>::new(seed, 3);
            let mut shared = separate.clone();
            shared.take_from(&mut bank, 5 * BLOCK as u64 - 3);
            assert_eq!(shared.streams[0].drawn.is_some(), seed != 9, "seed {seed}");
            for k in 0..7 * BLOCK {
                assert_eq!(shared.draw(), separate.draw(), "seed {seed}, number {k}");
            }
        }
    }
}
