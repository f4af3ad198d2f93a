use core::sync::atomic::{AtomicU64, Ordering};

/// Keeps the hand from jumping between aims, which are set 60 times a second.
const APPROACH_PER_S: f64 = 60.0;

/// The speed of a stab.
const MAX_SPEED_M_PER_S: f64 = 0.5;

#[derive(Debug)]
pub struct Hand {
    position: AtomicU64,
    aim: AtomicU64,
}

impl Hand {
    #[must_use]
    pub fn new(position_m: f64) -> Self {
        Self { position: AtomicU64::new(position_m.to_bits()), aim: AtomicU64::new(position_m.to_bits()) }
    }

    pub fn aim(&self, position_m: f64) {
        if position_m.is_finite() {
            self.aim.store(position_m.to_bits(), Ordering::Relaxed);
        }
    }

    #[must_use]
    pub fn position_m(&self) -> f64 {
        f64::from_bits(self.position.load(Ordering::Relaxed))
    }

    pub fn step(&self, tick_s: f64) {
        let position = self.position_m();
        let way = f64::from_bits(self.aim.load(Ordering::Relaxed)) - position;
        let max_step = MAX_SPEED_M_PER_S * tick_s;
        let step = ((APPROACH_PER_S * tick_s).min(1.0) * way).clamp(-max_step, max_step);
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
    fn a_hand_moves_to_its_aim_at_no_more_than_the_maximum_speed() {
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

    #[test]
    fn near_its_aim_a_hand_moves_by_a_fraction_of_the_distance() {
        let hand = Hand::new(0.1);
        hand.aim(0.104);
        hand.step(1e-3);
        // 60 per s, for 1 ms.
        assert!((hand.position_m() - 0.10024).abs() < 1e-15, "{}", hand.position_m());
        hand.step(1.0);
        assert_eq!(hand.position_m(), 0.104, "at most all of it");
        hand.aim(-1.0);
        hand.step(1e-3);
        assert!((hand.position_m() - 0.1035).abs() < 1e-15, "at its largest speed in either direction");
        assert!(hand != Hand::new(0.0) && Hand::new(0.2) == Hand::new(0.2));
    }
}
