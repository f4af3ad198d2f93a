use core::marker::PhantomData;

use super::{BuiltIn, HeldTick, Hold, HoldMap};
use crate::lane::Lane;

/// `x_ref = anchor` (section 5.1).
#[derive(Debug, Clone)]
pub struct Frozen<L>(PhantomData<L>);

impl<L: Lane> BuiltIn for Frozen<L> {
    type Settings = ();
    type Map = HoldMap;

    fn build(_settings: &(), _tick_s: f64) -> Self {
        Self(PhantomData)
    }

    fn map(_settings: &()) -> Option<HoldMap> {
        Some(HoldMap::Frozen)
    }
}

impl<L: Lane> Hold<L> for Frozen<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.anchor_m
    }
}

crate::lane::gather_nothing!(Frozen);
