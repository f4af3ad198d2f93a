//! Recognises a clock or counter that was set back.

use crate::lane::Stored;

const VALUES: u32 = 10;

/// Ten ascending values behind the newest one; a single one may be late.
#[derive(Debug, Clone, Default)]
pub struct SetBack<T> {
    last: T,
    ascending: u32,
}

impl<T: PartialOrd + Copy> SetBack<T> {
    pub fn note(&mut self, value: T) -> bool {
        self.ascending = if self.ascending > 0 && value > self.last { self.ascending + 1 } else { 1 };
        self.last = value;
        let is_set_back = self.ascending >= VALUES;
        if is_set_back {
            self.clear();
        }
        is_set_back
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.ascending = 0;
    }
}

impl<T: Stored> Stored for SetBack<T> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { last, ascending } = self;
        last.numbers(with);
        ascending.numbers(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_ascending_values_are_needed_in_a_row() {
        let mut clock = SetBack::<f64>::default();
        let noted: [bool; 12] = core::array::from_fn(|k| clock.note(-5.0 + k as f64));
        assert_eq!(noted.iter().position(|is_set_back| *is_set_back), Some(9));
        assert!(!noted[10] && !noted[11], "the count begins anew");
        assert!(!(0..100).any(|k| clock.note(f64::from(k % 9))), "never ten in a row");
        assert!((0..8).all(|k| !clock.note(f64::from(20 + k))));
        clock.clear();
        assert!(!clock.note(40.0));
    }
}
