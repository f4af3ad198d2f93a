//! Who watches a run.

use super::Signals;
use crate::lane::Lane;

/// Sees each tick's signals.
pub trait Observer<L: Lane> {
    /// Whether runs under its eyes are so common that each kind of person and tissue is worth being compiled apart for them.
    #[inline(always)]
    fn is_common() -> bool
    where
        Self: Sized,
    {
        false
    }

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
    fn is_common() -> bool {
        true
    }

    #[inline(always)]
    fn observe(&mut self, _signals: &Signals<L>) {}
}

/// Sees what is lent to someone else for the run.
impl<L: Lane, O: Observer<L> + ?Sized> Observer<L> for &mut O {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<L>) {
        (**self).observe(signals);
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        (**self).is_done()
    }
}

/// Two observers: the second does not see the tick at which the first has seen enough, as where it finds that the run has
/// diverged.
impl<L: Lane, A: Observer<L>, B: Observer<L>> Observer<L> for (A, B) {
    #[inline(always)]
    fn is_common() -> bool {
        A::is_common() && B::is_common()
    }

    #[inline(always)]
    fn observe(&mut self, signals: &Signals<L>) {
        self.0.observe(signals);
        if !self.0.is_done() {
            self.1.observe(signals);
        }
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.0.is_done() || self.1.is_done()
    }
}
