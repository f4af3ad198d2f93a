//! Observers of a run.

use super::{SelectedSignals, Signals};
use trocar_core::lane::Lane;

/// Receives the signals of each tick.
pub trait Observer<L: Lane> {
    /// Receives the signals of a tick, in order from tick 0.
    fn observe(&mut self, signals: &Signals<L>);

    /// True if the run may end at this tick.
    #[inline(always)]
    fn is_done(&self) -> bool {
        false
    }
}

/// Ignores all signals.
impl<L: Lane> Observer<L> for () {
    #[inline(always)]
    fn observe(&mut self, _signals: &Signals<L>) {}
}

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

/// Receives the [`SelectedSignals`] of each tick. Called dynamically, so the tick is compiled once.
pub trait EventObserver<L: Lane> {
    /// See [`Observer::observe`].
    fn observe(&mut self, selected: &SelectedSignals<L>);
}

impl<L: Lane> EventObserver<L> for () {
    fn observe(&mut self, _selected: &SelectedSignals<L>) {}
}

/// An optional [`EventObserver`].
pub struct Additional<'a, L: Lane>(pub Option<&'a mut dyn EventObserver<L>>);

impl<L: Lane> Observer<L> for Additional<'_, L> {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<L>) {
        if let Some(observer) = &mut self.0 {
            observer.observe(&SelectedSignals::of(signals));
        }
    }
}

/// When the first observer is done, for example because the run has diverged, the second does not receive that tick.
impl<L: Lane, A: Observer<L>, B: Observer<L>> Observer<L> for (A, B) {
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
