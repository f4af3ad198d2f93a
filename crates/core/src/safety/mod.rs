//! The safety stage: every command to a motor passes it.

mod fade;
mod force;
mod limits;
mod plausibility;
mod reference;
mod settings;
mod state;

pub use fade::Fade;
pub use force::{ForceLimiter, LimitedForce};
pub use limits::CommandLimits;
pub use plausibility::SlaveSample;
pub use reference::{LimitedReference, ReferenceLimiter};
pub use settings::{SafetyActs, SafetySettings};
pub use state::{FaultCause, SafetyState};

use crate::lane::Stored;
use plausibility::Plausibility;

/// Commands that enter the stage.
#[derive(Debug, Clone, Copy)]
pub struct Wanted {
    /// For the slave.
    pub reference_m: f64,
    /// For the master.
    pub force_n: f64,
    /// Last good position of the slave.
    pub slave_m: f64,
    /// True if every channel is good.
    pub is_good: bool,
}

/// Commands that leave the stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Safe {
    /// For the slave.
    pub reference_m: f64,
    /// For the master.
    pub force_n: f64,
    /// Limits that acted.
    pub limited: Limited,
}

/// The limits that acted at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Limited {
    /// `safety.force_limit_n`.
    pub force: bool,
    /// `safety.force_rate_n_per_s`.
    pub force_rate: bool,
    /// `safety.reference_speed_m_per_s`, or of an alignment.
    pub reference_speed: bool,
    /// `safety.lead_m`.
    pub lead: bool,
}

impl Limited {
    /// 1: force, 2: its rate, 4: speed of the reference, 8: its lead; summed.
    #[must_use]
    pub fn bits(self) -> u32 {
        let flags = [self.force, self.force_rate, self.reference_speed, self.lead];
        flags.into_iter().rev().fold(0, |bits, flag| bits << 1 | u32::from(flag))
    }

    /// True if any limit acted.
    #[must_use]
    pub fn any(self) -> bool {
        self.force | self.force_rate | self.reference_speed | self.lead
    }
}

/// Ticks at which limits acted, and faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SafetyCounts {
    /// `safety.force_limit_n`.
    pub force: u64,
    /// `safety.force_rate_n_per_s`.
    pub force_rate: u64,
    /// `safety.reference_speed_m_per_s`, or of an alignment.
    pub reference_speed: u64,
    /// `safety.lead_m`.
    pub lead: u64,
    /// Alignments that were needed.
    pub alignments: u64,
    /// Faults.
    pub faults: u64,
}

/// The safety stage of a rig.
#[derive(Debug, Clone)]
pub struct SafetyStage {
    acts: bool,
    force: ForceLimiter<f64>,
    reference: ReferenceLimiter<f64>,
    plausibility: Option<Plausibility>,
    start_tolerance_m: f64,
    alignment_step_m: f64,
    bad_samples: u64,
    state: SafetyState,
    cause: Option<FaultCause>,
    fade: Fade<f64>,
    has_started: bool,
    is_aligning: bool,
    bad: u64,
    counts: SafetyCounts,
}

impl SafetyStage {
    /// Starts aligning, with the slave at `start_m`.
    #[must_use]
    pub fn new(settings: &SafetySettings, tick_s: f64, start_m: f64) -> Self {
        Self {
            acts: settings.acts_on_rigs(),
            force: ForceLimiter::new(settings, tick_s),
            reference: ReferenceLimiter::new(settings, tick_s, start_m),
            plausibility: settings.checks_sensors.then(|| Plausibility::new(settings, tick_s)),
            start_tolerance_m: settings.start_tolerance_m,
            alignment_step_m: settings.alignment_speed_m_per_s * tick_s,
            bad_samples: settings.bad_samples,
            state: if settings.acts_on_rigs() { SafetyState::Aligning } else { SafetyState::Active },
            cause: None,
            fade: Fade::new(settings.decay_s, tick_s, 0.0),
            has_started: false,
            is_aligning: false,
            bad: 0,
            counts: SafetyCounts::default(),
        }
    }

    /// State of the commands.
    #[inline(always)]
    #[must_use]
    pub fn state(&self) -> SafetyState {
        self.state
    }

    /// Cause of the last fault since [`SafetyStage::enable`].
    #[inline(always)]
    #[must_use]
    pub fn cause(&self) -> Option<FaultCause> {
        self.cause
    }

    /// Counts since the start.
    #[must_use]
    pub fn counts(&self) -> SafetyCounts {
        self.counts
    }

    /// The force decays and the reference holds until [`SafetyStage::enable`]; no effect if `safety.acts` is `nowhere`.
    pub fn stop(&mut self) {
        if self.acts {
            self.state = SafetyState::Disabled;
        }
    }

    /// The reference moves to the hand, then the force returns.
    pub fn enable(&mut self) {
        if self.acts && matches!(self.state, SafetyState::Disabled | SafetyState::Fault) {
            self.begin_alignment();
            self.cause = None;
            self.bad = 0;
        }
    }

    /// `sample` is `None` unless it is good.
    #[inline(always)]
    pub fn pass(&mut self, wanted: &Wanted, sample: Option<&SlaveSample>) -> Safe {
        if !self.acts {
            let Wanted { reference_m, force_n, .. } = *wanted;
            return Safe { reference_m, force_n, limited: Limited::default() };
        }
        self.check(wanted.is_good, sample);
        if self.state == SafetyState::Active && self.fade.share() == 1.0 {
            let limited = self.reference.limit(wanted.reference_m, wanted.slave_m);
            return self.finish(limited, wanted.force_n);
        }
        self.pass_inactive(wanted)
    }

    #[inline(always)]
    fn check(&mut self, is_good: bool, sample: Option<&SlaveSample>) {
        let cause = match (sample, &mut self.plausibility) {
            (Some(sample), Some(checks)) => checks.check(sample),
            (None, Some(checks)) => {
                checks.restart();
                None
            }
            (_, None) => None,
        };
        self.bad = if is_good { 0 } else { self.bad.saturating_add(1) };
        if self.bad >= self.bad_samples {
            self.fail(FaultCause::BadSamples);
        } else if let Some(cause) = cause {
            self.fail(cause);
        }
    }

    #[cold]
    fn fail(&mut self, cause: FaultCause) {
        match self.state {
            SafetyState::Active | SafetyState::Aligning => {
                self.state = SafetyState::Fault;
                self.cause = Some(cause);
                self.counts.faults += 1;
            }
            // A sensor's fault takes precedence over missing samples, which end by themselves.
            SafetyState::Fault if cause != FaultCause::BadSamples => self.cause = Some(cause),
            SafetyState::Fault | SafetyState::Disabled => {}
        }
    }

    fn begin_alignment(&mut self) {
        self.state = SafetyState::Aligning;
        self.is_aligning = false;
    }

    #[cold]
    #[inline(never)]
    fn pass_inactive(&mut self, wanted: &Wanted) -> Safe {
        if self.state == SafetyState::Fault && self.cause == Some(FaultCause::BadSamples) && wanted.is_good {
            self.begin_alignment();
        }
        let is_first = !self.has_started && wanted.is_good;
        if is_first {
            self.has_started = true;
            self.reference.start_at(wanted.slave_m);
        }
        if self.state == SafetyState::Aligning && wanted.is_good {
            let is_reached = (wanted.reference_m - self.reference.last_m()).abs() <= self.start_tolerance_m;
            if is_reached {
                self.state = SafetyState::Active;
                if is_first {
                    self.fade.complete();
                }
            } else if !self.is_aligning {
                self.is_aligning = true;
                self.counts.alignments += 1;
            }
        }
        let mut limited = LimitedReference { reference_m: self.reference.last_m(), too_far: false, too_fast: false };
        match self.state {
            SafetyState::Active => limited = self.reference.limit(wanted.reference_m, wanted.slave_m),
            SafetyState::Aligning if wanted.is_good => {
                limited = self.reference.limit_to(wanted.reference_m, wanted.slave_m, self.alignment_step_m);
            }
            SafetyState::Aligning | SafetyState::Disabled | SafetyState::Fault => {}
        }
        self.fade.update(self.state == SafetyState::Active);
        let share = self.fade.share();
        let force_n = if share == 1.0 { wanted.force_n } else { share * wanted.force_n };
        self.finish(limited, force_n)
    }

    #[inline(always)]
    fn finish(&mut self, reference: LimitedReference<f64>, wanted_n: f64) -> Safe {
        let force = self.force.limit(wanted_n);
        let limited = Limited {
            force: force.beyond,
            force_rate: force.too_fast,
            reference_speed: reference.too_fast,
            lead: reference.too_far,
        };
        if limited.any() {
            let counts = &mut self.counts;
            counts.force += u64::from(limited.force);
            counts.force_rate += u64::from(limited.force_rate);
            counts.reference_speed += u64::from(limited.reference_speed);
            counts.lead += u64::from(limited.lead);
        }
        Safe { reference_m: reference.reference_m, force_n: force.force_n, limited }
    }
}

impl Stored for SafetyCounts {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { force, force_rate, reference_speed, lead, alignments, faults } = self;
        for count in [force, force_rate, reference_speed, lead, alignments, faults] {
            count.numbers(with);
        }
    }
}

impl Stored for SafetyStage {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self {
            acts: _,
            force,
            reference,
            plausibility,
            start_tolerance_m: _,
            alignment_step_m: _,
            bad_samples: _,
            state,
            cause,
            fade,
            has_started,
            is_aligning,
            bad,
            counts,
        } = self;
        force.numbers(with);
        reference.numbers(with);
        plausibility.numbers(with);
        state.numbers(with);
        FaultCause::store(cause, with);
        fade.numbers(with);
        has_started.numbers(with);
        is_aligning.numbers(with);
        bad.numbers(with);
        counts.numbers(with);
    }
}

#[cfg(test)]
mod tests;
