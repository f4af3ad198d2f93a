//! The slave's reference: following the hand, frozen, or returning to it.

use super::automaton::{Mode, Modes};
use crate::lane::Lane;

crate::choice! {
    /// Hold the slave at its measured position or at its last reference.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Freeze at "augmentation.freeze" = Measured {
        /// At its measured position at the alarm.
        "measured" => Measured,
        /// At the last reference before the alarm, which the slave may not have reached.
        "reference" => Reference,
    }
}

crate::choice! {
    /// Close the gap to the hand at a bounded speed, keep it, or close it at once.
    ///
    /// During the freeze the hand moves on by millimetres.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Reengage at "augmentation.reengage" = Ramp {
        /// The gap closes at a bounded speed, in addition to the hand's motion.
        "ramp" => Ramp in "augmentation." {
            /// Speed at which a ramp closes the gap, in addition to the hand's motion.
            catch_up_speed_m_per_s: f64 [POSITIVE] = 0.03,
        },
        /// The gap is kept: the slave continues from its frozen position.
        "clutch" => Clutch,
        /// The gap closes at once and throws the needle; included to show the danger.
        "snap" => Snap,
    }
}

/// Gives the slave's reference in every mode.
///
/// A user-defined law implements this for `f64`; [`HeldReference`] for any number of lanes.
pub trait MotionLaw<L: Lane> {
    /// The slave's reference in m in teleoperation, for a hand at `hand_m` (m, scaled to the slave).
    fn follow(&mut self, hand_m: L) -> L;

    /// The slave's reference in m in any mode, for a slave measured at `slave_m` (m).
    fn update(&mut self, modes: Modes<L>, hand_m: L, slave_m: L) -> L;

    /// Whether the law has closed the gap as far as it does, so that re-engaging may end.
    fn is_blended(&self) -> L::Mask;
}

#[cfg(feature = "alloc")]
impl<L: Lane, M: MotionLaw<L> + ?Sized> MotionLaw<L> for alloc::boxed::Box<M> {
    fn follow(&mut self, hand_m: L) -> L {
        (**self).follow(hand_m)
    }

    fn update(&mut self, modes: Modes<L>, hand_m: L, slave_m: L) -> L {
        (**self).update(modes, hand_m, slave_m)
    }

    fn is_blended(&self) -> L::Mask {
        (**self).is_blended()
    }
}

/// The slave's reference, `x_ref = hand + gap`.
///
/// In teleoperation the gap is 0 or the offset left by a clutch. At the end of the freeze it is set so that the
/// reference does not jump; a ramp then reduces its magnitude by `speed · tick` at each tick.
#[derive(Debug, Clone)]
pub struct HeldReference<L> {
    freeze: Freeze,
    reengage: Reengage,
    closing_step: L,
    gap: L,
    frozen: L,
    last: L,
}

impl<L: Lane> HeldReference<L> {
    /// A law on ticks `tick_s` apart (s), for a slave at the reference `reference` (m).
    #[must_use]
    pub fn new(freeze: Freeze, reengage: Reengage, tick_s: f64, reference: L) -> Self {
        let speed = if let Reengage::Ramp { catch_up_speed_m_per_s } = reengage { catch_up_speed_m_per_s } else { 0.0 };
        Self {
            freeze,
            reengage,
            closing_step: L::splat(speed * tick_s),
            gap: L::zero(),
            frozen: reference,
            last: reference,
        }
    }
}

impl<L: Lane> MotionLaw<L> for HeldReference<L> {
    #[inline(always)]
    fn follow(&mut self, hand: L) -> L {
        self.last = hand + self.gap;
        self.last
    }

    #[inline(always)]
    fn is_blended(&self) -> L::Mask {
        match self.reengage {
            Reengage::Ramp { .. } => self.gap.abs().le(L::zero()),
            Reengage::Clutch | Reengage::Snap => L::zero().le(L::zero()),
        }
    }

    #[inline(always)]
    fn update(&mut self, modes: Modes<L>, hand: L, slave: L) -> L {
        let mut reengaging = self.gap - self.gap.clamp(-self.closing_step, self.closing_step);
        if modes.any_changed() {
            core::hint::cold_path();
            let held = match self.freeze {
                Freeze::Measured => slave,
                Freeze::Reference => self.last,
            };
            self.frozen = L::select(modes.has_become(Mode::Augmented), held, self.frozen);
            let opened = match self.reengage {
                Reengage::Ramp { .. } | Reengage::Clutch => self.frozen - hand,
                Reengage::Snap => L::zero(),
            };
            reengaging = L::select(modes.has_become(Mode::Reengaging), opened, reengaging);
        }
        self.gap = L::select(modes.is(Mode::Reengaging), reengaging, self.gap);
        self.last = L::select(modes.is(Mode::Augmented), self.frozen, hand + self.gap);
        self.last
    }
}

crate::lane::gather!(HeldReference { closing_step, gap, frozen, last } same { freeze } kinds { reengage });
