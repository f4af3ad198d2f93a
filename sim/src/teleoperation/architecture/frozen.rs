//! The force of an architecture while the slave is frozen.

use super::ArrivedAtMaster;
use crate::lane::Lane;

/// While the arrived mode says that the slave is frozen, the force is that of the last tick before, and changes with the
/// tissue's alone.
#[derive(Debug, Clone)]
pub(super) struct FrozenForce<L> {
    /// Of the last tick at which the slave was not frozen: the whole force, and the tissue's in it.
    whole_n: L,
    tissue_n: L,
}

impl<L: Lane> Default for FrozenForce<L> {
    fn default() -> Self {
        Self { whole_n: L::zero(), tissue_n: L::zero() }
    }
}

impl<L: Lane> FrozenForce<L> {
    /// The force in N, where the law gives `force_n`.
    #[inline(always)]
    pub(super) fn update(&mut self, force_n: L, arrived: &ArrivedAtMaster<L>) -> L {
        let is_frozen = (arrived.mode - L::splat(1.0)).abs().lt(L::splat(0.5));
        let tissue_n = arrived.sample.force_n;
        let held_n = self.whole_n + (tissue_n - self.tissue_n);
        self.whole_n = L::select(is_frozen, self.whole_n, force_n);
        self.tissue_n = L::select(is_frozen, self.tissue_n, tissue_n);
        L::select(is_frozen, held_n, force_n)
    }
}

crate::lane::gather!(FrozenForce { whole_n, tissue_n });
