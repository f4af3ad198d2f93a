#[cfg(feature = "alloc")]
use alloc::vec::Vec;

use crate::error::{InvalidValue, require};

/// Numbers to be restored into a part with the same settings.
pub trait Stored {
    /// Passes each number as 64 bits, in a fixed order, and keeps what `with` leaves.
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64));

    /// The numbers, for [`Stored::restore`].
    #[cfg(feature = "alloc")]
    fn state(&self) -> Vec<u64>
    where
        Self: Clone,
    {
        let mut state = Vec::new();
        self.clone().numbers(&mut |number| state.push(*number));
        state
    }

    /// The number of numbers.
    fn count(&mut self) -> usize {
        let mut count = 0;
        self.numbers(&mut |_| count += 1);
        count
    }

    /// Continues from the state of a part with the same settings, if its length agrees.
    fn restore(&mut self, state: &[u64]) -> Result<(), InvalidValue> {
        let has_equal_size = state.len() == self.count();
        require("the size of a state", state.len() as f64, has_equal_size, "as large as for the same settings")?;
        let mut values = state.iter();
        self.numbers(&mut |number| *number = *values.next().expect("as many values as numbers"));
        Ok(())
    }
}

pub(crate) fn store_code<T: Copy>(
    value: &mut T,
    all: impl IntoIterator<Item = T>,
    code: impl Fn(T) -> u8,
    otherwise: T,
    with: &mut dyn FnMut(&mut u64),
) {
    let mut stored = u64::from(code(*value));
    with(&mut stored);
    *value = all.into_iter().find(|value| u64::from(code(*value)) == stored).unwrap_or(otherwise);
}

impl Stored for f64 {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let mut bits = self.to_bits();
        with(&mut bits);
        *self = Self::from_bits(bits);
    }
}

macro_rules! stored_counts {
    ($($Count:ident)*) => {
        $(impl Stored for $Count {
            fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
                let mut bits = *self as u64;
                with(&mut bits);
                *self = bits as Self;
            }
        })*
    };
}
stored_counts!(usize u64 u32);

impl Stored for bool {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let mut bits = u64::from(*self);
        with(&mut bits);
        *self = bits != 0;
    }
}

impl<T: Stored, const N: usize> Stored for [T; N] {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        self.iter_mut().for_each(|one| one.numbers(with));
    }
}

impl<T: Stored> Stored for Option<T> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        if let Some(part) = self {
            part.numbers(with);
        }
    }
}
