use crate::lane::Stored;
use crate::set_back::SetBack;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    New,
    Repeated,
    Late,
    /// The first sample of a counter that was set back.
    Restarted,
}

impl Arrival {
    pub(super) fn is_new(self) -> bool {
        match self {
            Self::New | Self::Restarted => true,
            Self::Repeated | Self::Late => false,
        }
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct Sequence {
    /// 0 before the first sample.
    newest: u64,
    late: SetBack<u64>,
}

impl Sequence {
    #[inline(always)]
    pub(super) fn advance(&mut self) -> u64 {
        self.newest = self.newest.saturating_add(1);
        self.newest
    }

    pub(super) fn take(&mut self, number: u64) -> Arrival {
        if number > self.newest {
            self.newest = number;
            self.late.clear();
            return Arrival::New;
        }
        if number == self.newest {
            self.late.clear();
            return Arrival::Repeated;
        }
        if !self.late.note(number) {
            return Arrival::Late;
        }
        self.newest = number;
        Arrival::Restarted
    }
}

impl Stored for Sequence {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { newest, late } = self;
        newest.numbers(with);
        late.numbers(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(numbers: impl IntoIterator<Item = u64>) -> Vec<Arrival> {
        let mut sequence = Sequence::default();
        numbers.into_iter().map(|number| sequence.take(number)).collect()
    }

    #[test]
    fn a_repeated_sample_and_a_swapped_one_are_told_from_a_new_one() {
        use Arrival::{Late, New, Repeated};
        assert_eq!(places([1, 2, 2, 4, 3, 5]), [New, New, Repeated, New, Late, New]);
        assert_eq!(places([0]), [Repeated], "0 is before the first number");
    }

    #[test]
    fn a_counter_that_was_set_back_restarts_after_ten_ascending_samples() {
        let all = places([1000].into_iter().chain(1..=12));
        assert!(all[1..10].iter().all(|place| *place == Arrival::Late), "{all:?}");
        assert_eq!(all[10..], [Arrival::Restarted, Arrival::New, Arrival::New]);
        let descending = places([1000].into_iter().chain((1..=30).rev()));
        assert!(descending[1..].iter().all(|place| *place == Arrival::Late));
    }
}
