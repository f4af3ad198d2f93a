//! The slave follows the hand as before: only the force or a cue tells of the event.

use super::{HeldTick, Hold};
use crate::lane::Lane;

/// `x_ref = hand`.
#[derive(Debug, Clone, Copy)]
pub struct Following;

impl<L: Lane> Hold<L> for Following {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.hand_m
    }
}
