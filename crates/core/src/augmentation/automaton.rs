use super::mode::{Mode, Modes};
use crate::lane::{Lane, Mask};
use crate::time::nearest_ticks;

crate::settings! {
    /// When augmentation begins and ends.
    ///
    /// - `Teleoperation → Augmented` on an alarm.
    /// - `Augmented → Reengaging` after `min_hold_s`, once `g < exit_ratio · γ` for `exit_quiet_s`, at the latest after
    ///   `max_hold_s`.
    /// - `Reengaging → Teleoperation` when force and position have blended.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct AutomatonSettings in "augmentation." {
        /// Minimum duration of the freeze.
        min_hold_s: f64 [NON_NEGATIVE] = 0.5,
        /// Maximum duration of the freeze.
        max_hold_s: f64 [NON_NEGATIVE] = 1.0,
        /// Fraction of the threshold below which g counts as quiet.
        exit_ratio: f64 [POSITIVE_SHARE] = 0.5,
        /// Time for which g must be quiet before the slave is released.
        exit_quiet_s: f64 [NON_NEGATIVE] = 0.05,
        /// Refractory period after an event, in which alarms have no effect.
        refractory_s: f64 [NON_NEGATIVE] = 0.2,
    }
    where max_hold_s: |s| s.max_hold_s >= s.min_hold_s, "at least augmentation.min_hold_s";
}

#[derive(Debug, Clone)]
pub(super) struct Automaton<L: Lane> {
    min_hold_ticks: L,
    max_hold_ticks: L,
    exit_level: L,
    exit_quiet_ticks: L,
    refractory_ticks: L,
    blend_ticks: L,
    mode: Modes<L>,
    in_teleoperation: L::Mask,
    entered: L,
    quiet_ticks: L,
    refractory_until: L,
}

impl<L: Lane> Automaton<L> {
    pub(super) fn new(settings: &AutomatonSettings, threshold: f64, blend_s: f64, tick_s: f64) -> Self {
        let ticks = |duration_s| L::splat(nearest_ticks(duration_s, tick_s) as f64);
        Self {
            min_hold_ticks: ticks(settings.min_hold_s),
            max_hold_ticks: ticks(settings.max_hold_s),
            exit_level: L::splat(settings.exit_ratio * threshold),
            exit_quiet_ticks: ticks(settings.exit_quiet_s),
            refractory_ticks: ticks(settings.refractory_s),
            blend_ticks: L::splat(blend_ticks(blend_s, tick_s)),
            mode: Modes::splat(Mode::Teleoperation),
            in_teleoperation: L::Mask::splat(true),
            entered: L::zero(),
            quiet_ticks: L::zero(),
            refractory_until: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn mode(&self) -> Modes<L> {
        self.mode
    }

    #[inline(always)]
    pub(super) fn is_teleoperation(&self) -> L::Mask {
        self.in_teleoperation
    }

    #[inline(always)]
    pub(super) fn step(&mut self, tick: u64, alarm: L::Mask, decision: L, blended: L::Mask) -> Modes<L> {
        let now = L::splat(tick as f64);
        let mode = self.mode;
        let held = now - self.entered;

        let enter = mode.is_teleoperation() & alarm & now.ge(self.refractory_until);
        let quiet = decision.lt(self.exit_level);
        let quiet_ticks = L::select(quiet, self.quiet_ticks + L::splat(1.0), L::zero());
        let settled = held.ge(self.min_hold_ticks) & quiet_ticks.ge(self.exit_quiet_ticks);
        let leave = mode.is_augmented() & (settled | held.ge(self.max_hold_ticks));
        let blended_back = mode.is_reengaging() & blended & held.ge(self.blend_ticks);

        self.quiet_ticks = quiet_ticks;
        // Removes the dependency on the alarm while the mode is unchanged.
        if (enter | leave | blended_back).any() {
            core::hint::cold_path();
            self.quiet_ticks = L::select(enter, L::zero(), quiet_ticks);
            self.entered = L::select(enter | leave, now, self.entered);
            self.refractory_until = L::select(blended_back, now + self.refractory_ticks, self.refractory_until);
            self.mode = mode
                .set_where(enter, Mode::Augmented)
                .set_where(leave, Mode::Reengaging)
                .set_where(blended_back, Mode::Teleoperation);
            self.in_teleoperation = self.mode.is_teleoperation();
        }
        self.mode
    }
}

pub(super) fn blend_ticks(blend_s: f64, tick_s: f64) -> f64 {
    nearest_ticks(blend_s, tick_s).max(1) as f64
}

crate::lane::gather!(Automaton {
    min_hold_ticks, max_hold_ticks, exit_level, exit_quiet_ticks, refractory_ticks, blend_ticks, mode, entered, quiet_ticks,
    refractory_until,
} masks { in_teleoperation } stored);
