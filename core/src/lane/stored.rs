//! The numbers of a part, to be stored and read back.

/// A part whose numbers can be stored, and read back into a part with the same settings.
pub trait Stored {
    /// Calls `with` with every number as 64 bits, in a fixed order, and takes over what it leaves there.
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64));
}

impl Stored for f64 {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let mut bits = self.to_bits();
        with(&mut bits);
        *self = Self::from_bits(bits);
    }
}

impl Stored for usize {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let mut bits = *self as u64;
        with(&mut bits);
        *self = bits as Self;
    }
}

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

/// Whether the part is there follows from the settings.
impl<T: Stored> Stored for Option<T> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        if let Some(part) = self {
            part.numbers(with);
        }
    }
}
