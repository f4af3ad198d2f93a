use super::{SelectedSignals, Signals};
use trocar_core::lane::Lane;

pub trait Observer<L: Lane> {
    fn observe(&mut self, signals: &Signals<L>);

    #[inline(always)]
    fn is_done(&self) -> bool {
        false
    }
}

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

/// Dynamic calls: the tick is compiled once.
pub trait EventObserver<L: Lane> {
    fn observe(&mut self, selected: &SelectedSignals<L>);
}

impl<L: Lane> EventObserver<L> for () {
    fn observe(&mut self, _selected: &SelectedSignals<L>) {}
}

pub struct Additional<'a, L: Lane>(pub Option<&'a mut dyn EventObserver<L>>);

impl<L: Lane> Observer<L> for Additional<'_, L> {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<L>) {
        if let Some(observer) = &mut self.0 {
            observer.observe(&SelectedSignals::of(signals));
        }
    }
}

/// The second one does not receive the tick of a divergence.
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
