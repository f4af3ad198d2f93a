//! The automaton: (mode, alarm, g, tick) → mode.

use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

/// Mode of the supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// The slave follows the hand; the measured force is fed back.
    Teleoperation,
    /// The slave is frozen; the felt force drop is exaggerated.
    Augmented,
    /// Slave and force return to teleoperation.
    Reengaging,
}

impl Mode {
    /// Code of the mode in a trace: 0, 1, 2.
    #[must_use]
    pub fn code(self) -> f64 {
        match self {
            Self::Teleoperation => 0.0,
            Self::Augmented => 1.0,
            Self::Reengaging => 2.0,
        }
    }
}

crate::settings! {
    /// When augmentation begins and ends.
    ///
    /// `Teleoperation → Augmented` on an alarm, unless within `refractory_s` of the last event;
    /// `Augmented → Reengaging` after `min_hold_s`, once `g < exit_ratio · γ` for `exit_quiet_s` (the hysteresis that
    /// the paper requires), at the latest after `max_hold_s`; `Reengaging → Teleoperation` when force and position have
    /// blended.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct AutomatonSettings in "augmentation." {
        /// Minimum duration of the freeze.
        min_hold_s: f64 [NON_NEGATIVE] = 0.5,
        /// Maximum duration of the freeze.
        ///
        /// At least `min_hold_s`.
        max_hold_s: f64 [NON_NEGATIVE] = 1.0,
        /// Fraction of the threshold below which g counts as quiet.
        exit_ratio: f64 [POSITIVE_SHARE] = 0.5,
        /// How long g must be quiet before the slave is released.
        exit_quiet_s: f64 [NON_NEGATIVE] = 0.05,
        /// Refractory period after an event, in which alarms have no effect.
        refractory_s: f64 [NON_NEGATIVE] = 0.2,
    }
    where max_hold_s: |s| s.max_hold_s >= s.min_hold_s, "at least augmentation.min_hold_s";
}

/// The automaton.
#[derive(Debug, Clone)]
pub(super) struct Automaton<L: Lane> {
    min_hold_ticks: L,
    max_hold_ticks: L,
    exit_level: L,
    exit_quiet_ticks: L,
    refractory_ticks: L,
    blend_ticks: L,
    mode: L,
    /// Lanes in teleoperation.
    in_teleoperation: L::Mask,
    entered: L,
    quiet_ticks: L,
    refractory_until: L,
}

impl<L: Lane> Automaton<L> {
    /// An automaton in teleoperation, with a cross-fade of the force over `blend_s` (s).
    pub(super) fn new(settings: &AutomatonSettings, threshold: f64, blend_s: f64, tick_s: f64) -> Self {
        let ticks = |duration_s| L::splat(nearest_ticks(duration_s, tick_s) as f64);
        Self {
            min_hold_ticks: ticks(settings.min_hold_s),
            max_hold_ticks: ticks(settings.max_hold_s),
            exit_level: L::splat(settings.exit_ratio * threshold),
            exit_quiet_ticks: ticks(settings.exit_quiet_s),
            refractory_ticks: ticks(settings.refractory_s),
            blend_ticks: L::splat(blend_ticks(blend_s, tick_s)),
            mode: L::splat(Mode::Teleoperation.code()),
            in_teleoperation: L::Mask::splat(true),
            entered: L::zero(),
            quiet_ticks: L::zero(),
            refractory_until: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn mode(&self) -> L {
        self.mode
    }

    #[inline(always)]
    pub(super) fn is_teleoperation(&self) -> L::Mask {
        self.in_teleoperation
    }

    /// The mode for `tick`, given the tick's alarm and `g`, and whether the position had blended by the tick before.
    #[inline(always)]
    pub(super) fn step(&mut self, tick: u64, alarm: L::Mask, decision: L, blended: L::Mask) -> L {
        let now = L::splat(tick as f64);
        let mode = self.mode;
        let held = now - self.entered;

        let enter = is(mode, Mode::Teleoperation) & alarm & now.ge(self.refractory_until);
        let quiet = decision.lt(self.exit_level);
        let quiet_ticks = L::select(quiet, self.quiet_ticks + L::splat(1.0), L::zero());
        let settled = held.ge(self.min_hold_ticks) & quiet_ticks.ge(self.exit_quiet_ticks);
        let leave = is(mode, Mode::Augmented) & (settled | held.ge(self.max_hold_ticks));
        let blended_back = is(mode, Mode::Reengaging) & blended & held.ge(self.blend_ticks);

        self.quiet_ticks = quiet_ticks;
        // With this branch the code below does not wait for the alarm while the mode is unchanged.
        if (enter | leave | blended_back).any() {
            core::hint::cold_path();
            self.quiet_ticks = L::select(enter, L::zero(), quiet_ticks);
            self.entered = L::select(enter | leave, now, self.entered);
            self.refractory_until = L::select(blended_back, now + self.refractory_ticks, self.refractory_until);
            let code = |mode: Mode| L::splat(mode.code());
            self.mode = L::select(enter, code(Mode::Augmented), mode);
            self.mode = L::select(leave, code(Mode::Reengaging), self.mode);
            self.mode = L::select(blended_back, code(Mode::Teleoperation), self.mode);
            self.in_teleoperation = is(self.mode, Mode::Teleoperation);
        }
        self.mode
    }
}

/// Number of ticks of the cross-fade of the force, at least one.
pub(super) fn blend_ticks(blend_s: f64, tick_s: f64) -> f64 {
    nearest_ticks(blend_s, tick_s).max(1) as f64
}

/// Whether a mode's code is that of `which`.
#[inline(always)]
pub(super) fn is<L: Lane>(mode: L, which: Mode) -> L::Mask {
    (mode - L::splat(which.code())).abs().lt(L::splat(0.5))
}

/// The modes of the tick before and of this one, as codes.
#[derive(Debug, Clone, Copy)]
pub struct Modes<L> {
    /// [`Mode::code`] at the tick before.
    pub before: L,
    /// [`Mode::code`] now.
    pub now: L,
}

impl<L: Lane> Modes<L> {
    /// Lanes whose mode was `which` at the tick before.
    #[inline(always)]
    pub fn was(&self, which: Mode) -> L::Mask {
        is(self.before, which)
    }

    /// Lanes whose mode is `which`.
    #[inline(always)]
    pub fn is(&self, which: Mode) -> L::Mask {
        is(self.now, which)
    }

    /// Lanes whose mode has just become `which`.
    #[inline(always)]
    pub fn has_become(&self, which: Mode) -> L::Mask {
        self.is(which) & !self.was(which)
    }

    /// Whether the mode of any lane has changed.
    #[inline(always)]
    pub fn any_changed(&self) -> bool {
        (self.now - self.before).abs().gt(L::splat(0.5)).any()
    }
}

crate::lane::gather!(Automaton {
    min_hold_ticks, max_hold_ticks, exit_level, exit_quiet_ticks, refractory_ticks, blend_ticks, mode, entered, quiet_ticks,
    refractory_until,
} masks { in_teleoperation } stored);
