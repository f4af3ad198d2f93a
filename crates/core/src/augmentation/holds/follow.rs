use core::marker::PhantomData;

use super::{BuiltIn, HeldTick, Hold, HoldMap};
use crate::lane::Lane;

/// `x_ref = hand`.
#[derive(Debug, Clone)]
pub struct Following<L>(PhantomData<L>);

impl<L: Lane> BuiltIn for Following<L> {
    type Settings = ();
    type Map = HoldMap;

    fn build(_settings: &(), _tick_s: f64) -> Self {
        Self(PhantomData)
    }

    fn map(_settings: &()) -> Option<HoldMap> {
        Some(HoldMap::Following)
    }
}

impl<L: Lane> Hold<L> for Following<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.hand_m
    }
}

crate::lane::gather_nothing!(Following);
