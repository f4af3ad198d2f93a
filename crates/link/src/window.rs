const LENGTH: u64 = 1024;
const WORDS: usize = (LENGTH / u64::BITS as u64) as usize;

/// The last 1024 packet numbers: each is accepted once, older ones never (the window of RFC 4303, 3.4.3).
#[derive(Debug, Clone, Default)]
pub struct Window {
    next: u64,
    seen: [u64; WORDS],
}

impl Window {
    pub fn accept(&mut self, number: u64) -> bool {
        if number == u64::MAX || number.saturating_add(LENGTH) < self.next {
            return false;
        }
        if number >= self.next.saturating_add(LENGTH) {
            self.seen = [0; WORDS];
        } else {
            for entering in self.next..=number {
                let (word, bit) = self.word(entering);
                *word &= !bit;
            }
        }
        self.next = self.next.max(number + 1);
        let (word, bit) = self.word(number);
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    fn word(&mut self, number: u64) -> (&mut u64, u64) {
        let place = number % LENGTH;
        (&mut self.seen[(place / u64::from(u64::BITS)) as usize], 1 << (place % u64::from(u64::BITS)))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_number_is_accepted_once_and_an_old_one_never() {
        let mut window = Window::default();
        assert!(window.accept(5) && window.accept(3) && window.accept(4));
        assert!(!window.accept(5) && !window.accept(3));
        assert!(window.accept(5 + LENGTH));
        assert!(window.accept(6) && !window.accept(5), "5 has left the window");
        assert!(window.accept(1 << 60));
        assert!(!window.accept(6 + LENGTH) && !window.accept(u64::MAX));
    }

    proptest! {
        #[test]
        fn the_window_is_a_set_of_the_last_numbers(steps in prop::collection::vec((0_u64..40, 0_u64..1200), 1..400)) {
            let (mut window, mut seen, mut highest) = (Window::default(), HashSet::new(), 0_u64);
            let mut ahead = 0;
            for (step, back) in steps {
                ahead += step;
                let number = ahead.saturating_sub(back);
                let expected = number + LENGTH > highest && !seen.contains(&number);
                prop_assert_eq!(window.accept(number), expected, "{}", number);
                if expected {
                    seen.insert(number);
                    highest = highest.max(number);
                }
            }
        }
    }
}
