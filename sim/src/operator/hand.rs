//! A person who is there now and moves as they like.

use core::sync::atomic::{AtomicU64, Ordering};

/// How fast the hand goes where it aims, in 1/s: aims come 60 times a second, and between them the hand has no jumps.
const APPROACH_PER_S: f64 = 60.0;

/// Fastest motion of the hand in m/s: as fast as a hand stabs, so that a pointer that jumps is no impact.
const FASTEST_M_PER_S: f64 = 0.5;

/// Where a hand is, and where it aims: both in m, shared by the run that it drives and by whoever moves it.
#[derive(Debug)]
pub struct Hand {
    /// The bits of numbers.
    position: AtomicU64,
    aim: AtomicU64,
}

impl Hand {
    /// A hand at rest at a position in m.
    #[must_use]
    pub fn new(position_m: f64) -> Self {
        Self { position: AtomicU64::new(position_m.to_bits()), aim: AtomicU64::new(position_m.to_bits()) }
    }

    /// Aims at a position in m; one that is no number is not heard.
    pub fn aim(&self, position_m: f64) {
        if position_m.is_finite() {
            self.aim.store(position_m.to_bits(), Ordering::Relaxed);
        }
    }

    /// Where it is, in m.
    #[must_use]
    pub fn position_m(&self) -> f64 {
        f64::from_bits(self.position.load(Ordering::Relaxed))
    }

    /// Moves towards the aim for `tick_s` (s): by a share of the way, at most at the fastest speed.
    pub fn step(&self, tick_s: f64) {
        let position = self.position_m();
        let way = f64::from_bits(self.aim.load(Ordering::Relaxed)) - position;
        let most = FASTEST_M_PER_S * tick_s;
        let step = ((APPROACH_PER_S * tick_s).min(1.0) * way).clamp(-most, most);
        self.position.store((position + step).to_bits(), Ordering::Relaxed);
    }
}

impl PartialEq for Hand {
    fn eq(&self, other: &Self) -> bool {
        self.position_m() == other.position_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_goes_where_it_aims_and_not_faster_than_hands_do() {
        let hand = Hand::new(0.0);
        hand.aim(0.05);
        let mut fastest = 0.0_f64;
        for _ in 0..400 {
            let before = hand.position_m();
            hand.step(1e-3);
            fastest = fastest.max(hand.position_m() - before);
        }
        assert!((hand.position_m() - 0.05).abs() < 1e-6);
        assert!((fastest - 0.5e-3).abs() < 1e-15);
        hand.aim(f64::NAN);
        hand.step(1e-3);
        assert!(hand.position_m() < 0.051, "still where it was");
    }
}
