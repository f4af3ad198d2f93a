//! The slave does not move: the freeze of section 5.1.

use super::{HeldTick, Hold};
use crate::lane::Lane;

/// `x_ref = anchor`.
#[derive(Debug, Clone, Copy)]
pub struct Frozen;

impl<L: Lane> Hold<L> for Frozen {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.anchor_m
    }
}
