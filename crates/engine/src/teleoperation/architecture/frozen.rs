//! The feedback force of an architecture while the slave is frozen.

use super::ArrivedAtMaster;
use trocar_core::lane::Lane;

/// While the received mode is "augmented" (slave frozen), the force is that of the last unfrozen tick plus the change
/// of the tissue force since.
#[derive(Debug, Clone)]
pub(super) struct FrozenForce<L> {
    /// At the last tick at which the slave was not frozen: the whole force, and the tissue force.
    whole_n: L,
    tissue_n: L,
}

impl<L: Lane> Default for FrozenForce<L> {
    fn default() -> Self {
        Self { whole_n: L::zero(), tissue_n: L::zero() }
    }
}

impl<L: Lane> FrozenForce<L> {
    /// The feedback force in N, given the law's `force_n`.
    #[inline(always)]
    pub(super) fn update(&mut self, force_n: L, arrived: &ArrivedAtMaster<L>) -> L {
        let is_frozen = arrived.mode.is_augmented();
        let tissue_n = arrived.sample.force_n;
        let held_n = self.whole_n + (tissue_n - self.tissue_n);
        self.whole_n = L::select(is_frozen, self.whole_n, force_n);
        self.tissue_n = L::select(is_frozen, self.tissue_n, tissue_n);
        L::select(is_frozen, held_n, force_n)
    }
}

trocar_core::lane::gather!(FrozenForce { whole_n, tissue_n });
