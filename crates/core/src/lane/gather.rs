#[cfg(feature = "alloc")]
use alloc::{boxed::Box, sync::Arc};

use super::{Lane, Mask, of_each};

/// Lanes of a gathered part.
pub const LANES: usize = 8;

/// A part over `f64`, eight of which form one of eight lanes.
pub trait Gather: Sized {
    /// The part over eight lanes.
    type Of<L: Lane>;

    /// In lane order; `None` if the parts differ in more than numbers.
    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>>;
}

impl Gather for f64 {
    type Of<L: Lane> = L;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<L> {
        Some(L::from_lanes(|lane| *all[lane]))
    }
}

impl<T: Gather, const N: usize> Gather for [T; N] {
    type Of<L: Lane> = [T::Of<L>; N];

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        let mut complete = true;
        let parts: [Option<T::Of<L>>; N] = core::array::from_fn(|i| {
            let part = T::gather(of_each!(all, |one| &one[i]));
            complete &= part.is_some();
            part
        });
        complete.then(|| parts.map(|part| part.expect("none is missing")))
    }
}

impl<T: Gather, U: Gather> Gather for (T, U) {
    type Of<L: Lane> = (T::Of<L>, U::Of<L>);

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        Some((T::gather(of_each!(all, |one| &one.0))?, U::gather(of_each!(all, |one| &one.1))?))
    }
}

impl<T: Gather> Gather for Option<T> {
    type Of<L: Lane> = Option<T::Of<L>>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        if all.iter().all(|one| one.is_none()) {
            return Some(None);
        }
        T::gather(of_each!(all, |one| one.as_ref()?)).map(Some)
    }
}

#[cfg(feature = "alloc")]
impl<T: Gather> Gather for Box<T> {
    type Of<L: Lane> = Box<T::Of<L>>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        T::gather(of_each!(all, |one| &**one)).map(Box::new)
    }
}

#[cfg(feature = "alloc")]
impl<T: Gather> Gather for Box<[T]> {
    type Of<L: Lane> = Box<[T::Of<L>]>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        let length = all[0].len();
        let equal = all.iter().all(|one| one.len() == length);
        equal.then(|| (0..length).map(|i| T::gather(of_each!(all, |one| &one[i]))).collect())?
    }
}

#[cfg(feature = "alloc")]
impl<T: Gather> Gather for Arc<[T]> {
    type Of<L: Lane> = Arc<[T::Of<L>]>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        let length = all[0].len();
        let equal = all.iter().all(|one| one.len() == length);
        equal.then(|| (0..length).map(|i| T::gather(of_each!(all, |one| &one[i]))).collect())?
    }
}

/// Combines truth values into a mask.
pub fn gather_mask<L: Lane>(all: [bool; LANES]) -> L::Mask {
    if all == [all[0]; LANES] {
        return L::Mask::splat(all[0]);
    }
    L::from_lanes(|lane| if all[lane] { 1.0 } else { 0.0 }).gt(L::splat(0.5))
}

#[cfg(feature = "alloc")]
/// True if all lists are equal.
pub fn same_list<T: PartialEq>(all: [&Arc<[T]>; LANES]) -> bool {
    all.iter().all(|one| Arc::ptr_eq(one, all[0]) || one == &all[0])
}
