use core::marker::PhantomData;

use super::{BuiltIn, Return, ReturnMap, ReturnTick};
use crate::lane::Lane;

/// Closes the gap at once.
#[derive(Debug, Clone)]
pub struct Snap<L>(PhantomData<L>);

impl<L: Lane> BuiltIn for Snap<L> {
    type Settings = ();
    type Map = ReturnMap;

    fn build(_settings: &(), _tick_s: f64) -> Self {
        Self(PhantomData)
    }

    fn map(_settings: &()) -> Option<ReturnMap> {
        Some(ReturnMap::Jumps)
    }
}

impl<L: Lane> Return<L> for Snap<L> {
    #[inline(always)]
    fn gap_m(&mut self, _now: &ReturnTick<L>) -> L {
        L::zero()
    }
}

crate::lane::gather_nothing!(Snap);
