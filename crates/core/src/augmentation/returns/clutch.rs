use core::marker::PhantomData;

use super::{BuiltIn, Return, ReturnMap, ReturnTick};
use crate::lane::Lane;

/// Keeps the gap.
#[derive(Debug, Clone)]
pub struct Clutch<L>(PhantomData<L>);

impl<L: Lane> BuiltIn for Clutch<L> {
    type Settings = ();
    type Map = ReturnMap;

    fn build(_settings: &(), _tick_s: f64) -> Self {
        Self(PhantomData)
    }

    fn map(_settings: &()) -> Option<ReturnMap> {
        Some(ReturnMap::Keeps)
    }
}

impl<L: Lane> Return<L> for Clutch<L> {
    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        now.gap_m
    }
}

crate::lane::gather_nothing!(Clutch);
