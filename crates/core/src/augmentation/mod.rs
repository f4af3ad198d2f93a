//! Event-based haptic augmentation (section 5.1).

mod automaton;
mod force;
mod force_laws;
mod holds;
mod mode;
mod position;
mod returns;

pub use automaton::AutomatonSettings;
pub use force::cross_fade;
pub use force_laws::{
    Amplify, AmplifySettings, AnyForceLaw, AugmentedTick, Damp, DampSettings, Decay, DecaySettings, ForceLaw,
    ForceLawSettings, ForceMap, Guide, GuideSettings,
};
pub use holds::{
    AnyHold, Following, ForbiddenRegion, ForbiddenRegionSettings, Frozen, HeldTick, Hold, HoldMap, HoldSettings,
    SpeedLimit, SpeedLimitSettings, Yielding, YieldingSettings,
};
pub use mode::{Mode, ModeChange, Modes};
pub use position::{Freeze, HeldReference, MotionLaw};
pub use returns::{
    AnyReturn, Clutch, Fade, FadeSettings, Ramp, RampSettings, RampUntilLoad, RampUntilLoadSettings, Reengage, Return,
    ReturnMap, ReturnTick, Snap, WhenStill, WhenStillSettings,
};

use crate::lane::{Gather, LANES, Lane, Mask, Stored, gather_mask, of_each};
use crate::settings::ActsFor;
use automaton::Automaton;
use force::ForceFeedback;

/// For keys that act only with augmentation.
pub const WHEN_ENABLED: ActsFor = ActsFor::new("augmentation.enabled", &["true"]);

const WHEN_HELD: ActsFor = ActsFor::all_but(HoldSettings::KEY.path, HoldSettings::WORDS, "none");

crate::settings! {
    /// Settings of the supervisor.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct AugmentationSettings in "augmentation." {
        /// Enables augmentation; false gives the classical scheme.
        enabled: bool = true,
        /// Where the slave is held.
        freeze: Freeze for (WHEN_HELD),
        /// Kind of hold.
        hold: HoldSettings for (WHEN_ENABLED),
        /// How the slave returns to the hand.
        reengage: Reengage for (WHEN_HELD),
        /// Force law of an event.
        force: ForceLawSettings for (WHEN_ENABLED),
        /// Marks the event by a vibration on the operator's skin.
        cue: bool for (WHEN_ENABLED) = false,
        /// Duration of the cross-fade back to the measured force.
        blend_s: f64 [NON_NEGATIVE] for (WHEN_ENABLED) = 0.1,
        /// When an event begins and ends.
        automaton: AutomatonSettings for (WHEN_ENABLED),
    }
}

trait BuiltIn {
    type Settings;
    type Map;

    fn build(settings: &Self::Settings, tick_s: f64) -> Self;

    /// `None` if the certificate does not cover it.
    fn map(_settings: &Self::Settings) -> Option<Self::Map> {
        None
    }
}

/// Inputs at a tick.
#[derive(Debug, Clone, Copy)]
pub struct SupervisorInput<L: Lane> {
    /// Number of the tick.
    pub tick: u64,
    /// Lanes with an alarm.
    pub alarm: L::Mask,
    /// `g_k`.
    pub decision: L,
    /// Scaled to the slave.
    pub hand_m: L,
    /// Measured.
    pub slave_m: L,
    /// Measured, on the slave's side.
    pub force_n: L,
}

/// Commands at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Command<L: Lane> {
    /// Mode of each lane.
    pub mode: Modes<L>,
    /// In m.
    pub slave_reference_m: L,
    /// In N.
    pub feedback_force_n: L,
    /// Largest allowed change since the last tick.
    pub allowed_step_n: L,
    /// Lanes in which an alarm began an event; without augmentation, lanes with an alarm.
    pub alarm_taken: L::Mask,
}

/// Commands on the slave's side.
#[derive(Debug, Clone, Copy)]
pub struct SlaveCommand<L: Lane> {
    /// Mode of each lane.
    pub mode: Modes<L>,
    /// In m.
    pub slave_reference_m: L,
    /// See [`Command::alarm_taken`].
    pub alarm_taken: L::Mask,
}

/// Over a link, [`decide`](Supervisor::decide) runs on the slave's side, [`feedback_force`](Supervisor::feedback_force)
/// on the master's.
#[derive(Debug, Clone)]
pub struct Supervisor<L: Lane, M = HeldReference<L>, F = AnyForceLaw<L>> {
    enabled: L::Mask,
    gives_cue: L::Mask,
    automaton: Automaton<L>,
    motion: M,
    feedback: ForceFeedback<L, F>,
}

impl<L: Lane> Supervisor<L> {
    /// Starts in teleoperation at `reference_m`; `threshold` is γ.
    #[must_use]
    pub fn new(settings: &AugmentationSettings, threshold: f64, tick_s: f64, reference_m: L) -> Self {
        let motion = HeldReference::new(settings.freeze, settings.reengage, tick_s, reference_m);
        let motion = motion.holding(&settings.hold, tick_s);
        let force = AnyForceLaw::new(&settings.force, tick_s);
        Self::with_laws(motion, force, settings, threshold, tick_s)
    }
}

impl<L: Lane, M: MotionLaw<L>, F: ForceLaw<L>> Supervisor<L, M, F> {
    /// With the given laws.
    #[must_use]
    pub fn with_laws(motion: M, force: F, settings: &AugmentationSettings, threshold: f64, tick_s: f64) -> Self {
        Self {
            enabled: L::Mask::splat(settings.enabled),
            gives_cue: L::Mask::splat(settings.enabled && settings.cue),
            automaton: Automaton::new(&settings.automaton, threshold, settings.blend_s, tick_s),
            motion,
            feedback: ForceFeedback::new(force, settings.blend_s, tick_s),
        }
    }

    /// Both sides without a link; force and velocity are the master's.
    #[inline(always)]
    pub fn update(&mut self, now: &SupervisorInput<L>, force_n: L, velocity_m_per_s: L) -> Command<L> {
        let SlaveCommand { mode, slave_reference_m, alarm_taken } = self.decide(now);
        let (feedback_force_n, allowed_step_n) = self.feedback_force(mode, force_n, velocity_m_per_s);
        Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken }
    }

    /// The slave's side.
    #[inline(always)]
    pub fn decide(&mut self, now: &SupervisorInput<L>) -> SlaveCommand<L> {
        if self.is_quiet_tick(now.alarm) {
            return SlaveCommand {
                mode: Modes::splat(Mode::Teleoperation),
                slave_reference_m: self.motion.follow(now.hand_m, now.slave_m),
                alarm_taken: now.alarm,
            };
        }
        let before = self.automaton.mode();
        let mode = self.automaton.step(now.tick, now.alarm & self.enabled, now.decision, self.motion.is_blended());
        let modes = ModeChange { before, now: mode };
        self.motion.sense(now.force_n);
        SlaveCommand {
            mode,
            slave_reference_m: self.motion.update(modes, now.hand_m, now.slave_m),
            alarm_taken: modes.has_become(Mode::Augmented) | (now.alarm & !self.enabled),
        }
    }

    /// The master's side: the force and its largest allowed change.
    #[inline(always)]
    pub fn feedback_force(&mut self, mode: Modes<L>, force_n: L, velocity_m_per_s: L) -> (L, L) {
        self.feedback.update(mode, force_n, velocity_m_per_s)
    }

    /// Lanes in which a cue is on.
    #[inline(always)]
    pub fn cue(&self, mode: Modes<L>) -> L::Mask {
        self.gives_cue & mode.is_augmented()
    }

    #[inline(always)]
    fn is_quiet_tick(&self, alarm: L::Mask) -> bool {
        (self.automaton.is_teleoperation() & !(self.enabled & alarm)).all()
    }
}

impl<M: Gather, F: Gather> Gather for Supervisor<f64, M, F> {
    type Of<L: Lane> = Supervisor<L, M::Of<L>, F::Of<L>>;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        Some(Supervisor {
            enabled: gather_mask::<L>(of_each!(all, |one| one.enabled)),
            gives_cue: gather_mask::<L>(of_each!(all, |one| one.gives_cue)),
            automaton: Gather::gather(of_each!(all, |one| &one.automaton))?,
            motion: M::gather(of_each!(all, |one| &one.motion))?,
            feedback: Gather::gather(of_each!(all, |one| &one.feedback))?,
        })
    }
}

impl<M: Stored, F: Stored> Stored for Supervisor<f64, M, F> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { enabled, gives_cue, automaton, motion, feedback } = self;
        enabled.numbers(with);
        gives_cue.numbers(with);
        automaton.numbers(with);
        motion.numbers(with);
        feedback.numbers(with);
    }
}

#[cfg(test)]
mod tests;
