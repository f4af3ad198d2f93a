//! The slave's reference: following the hand, frozen, or re-engaging.

use super::holds::{AnyHold, HeldTick, Hold, HoldSettings};
use super::mode::{Mode, ModeChange};
use crate::lane::Lane;

crate::choice! {
    /// Hold the slave at its measured position or at its last reference.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Freeze at "augmentation.freeze" = Measured {
        /// Its measured position at the alarm.
        "measured" => Measured,
        /// Its last reference before the alarm, which the slave may not have reached.
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
        /// The gap closes at a bounded speed until the force rises; the remaining gap is kept.
        "ramp-until-load" => RampUntilLoad in "augmentation." {
            /// Speed at which a ramp until load closes the gap, in addition to the hand's motion.
            approach_speed_m_per_s: f64 [POSITIVE] = 0.03,
            /// Rise of the measured force, above its minimum while re-engaging, at which the ramp until load stops.
            stop_rise_n: f64 [POSITIVE] = 0.3,
        },
        /// The gap is kept: the slave continues from its frozen position.
        "clutch" => Clutch,
        /// The gap closes at once, which throws the needle. Included to show the danger.
        "snap" => Snap,
    }
}

/// Gives the slave's reference in every mode.
///
/// A user-defined law implements this trait for `f64`; [`HeldReference`] implements it for any number of lanes.
pub trait MotionLaw<L: Lane> {
    /// The slave's reference in m in teleoperation. `hand_m` is scaled to the slave, `slave_m` is measured.
    fn follow(&mut self, hand_m: L, slave_m: L) -> L;

    /// The slave's reference in m in any mode, from the same positions.
    fn update(&mut self, modes: ModeChange<L>, hand_m: L, slave_m: L) -> L;

    /// Receives the measured force (N) at a tick of an event, before [`update`](MotionLaw::update).
    fn sense(&mut self, _force_n: L) {}

    /// The lanes in which the law has finished closing the gap, so re-engaging may end.
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

/// The slave's reference, `x_ref = hand + gap`.
///
/// In teleoperation the gap is 0 or the offset left by a clutch. At the release it is set such that the reference does
/// not jump; a ramp then reduces it by `speed · tick` per tick.
#[derive(Debug, Clone)]
pub struct HeldReference<L> {
    freeze: Freeze,
    hold: AnyHold<L>,
    reengage: Reengage,
    force: L,
    /// The smallest force since the release, and the rise above it that stops a ramp until load; infinite for other
    /// kinds.
    min_force: L,
    stop_rise: L,
    closing_step: L,
    gap: L,
    frozen: L,
    last: L,
}

impl<L: Lane> HeldReference<L> {
    /// Creates a law for ticks of `tick_s` and a slave at the reference `reference` (m).
    #[must_use]
    pub fn new(freeze: Freeze, reengage: Reengage, tick_s: f64, reference: L) -> Self {
        let (speed, stop_rise) = match reengage {
            Reengage::Ramp { catch_up_speed_m_per_s } => (catch_up_speed_m_per_s, f64::INFINITY),
            Reengage::RampUntilLoad { approach_speed_m_per_s, stop_rise_n } => (approach_speed_m_per_s, stop_rise_n),
            Reengage::Clutch | Reengage::Snap => (0.0, f64::INFINITY),
        };
        Self {
            freeze,
            hold: AnyHold::new(&HoldSettings::Frozen, tick_s),
            reengage,
            force: L::zero(),
            min_force: L::zero(),
            stop_rise: L::splat(stop_rise),
            closing_step: L::splat(speed * tick_s),
            gap: L::zero(),
            frozen: reference,
            last: reference,
        }
    }

    /// Replaces the freeze by another hold, for ticks of `tick_s`.
    #[must_use]
    pub fn holding(self, hold: &HoldSettings, tick_s: f64) -> Self {
        Self { hold: AnyHold::new(hold, tick_s), ..self }
    }

    /// The hold's reference for a slave whose reference without the event is `followed`.
    #[inline(always)]
    fn held(&self, followed: L) -> L {
        self.hold.reference_m(&HeldTick { anchor_m: self.frozen, last_m: self.last, hand_m: followed })
    }

    #[inline(always)]
    fn is_loaded(&self) -> L::Mask {
        (self.force - self.min_force).ge(self.stop_rise)
    }
}

impl<L: Lane> MotionLaw<L> for HeldReference<L> {
    #[inline(always)]
    fn follow(&mut self, hand: L, _slave: L) -> L {
        self.last = hand + self.gap;
        self.last
    }

    #[inline(always)]
    fn sense(&mut self, force: L) {
        self.force = force;
    }

    #[inline(always)]
    fn is_blended(&self) -> L::Mask {
        match self.reengage {
            Reengage::Ramp { .. } => self.gap.abs().le(L::zero()),
            Reengage::RampUntilLoad { .. } => self.gap.abs().le(L::zero()) | self.is_loaded(),
            Reengage::Clutch | Reengage::Snap => L::zero().le(L::zero()),
        }
    }

    #[inline(always)]
    fn update(&mut self, modes: ModeChange<L>, hand: L, slave: L) -> L {
        let mut reengaging = self.gap - self.gap.clamp(-self.closing_step, self.closing_step);
        if modes.any_changed() {
            core::hint::cold_path();
            let held = match self.freeze {
                Freeze::Measured => slave,
                Freeze::Reference => self.last,
            };
            self.frozen = L::select(modes.has_become(Mode::Augmented), held, self.frozen);
            let opened = match self.reengage {
                Reengage::Snap => L::zero(),
                // The gap starts at the hold's reference, so the reference does not jump.
                Reengage::Ramp { .. } | Reengage::RampUntilLoad { .. } | Reengage::Clutch => {
                    self.held(hand + self.gap) - hand
                }
            };
            reengaging = L::select(modes.has_become(Mode::Reengaging), opened, reengaging);
            self.last = L::select(modes.has_become(Mode::Augmented), self.frozen, self.last);
            self.min_force = L::select(modes.has_become(Mode::Reengaging), self.force, self.min_force);
        }
        self.min_force = self.force.min(self.min_force);
        let keeps_gap = self.is_loaded() & modes.before.is_reengaging();
        // A stopped ramp does not restart.
        self.min_force = L::select(keeps_gap, L::splat(f64::NEG_INFINITY), self.min_force);
        reengaging = L::select(keeps_gap, self.gap, reengaging);
        self.gap = L::select(modes.now.is_reengaging(), reengaging, self.gap);
        let followed = hand + self.gap;
        let held = self.held(followed);
        self.last = L::select(modes.now.is_augmented(), held, followed);
        self.last
    }
}

crate::lane::gather!(HeldReference { hold, force, min_force, stop_rise, closing_step, gap, frozen, last } kinds { freeze, reengage } stored);
