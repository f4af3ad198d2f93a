use crate::lane::{Lane, Mask};

/// Mode of the supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// The slave follows the hand.
    Teleoperation = 0,
    /// The slave is frozen.
    Augmented = 1,
    /// The slave returns to the hand.
    Reengaging = 2,
}

impl Mode {
    /// Code in traces and messages.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

/// The mode in each lane.
///
/// ```
/// use trocar_core::augmentation::{Mode, Modes};
///
/// let modes = Modes::<f64>::splat(Mode::Augmented);
/// assert!(modes.is_augmented() && !modes.is_teleoperation());
/// assert_eq!(modes.lane(0), Mode::Augmented);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes<L> {
    code: L,
}

impl<L: Lane> Modes<L> {
    /// Equal in every lane.
    #[inline(always)]
    #[must_use]
    pub fn splat(mode: Mode) -> Self {
        Self { code: L::splat(f64::from(mode.code())) }
    }

    /// Inverts [`Modes::codes`].
    #[inline(always)]
    #[must_use]
    pub fn from_codes(code: L) -> Self {
        Self { code }
    }

    /// [`Mode::code`] of each lane.
    #[inline(always)]
    #[must_use]
    pub fn codes(self) -> L {
        self.code
    }

    /// Replaces the mode in the lanes of the mask.
    #[inline(always)]
    #[must_use]
    pub fn set_where(self, mask: L::Mask, mode: Mode) -> Self {
        Self { code: L::select(mask, Self::splat(mode).code, self.code) }
    }

    /// The mode of a lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(self, index: usize) -> Mode {
        let code = self.code.lane(index);
        if code < 0.5 {
            Mode::Teleoperation
        } else if code < 1.5 {
            Mode::Augmented
        } else {
            Mode::Reengaging
        }
    }

    /// Replaces the mode of a lane.
    #[inline(always)]
    #[must_use]
    pub fn with_lane(self, index: usize, mode: Mode) -> Self {
        Self { code: self.code.with_lane(index, f64::from(mode.code())) }
    }

    #[inline(always)]
    fn is(self, which: Mode) -> L::Mask {
        (self.code - Self::splat(which).code).abs().lt(L::splat(0.5))
    }

    /// Lanes in teleoperation.
    #[inline(always)]
    #[must_use]
    pub fn is_teleoperation(self) -> L::Mask {
        self.code.lt(L::splat(0.5))
    }

    /// Lanes that are frozen.
    #[inline(always)]
    #[must_use]
    pub fn is_augmented(self) -> L::Mask {
        self.is(Mode::Augmented)
    }

    /// Lanes that are re-engaging.
    #[inline(always)]
    #[must_use]
    pub fn is_reengaging(self) -> L::Mask {
        self.is(Mode::Reengaging)
    }

    /// Lanes that differ.
    #[inline(always)]
    #[must_use]
    pub fn differs(self, other: Self) -> L::Mask {
        (self.code - other.code).abs().gt(L::splat(0.5))
    }
}

crate::lane::gather!(Modes { code } stored);

/// Modes of two consecutive ticks.
#[derive(Debug, Clone, Copy)]
pub struct ModeChange<L> {
    /// At the previous tick.
    pub before: Modes<L>,
    /// At this tick.
    pub now: Modes<L>,
}

impl<L: Lane> ModeChange<L> {
    /// Lanes that have just become `which`.
    #[inline(always)]
    #[must_use]
    pub fn has_become(&self, which: Mode) -> L::Mask {
        self.now.is(which) & !self.before.is(which)
    }

    /// True if any lane has changed.
    #[inline(always)]
    #[must_use]
    pub fn any_changed(&self) -> bool {
        self.now.differs(self.before).any()
    }
}
