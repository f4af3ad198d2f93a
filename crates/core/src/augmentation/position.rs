use super::holds::{AnyHold, HeldTick, Hold, HoldSettings};
use super::mode::{Mode, ModeChange};
use super::returns::{AnyReturn, Reengage, Return, ReturnTick};
use crate::lane::{Lane, Mask};

crate::choice! {
    /// Hold the slave at its measured position or at its last reference.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Freeze at "augmentation.freeze" = Measured {
        "measured" => Measured,
        "reference" => Reference,
    }
}

/// User-defined laws implement it for `f64`.
pub trait MotionLaw<L: Lane> {
    /// In m, in teleoperation; `hand_m` is scaled to the slave, `slave_m` is measured.
    fn follow(&mut self, hand_m: L, slave_m: L) -> L;

    /// In m, in any mode.
    fn update(&mut self, modes: ModeChange<L>, hand_m: L, slave_m: L) -> L;

    /// Receives the measured force (N) before [`update`](MotionLaw::update).
    fn sense(&mut self, _force_n: L) {}

    /// Lanes that may end re-engaging.
    fn is_blended(&self) -> L::Mask;
}

#[cfg(feature = "alloc")]
impl<L: Lane, M: MotionLaw<L> + ?Sized> MotionLaw<L> for alloc::boxed::Box<M> {
    fn follow(&mut self, hand_m: L, slave_m: L) -> L {
        (**self).follow(hand_m, slave_m)
    }

    fn update(&mut self, modes: ModeChange<L>, hand_m: L, slave_m: L) -> L {
        (**self).update(modes, hand_m, slave_m)
    }

    fn sense(&mut self, force_n: L) {
        (**self).sense(force_n);
    }

    fn is_blended(&self) -> L::Mask {
        (**self).is_blended()
    }
}

/// `x_ref = hand + gap`, with a gap such that the reference does not jump at the release.
#[derive(Debug, Clone)]
pub struct HeldReference<L> {
    freeze: Freeze,
    hold: AnyHold<L>,
    back: AnyReturn<L>,
    force: L,
    gap: L,
    hand: L,
    frozen: L,
    last: L,
}

impl<L: Lane> HeldReference<L> {
    /// For ticks of `tick_s` and a slave at `reference` (m).
    #[must_use]
    pub fn new(freeze: Freeze, reengage: Reengage, tick_s: f64, reference: L) -> Self {
        Self {
            freeze,
            hold: AnyHold::new(&HoldSettings::Frozen, tick_s),
            back: AnyReturn::new(&reengage, tick_s),
            force: L::zero(),
            gap: L::zero(),
            hand: reference,
            frozen: reference,
            last: reference,
        }
    }

    /// Replaces the freeze by another hold.
    #[must_use]
    pub fn holding(self, hold: &HoldSettings, tick_s: f64) -> Self {
        Self { hold: AnyHold::new(hold, tick_s), ..self }
    }

    #[inline(always)]
    fn held(&self, followed: L) -> L {
        self.hold.reference_m(&HeldTick { anchor_m: self.frozen, last_m: self.last, hand_m: followed })
    }

    #[inline(always)]
    fn returned(&mut self, gap_m: L, hand: L, begins: L::Mask) -> L {
        let now = ReturnTick { gap_m, hand_step_m: hand - self.hand, force_n: self.force, begins };
        self.hand = hand;
        self.back.gap_m(&now)
    }
}

impl<L: Lane> MotionLaw<L> for HeldReference<L> {
    #[inline(always)]
    fn follow(&mut self, hand: L, _slave: L) -> L {
        if self.back.continues() {
            self.gap = self.returned(self.gap, hand, L::Mask::splat(false));
        }
        self.last = hand + self.gap;
        self.last
    }

    #[inline(always)]
    fn sense(&mut self, force: L) {
        self.force = force;
    }

    #[inline(always)]
    fn is_blended(&self) -> L::Mask {
        self.back.may_end(self.gap)
    }

    #[inline(always)]
    fn update(&mut self, modes: ModeChange<L>, hand: L, slave: L) -> L {
        let begins = modes.has_become(Mode::Reengaging);
        let mut gap = self.gap;
        if modes.any_changed() {
            core::hint::cold_path();
            let held = match self.freeze {
                Freeze::Measured => slave,
                Freeze::Reference => self.last,
            };
            self.frozen = L::select(modes.has_become(Mode::Augmented), held, self.frozen);
            gap = L::select(begins, self.held(hand + self.gap) - hand, gap);
            self.last = L::select(modes.has_become(Mode::Augmented), self.frozen, self.last);
        }
        let returned = self.returned(gap, hand, begins);
        self.gap = L::select(modes.now.is_augmented(), self.gap, returned);
        let followed = hand + self.gap;
        let held = self.held(followed);
        self.last = L::select(modes.now.is_augmented(), held, followed);
        self.last
    }
}

crate::lane::gather!(HeldReference { hold, back, force, gap, hand, frozen, last } kinds { freeze } stored);
