//! Who watches a run.

use super::Signals;
use crate::lane::Lane;

/// Sees each tick's signals.
pub trait Observer<L: Lane> {
    /// Takes a tick's signals. A run's ticks come one by one, from 0 on.
    fn observe(&mut self, signals: &Signals<L>);

    /// Whether the run may end here.
    #[inline(always)]
    fn is_done(&self) -> bool {
        false
    }
}

/// Sees nothing: the bare tick.
impl<L: Lane> Observer<L> for () {
    #[inline(always)]
    fn observe(&mut self, _signals: &Signals<L>) {}
}

impl<L: Lane, A: Observer<L>, B: Observer<L>> Observer<L> for (A, B) {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<L>) {
        self.0.observe(signals);
        self.1.observe(signals);
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.0.is_done() || self.1.is_done()
    }
}
