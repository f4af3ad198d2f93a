//! Event-based haptic augmentation (section 5.1): on an alarm the slave is frozen and the felt force drop exaggerated.
//!
//! The supervisor runs on the slave's side. Each tick it takes the alarm, the hand's position as it arrives, the slave's
//! position and the measured force, and commands the slave's reference and the force that is fed back.

mod automaton;
mod force;
mod position;

pub use automaton::{AutomatonSettings, Mode};
pub use force::{ForceLaw, cross_fade};
pub use position::{Freeze, Reengage};

use crate::lane::{Lane, Mask};
use automaton::Automaton;
use force::ForceFeedback;
use position::SlaveReference;

crate::settings! {
    /// Everything the supervisor is told.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct AugmentationSettings in "augmentation." {
        /// false: the classical scheme.
        ///
        /// Alarms then have no effect.
        enabled: bool = true,
        /// Where the slave is held.
        freeze: Freeze,
        /// How the slave meets the hand again.
        reengage: Reengage,
        /// What the hand feels meanwhile.
        force: ForceLaw,
        /// Length of the cross-fade back to the measured force.
        blend_s: f64 [NON_NEGATIVE] = 0.1,
        /// When to enter and to leave.
        automaton: AutomatonSettings,
    }
}

/// What the supervisor sees at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Situation<L: Lane> {
    /// The tick's number.
    pub tick: u64,
    /// Whether the detector announces a rupture.
    pub alarm: L::Mask,
    /// The detector's decision function `g_k`.
    pub decision: L,
    /// The hand's position scaled to the slave, in m.
    pub hand_m: L,
    /// The slave's measured position in m.
    pub slave_m: L,
    /// The measured force scaled to the master, in N.
    pub force_n: L,
}

/// What the supervisor commands at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Command<L: Lane> {
    /// 0 teleoperation, 1 augmented, 2 reengaging (see [`Mode`]).
    pub mode: L,
    /// The slave's reference in m.
    pub slave_reference_m: L,
    /// The force to feed back in N.
    pub feedback_force_n: L,
    /// The most by which the law in force lets the fed-back force differ from the last tick's, in N.
    pub allowed_step_n: L,
    /// Whether an alarm was acted on; with augmentation disabled, whether there was one.
    pub alarm_taken: L::Mask,
}

/// What the supervisor commands at a tick on the slave's side.
#[derive(Debug, Clone, Copy)]
pub struct SlaveCommand<L: Lane> {
    /// As in [`Command`].
    pub mode: L,
    /// The slave's reference in m.
    pub slave_reference_m: L,
    /// As in [`Command`].
    pub alarm_taken: L::Mask,
}

/// The supervisor at work: the automaton and the slave's reference on the slave's side, the force law on the master's.
///
/// Without a link between them both act in one [`Supervisor::update`]; over a link the slave's side [`Supervisor::decide`]s,
/// and the master's side [`Supervisor::feel`]s what arrives of its mode.
#[derive(Debug, Clone)]
pub struct Supervisor<L: Lane> {
    enabled: L::Mask,
    automaton: Automaton<L>,
    reference: SlaveReference<L>,
    feedback: ForceFeedback<L>,
}

impl<L: Lane> Supervisor<L> {
    /// A supervisor in teleoperation, for a detector with the threshold γ and ticks `tick_s` apart (s);
    /// the slave begins under the reference `reference_m` (m).
    #[must_use]
    pub fn new(settings: &AugmentationSettings, threshold: f64, tick_s: f64, reference_m: L) -> Self {
        Self {
            enabled: L::Mask::splat(settings.enabled),
            automaton: Automaton::new(&settings.automaton, threshold, settings.blend_s, tick_s),
            reference: SlaveReference::new(settings.freeze, settings.reengage, tick_s, reference_m),
            feedback: ForceFeedback::new(settings.force, settings.blend_s, tick_s),
        }
    }

    /// Whether in lane `index` a higher threshold would have done something else so far, although the alarms are the same.
    #[must_use]
    pub fn depends_on_threshold(&self, index: usize) -> bool {
        self.automaton.exit_was_delayed().lane(index)
    }

    /// Decides the tick.
    #[inline(always)]
    pub fn update(&mut self, now: &Situation<L>) -> Command<L> {
        if self.passes(now.alarm) {
            return self.pass(now);
        }
        if L::WIDTH > 1 {
            // Side by side there is often one that is not, and a call would leave the registers.
            return self.act_here(now.tick, now.alarm, now.decision, now.hand_m, now.slave_m, now.force_n);
        }
        // Taken apart and put together, so that what is common need not go through memory.
        let Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken } =
            self.act(now.tick, now.alarm, now.decision, now.hand_m, now.slave_m, now.force_n);
        Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken }
    }

    /// Whether position and force are only passed on at a tick with this alarm: teleoperation, and it stays so.
    #[inline(always)]
    pub fn passes(&self, alarm: L::Mask) -> bool {
        (self.automaton.is_teleoperation() & !(self.enabled & alarm)).all()
    }

    /// Whether a tick [passes](Supervisor::passes) and there is no alarm, taken or not.
    #[inline(always)]
    pub fn passes_on(&self, alarm: L::Mask) -> bool {
        if alarm.any() {
            core::hint::cold_path();
            return false;
        }
        self.automaton.is_teleoperation().all()
    }

    /// Decides a tick that [passes](Supervisor::passes).
    #[inline(always)]
    pub fn pass(&mut self, now: &Situation<L>) -> Command<L> {
        Command {
            mode: L::splat(Mode::Teleoperation.code()),
            slave_reference_m: self.reference.follow(now.hand_m),
            feedback_force_n: now.force_n,
            allowed_step_n: self.feedback.pass(now.force_n),
            alarm_taken: now.alarm,
        }
    }

    /// Decides any tick: some lane may be augmented, re-engaging or alarmed. Told to be cold, so that registers are saved
    /// around this call and not on the common way; the same goes wherever the tick leaves it.
    #[cold]
    #[inline]
    fn act(&mut self, tick: u64, alarm: L::Mask, decision: L, hand_m: L, slave_m: L, force_n: L) -> Command<L> {
        self.act_here(tick, alarm, decision, hand_m, slave_m, force_n)
    }

    #[inline(always)]
    fn act_here(&mut self, tick: u64, alarm: L::Mask, decision: L, hand_m: L, slave_m: L, force_n: L) -> Command<L> {
        let before = self.automaton.mode();
        let SlaveCommand { mode, slave_reference_m, alarm_taken } =
            self.act_on_slave(tick, alarm, decision, hand_m, slave_m);
        let (feedback_force_n, allowed_step_n) = self.feedback.update(before, mode, force_n);
        Command { mode, slave_reference_m, feedback_force_n, allowed_step_n, alarm_taken }
    }

    #[inline(always)]
    fn act_on_slave(&mut self, tick: u64, alarm: L::Mask, decision: L, hand_m: L, slave_m: L) -> SlaveCommand<L> {
        let before = self.automaton.mode();
        // A lane without augmentation comes here beside others that have it. What it is told of is told, as in `pass`.
        let mode = self.automaton.step(tick, alarm & self.enabled, decision, self.reference.is_blended());
        let slave_reference_m = self.reference.update(before, mode, hand_m, slave_m);
        let alarm_taken = automaton::has_become(before, mode, Mode::Augmented) | (alarm & !self.enabled);
        SlaveCommand { mode, slave_reference_m, alarm_taken }
    }

    /// Decides the tick on the slave's side alone.
    #[inline(always)]
    pub fn decide(&mut self, now: &Situation<L>) -> SlaveCommand<L> {
        if self.passes(now.alarm) {
            let mode = L::splat(Mode::Teleoperation.code());
            let slave_reference_m = self.reference.follow(now.hand_m);
            return SlaveCommand { mode, slave_reference_m, alarm_taken: now.alarm };
        }
        self.act_on_slave(now.tick, now.alarm, now.decision, now.hand_m, now.slave_m)
    }

    /// The force to feed back (N) and the most by which the law lets it differ from the last tick's (N), on the master's
    /// side, given the mode that has arrived there and the force that the controller would feed back by itself (N).
    #[inline(always)]
    pub fn feel(&mut self, mode: L, force_n: L) -> (L, L) {
        self.feedback.arrive(mode, force_n)
    }
}

crate::lane::gather!(Supervisor { automaton, reference, feedback } masks { enabled });

#[cfg(test)]
mod tests;
