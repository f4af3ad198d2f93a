use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};
use std::ops::RangeInclusive;

use serde::Serialize;

use trocar_base::warning::{Code, Warning};
use trocar_core::augmentation::{AugmentationSettings, Mode};
use trocar_core::detector::{
    AlarmConditions, CusumDetector, Decision, Detector as _, DetectorInput, DetectorSettings, Motion,
};
use trocar_core::time::nearest_ticks;

/// A contact position above which no needle lies.
const FAR_M: f64 = 1e3;

/// The cause that prevented the detector's alarm, or the supervisor's event.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "reason", rename_all = "kebab-case")]
pub enum MissReason {
    /// The estimator's contact position is deeper than the needle.
    NotInContact {
        /// Depth of the needle below the contact in m, never positive.
        depth_m: f64,
    },
    /// The detector was not armed when g exceeded the threshold.
    NotArmed {
        /// Time for which the contact had been quiet, in s.
        quiet_s: f64,
        /// Time for which the contact must be quiet, in s.
        settle_s: f64,
    },
    /// A self-arming detector was not ready.
    NotReady {
        /// The condition for which it waited.
        waits_for: &'static str,
    },
    /// A self-arming detector saw no fall large enough to count.
    NoFall,
    /// A self-arming detector attributed the fall to the rupture of an earlier alarm, or to the ring-down after it.
    AfterAlarm {
        /// The time of the earlier alarm in s.
        alarm_s: f64,
    },
    /// The force did not fall below a predicted resisting force.
    NoDrop,
    /// The needle did not move as the detector requires.
    WrongMotion {
        /// The velocity of the needle in m/s.
        velocity_m_per_s: f64,
    },
    /// The needle was not deep enough.
    TooShallow {
        /// The depth of the needle below the contact in m.
        depth_m: f64,
    },
    /// g did not exceed the threshold.
    BelowThreshold {
        /// The largest g of the window, divided by the threshold.
        reached: f64,
    },
    /// No distance exceeded the drift; g stayed at 0.
    BelowDrift {
        /// The largest distance of the window, in the unit of the distance.
        largest: f64,
    },
    /// An event was in progress.
    EventUnderWay {
        /// The start of the event in s.
        begin_s: f64,
    },
    /// An event had just ended.
    Refractory {
        /// The end of the event in s.
        end_s: f64,
    },
    /// No other reason applies: an earlier alarm would open an event, which hides the rupture.
    EarlierEvent,
    /// The alarm counts for another rupture.
    AlarmOfAnother {
        /// The time of the alarm in s.
        alarm_s: f64,
    },
}

struct Explained {
    key: &'static str,
    sentence: String,
    remedy: Cow<'static, str>,
}

impl MissReason {
    pub fn word(&self) -> String {
        let tag = |value: serde_json::Value| Some(value.get("reason")?.as_str()?.to_owned());
        serde_json::to_value(self).ok().and_then(tag).unwrap_or_default()
    }

    pub fn key(&self) -> &'static str {
        self.explained().key
    }

    pub fn remedy(&self) -> Cow<'static, str> {
        self.explained().remedy
    }

    fn explained(&self) -> Explained {
        let ms = |s: f64| (1e4 * s).round() / 10.0;
        let mm = |m: f64| (1e5 * m).round() / 100.0;
        let of = |key, sentence: String, remedy| Explained { key, sentence, remedy: Cow::Borrowed(remedy) };
        match *self {
            Self::NotInContact { depth_m } => {
                let height = match mm(-depth_m) {
                    0.0 => "less than 0.01".to_owned(),
                    height_mm => height_mm.to_string(),
                };
                of(
                    "estimator.contact_m",
                    format!("not in contact: the needle was {height} mm above estimator.contact_m"),
                    "set estimator.contact_m to the position of the surface",
                )
            }
            Self::NotArmed { quiet_s, settle_s } => of(
                "detector.settle_s",
                format!(
                    "not armed: g had been below the threshold in contact for {} ms, detector.settle_s is {} ms",
                    ms(quiet_s),
                    ms(settle_s)
                ),
                "reduce detector.settle_s, or keep g quiet before the rupture: a larger detector.drift or \
                 estimator.dead_zone_n",
            ),
            Self::NotReady { waits_for } => of(
                "detector.distance",
                format!("not armed: the detector waits for {waits_for}"),
                "begin the recording earlier, and check that the force is renewed at every sample",
            ),
            Self::NoFall => of(
                "detector.distance",
                "no fall: the force did not fall by more than motion and relaxation explain, or a fall was already in \
                 progress"
                    .into(),
                "look at the force there; other kinds of detector.distance do not judge by the fall alone",
            ),
            Self::AfterAlarm { alarm_s } => of(
                "detector.threshold",
                format!(
                    "the detector attributed the fall to the alarm at {alarm_s:.3} s before it, or to the ring-down after it"
                ),
                "if that alarm is false, set a higher detector.threshold",
            ),
            Self::NoDrop => of(
                "detector.drop_only",
                "detector.drop_only: the force did not fall below a predicted resisting force".into(),
                "set detector.drop_only = false",
            ),
            Self::WrongMotion { velocity_m_per_s } => of(
                "detector.motion",
                format!("detector.motion: the needle moved at {} mm/s", mm(velocity_m_per_s)),
                "choose another detector.motion, or change its speed",
            ),
            Self::TooShallow { depth_m } => of(
                "detector.minimum_depth_m",
                format!("detector.minimum_depth_m: the needle was at {} mm", mm(depth_m)),
                "reduce detector.minimum_depth_m",
            ),
            Self::BelowThreshold { reached } => Explained {
                key: "detector.threshold",
                sentence: format!("below the threshold: g reached {} % of it", percent(reached, f64::round)),
                remedy: lower_threshold(reached),
            },
            Self::BelowDrift { largest } => of(
                "detector.drift",
                format!("below the drift: no distance exceeded {largest:.3e}, and g stayed at 0"),
                "reduce detector.drift (`trocar calibrate` computes one from the noise)",
            ),
            Self::EventUnderWay { begin_s } => of(
                "augmentation.max_hold_s",
                format!("the event that began at {begin_s:.3} s was in progress"),
                "shorten the event (augmentation.min_hold_s, max_hold_s, catch_up_speed_m_per_s), or let the hand stop \
                 at it (perception.reflex)",
            ),
            Self::EarlierEvent => of(
                "augmentation.enabled",
                "an earlier alarm would then open an event that hides it".into(),
                "keep g quiet before the rupture, so that no earlier alarm opens an event",
            ),
            Self::Refractory { end_s } => of(
                "augmentation.refractory_s",
                format!("in the refractory period of the event that ended at {end_s:.3} s"),
                "reduce augmentation.refractory_s, or let the hand stop at the event (perception.reflex)",
            ),
            Self::AlarmOfAnother { alarm_s } => of(
                "detector.settle_s",
                format!("the only alarm, at {alarm_s:.3} s, counts for another rupture"),
                "reduce detector.settle_s, or move more slowly",
            ),
        }
    }

    pub fn remove(
        &self,
        contact_m: &mut f64,
        detector: &mut DetectorSettings,
        augmentation: &mut AugmentationSettings,
    ) {
        let (cusum, arming) = (&mut detector.cusum, &mut detector.arming);
        match self {
            Self::NotInContact { .. } => *contact_m = -FAR_M,
            Self::NotArmed { .. } => arming.settle_s = 0.0,
            Self::NoDrop => arming.drop_only = false,
            Self::WrongMotion { .. } => arming.motion = Motion::Any,
            Self::TooShallow { .. } => arming.minimum_depth_m = 0.0,
            Self::BelowThreshold { reached } => cusum.threshold *= NEAR_MAX * reached,
            Self::BelowDrift { largest } => cusum.drift = 0.5 * largest,
            Self::EventUnderWay { .. } | Self::Refractory { .. } | Self::EarlierEvent => augmentation.enabled = false,
            Self::NotReady { .. } | Self::NoFall | Self::AfterAlarm { .. } | Self::AlarmOfAnother { .. } => {}
        }
    }
}

/// Fraction of the threshold below which lowering the threshold is no remedy by itself.
const HARDLY: f64 = 1e-3;

fn percent(share: f64, rounded: fn(f64) -> f64) -> String {
    if share > 0.0 && share < HARDLY {
        return format!("less than {}", 100.0 * HARDLY);
    }
    (rounded(1e3 * share) / 10.0).to_string()
}

fn lower_threshold(reached: f64) -> Cow<'static, str> {
    if reached < HARDLY {
        return Cow::Borrowed(
            "check the estimator and the force there, since g hardly rises; only then set a far lower \
             detector.threshold, and count the false alarms with `trocar roc`",
        );
    }
    let share = percent(reached, f64::floor);
    Cow::Owned(format!(
        "set detector.threshold below {share} % of its value, and count the false alarms with `trocar roc`"
    ))
}

impl Display for MissReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.explained().sentence)
    }
}

/// The reasons why a rupture has no alarm within its window.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Miss {
    /// The main reason.
    #[serde(flatten)]
    pub reason: MissReason,
    /// Further reasons; each alone would have prevented the alarm.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<MissReason>,
}

impl Miss {
    pub fn reasons(&self) -> impl Iterator<Item = &MissReason> {
        std::iter::once(&self.reason).chain(&self.also)
    }

    pub fn warning(&self, number: usize, time_s: f64) -> Warning {
        let message = format!("rupture {number} at {time_s:.3} s missed: {self}");
        Warning::new(Code::MissedRupture, message).at(self.reason.key()).remedy(self.reason.remedy())
    }
}

impl Display for Miss {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.reason)?;
        self.also.iter().try_for_each(|other| write!(f, "; also {other}"))
    }
}

#[derive(Debug, Clone, Copy)]
pub struct DetectorSample {
    pub distance: f64,
    pub decision: f64,
    pub conditions: AlarmConditions<f64>,
    pub depth_m: f64,
    pub velocity_m_per_s: f64,
}

impl DetectorSample {
    /// The conditions are those before the update.
    pub fn update(detector: &mut CusumDetector<f64>, input: &DetectorInput<f64>) -> (Decision<f64>, Self) {
        let conditions = detector.conditions(input);
        let decision = detector.update(input);
        let sample = Self {
            distance: decision.distance,
            decision: decision.decision,
            conditions,
            depth_m: input.depth_m,
            velocity_m_per_s: input.velocity_m_per_s,
        };
        (decision, sample)
    }
}

#[derive(Debug, Clone, Default)]
pub struct SupervisorHistory {
    /// First tick of each event, and the first tick after it.
    events: Vec<(u64, u64)>,
    ignored_alarms: Vec<u64>,
    alarms: Vec<u64>,
}

impl SupervisorHistory {
    /// A supervisor that accepts the alarms at these ticks and opens no event.
    pub fn of_alarms(alarms: &[usize]) -> Self {
        Self { alarms: alarms.iter().map(|alarm| *alarm as u64).collect(), ..Self::default() }
    }

    pub fn push(&mut self, tick: u64, mode: Mode, alarm: bool, is_taken: bool) {
        if mode != Mode::Teleoperation {
            match self.events.last_mut() {
                Some((_, end)) if *end == tick => *end = tick + 1,
                _ => self.events.push((tick, tick + 1)),
            }
        }
        if alarm && is_taken {
            self.alarms.push(tick);
        } else if alarm {
            self.ignored_alarms.push(tick);
        }
    }

    pub fn has_alarm(&self, ticks: RangeInclusive<u64>) -> bool {
        self.alarms.iter().chain(&self.ignored_alarms).any(|alarm| ticks.contains(alarm))
    }

    fn last_alarm(&self, tick: u64, ticks: u64) -> Option<u64> {
        let before = tick.saturating_sub(ticks)..tick;
        self.alarms.iter().chain(&self.ignored_alarms).copied().filter(|alarm| before.contains(alarm)).max()
    }

    fn refusal(&self, tick: u64, rule: &MissRule) -> Option<MissReason> {
        let &(begin, end) = self.events.iter().rev().find(|(begin, _)| *begin < tick)?;
        if tick < end {
            return Some(MissReason::EventUnderWay { begin_s: rule.time_s(begin) });
        }
        let refractory = nearest_ticks(rule.refractory_s, rule.tick_s);
        (tick < end + refractory).then(|| MissReason::Refractory { end_s: rule.time_s(end) })
    }
}

/// Time after an alarm in which a self-arming detector may attribute a fall to it: the longest hold, and as long again
/// for the ring-down.
const AFTERMATH_S: f64 = 0.3;

/// A sample is near the largest g of a window if its g exceeds this fraction of it.
const NEAR_MAX: f64 = 0.9;

pub struct MissRule<'a> {
    pub tick_s: f64,
    pub start_s: f64,
    pub window_s: f64,
    pub detector: &'a DetectorSettings,
    pub refractory_s: f64,
}

impl MissRule<'_> {
    fn time_s(&self, tick: u64) -> f64 {
        self.start_s + tick as f64 * self.tick_s
    }

    pub fn window_ticks(&self) -> u64 {
        nearest_ticks(self.window_s, self.tick_s)
    }

    /// Explains why a rupture at `tick` has no alarm, from the `samples` of its window.
    ///
    /// Of those with g above the threshold, the first one that fails the fewest conditions decides.
    pub fn explain(
        &self,
        tick: u64,
        samples: &[(u64, DetectorSample)],
        supervisor: &SupervisorHistory,
    ) -> Option<Miss> {
        let window = tick..=tick + self.window_ticks();
        if let Some(&alarm) = supervisor.ignored_alarms.iter().find(|alarm| window.contains(alarm)) {
            let reason = supervisor.refusal(alarm, self)?;
            return Some(Miss { reason, also: vec![] });
        }
        // An alarm in the window counts for a later rupture: samples from it onwards explain nothing.
        let of_another = supervisor.alarms.iter().copied().find(|alarm| window.contains(alarm));
        let end = of_another.map_or(samples.len(), |alarm| samples.partition_point(|(tick, _)| *tick < alarm));
        if let (0, Some(alarm)) = (end, of_another) {
            return Some(Miss { reason: MissReason::AlarmOfAnother { alarm_s: self.time_s(alarm) }, also: vec![] });
        }
        let samples = &samples[..end];
        let (_, first) = samples.first()?;
        if !first.conditions.in_contact {
            return Some(Miss { reason: MissReason::NotInContact { depth_m: first.depth_m }, also: vec![] });
        }
        let threshold = self.detector.cusum.threshold;
        let max = samples.iter().map(|(_, sample)| sample.decision).fold(0.0, f64::max);
        // Without a sample above the threshold, those near the largest g show the other conditions.
        let level = threshold.min(NEAR_MAX * max);
        let mut fewest: Option<Vec<MissReason>> = None;
        for (tick, sample) in samples.iter().filter(|(_, sample)| sample.decision > level) {
            let mut failed = self.failed(sample);
            failed.extend(supervisor.refusal(*tick, self));
            if fewest.as_ref().is_none_or(|fewest| failed.len() < fewest.len()) {
                fewest = Some(failed);
            }
        }
        let failed = fewest.unwrap_or_default();
        let reasons = match of_another {
            _ if max > threshold && !failed.is_empty() => failed,
            Some(alarm) => vec![MissReason::AlarmOfAnother { alarm_s: self.time_s(alarm) }],
            None if max > 0.0 => {
                let reached = MissReason::BelowThreshold { reached: (max / threshold).min(1.0) };
                std::iter::once(reached).chain(failed).collect()
            }
            None if self.waits_for().is_some() => {
                let earlier = supervisor.last_alarm(tick, nearest_ticks(AFTERMATH_S, self.tick_s));
                let after = earlier.map(|alarm| MissReason::AfterAlarm { alarm_s: self.time_s(alarm) });
                vec![after.unwrap_or(MissReason::NoFall)]
            }
            None => {
                let largest = samples.iter().map(|(_, sample)| sample.distance).fold(0.0, f64::max);
                let drift = MissReason::BelowDrift { largest };
                // With the drift at half of the largest distance, g reaches the other half.
                let reached = 0.5 * largest / threshold;
                let and_threshold = (reached < 1.0).then_some(MissReason::BelowThreshold { reached });
                std::iter::once(drift).chain(and_threshold).collect()
            }
        };
        let (reason, also) = reasons.split_first()?;
        Some(Miss { reason: *reason, also: also.to_vec() })
    }

    fn waits_for(&self) -> Option<&'static str> {
        self.detector.distance.kind.waits_for()
    }

    fn failed(&self, sample: &DetectorSample) -> Vec<MissReason> {
        let DetectorSample { conditions, depth_m, velocity_m_per_s, .. } = *sample;
        if !conditions.in_contact {
            return vec![MissReason::NotInContact { depth_m }];
        }
        let quiet_s = conditions.quiet_samples * self.tick_s;
        let settle_s = self.detector.arming.settle_s;
        let not_armed = match self.waits_for() {
            Some(waits_for) => MissReason::NotReady { waits_for },
            None => MissReason::NotArmed { quiet_s, settle_s },
        };
        let all = [
            (conditions.armed, not_armed),
            (conditions.is_drop, MissReason::NoDrop),
            (conditions.moves_as_required, MissReason::WrongMotion { velocity_m_per_s }),
            (conditions.is_deep, MissReason::TooShallow { depth_m }),
        ];
        all.into_iter().filter(|(holds, _)| !holds).map(|(_, reason)| reason).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_core::detector::{DistanceKind, Hypotheses};

    /// Explains a miss with ticks of 1 ms, a window of 10 ms, γ = 2, a settling time of 100 ms and a refractory period
    /// of 50 ms.
    fn explain(
        tick: u64,
        samples: &[DetectorSample],
        supervisor: &SupervisorHistory,
        kind: DistanceKind,
    ) -> Option<Miss> {
        let mut detector = DetectorSettings::for_kind(kind, Hypotheses::default());
        detector.cusum.threshold = 2.0;
        let rule = MissRule { tick_s: 1e-3, start_s: 5.0, window_s: 0.01, detector: &detector, refractory_s: 0.05 };
        let samples: Vec<_> = (tick..).zip(samples.iter().copied()).collect();
        rule.explain(tick, &samples, supervisor)
    }

    fn reasons(samples: &[DetectorSample]) -> Vec<MissReason> {
        let miss =
            explain(100, samples, &SupervisorHistory::default(), DistanceKind::SquaredResidual).expect("a reason");
        miss.reasons().copied().collect()
    }

    const ALL: AlarmConditions<f64> = AlarmConditions {
        in_contact: true,
        armed: true,
        is_drop: true,
        moves_as_required: true,
        is_deep: true,
        quiet_samples: 30.0,
    };

    fn sample(decision: f64) -> DetectorSample {
        DetectorSample { distance: 0.5, decision, conditions: ALL, depth_m: 0.02, velocity_m_per_s: 0.01 }
    }

    fn with(decision: f64, conditions: AlarmConditions<f64>) -> DetectorSample {
        DetectorSample { conditions, ..sample(decision) }
    }

    #[test]
    fn a_failed_condition_of_a_large_g_is_the_reason() {
        let of = |conditions| reasons(&[sample(0.0), with(3.0, conditions), sample(0.5)]);
        let not_armed = MissReason::NotArmed { quiet_s: 0.03, settle_s: 0.1 };
        assert_eq!(of(AlarmConditions { armed: false, ..ALL }), [not_armed]);
        assert_eq!(of(AlarmConditions { is_drop: false, ..ALL }), [MissReason::NoDrop]);
        let motion = MissReason::WrongMotion { velocity_m_per_s: 0.01 };
        assert_eq!(of(AlarmConditions { moves_as_required: false, ..ALL }), [motion]);
        assert_eq!(of(AlarmConditions { is_deep: false, ..ALL }), [MissReason::TooShallow { depth_m: 0.02 }]);
        let both = AlarmConditions { armed: false, is_drop: false, ..ALL };
        assert_eq!(of(both), [not_armed, MissReason::NoDrop]);
        let outside = AlarmConditions { in_contact: false, ..both };
        assert_eq!(of(outside), [MissReason::NotInContact { depth_m: 0.02 }], "which explains the others");
    }

    #[test]
    fn the_first_sample_above_the_threshold_that_fails_the_fewest_conditions_decides() {
        let not_armed = AlarmConditions { armed: false, ..ALL };
        let two = AlarmConditions { is_drop: false, ..not_armed };
        let shallow = AlarmConditions { is_deep: false, ..ALL };
        let found = reasons(&[sample(0.0), with(9.0, two), with(3.0, not_armed), with(3.0, shallow)]);
        assert_eq!(found, [MissReason::NotArmed { quiet_s: 0.03, settle_s: 0.1 }]);
    }

    #[test]
    fn a_needle_above_the_contact_at_the_rupture_is_the_only_reason() {
        let outside = with(9.0, AlarmConditions { in_contact: false, ..ALL });
        let outside = DetectorSample { depth_m: -1e-3, ..outside };
        assert_eq!(reasons(&[outside, sample(3.0)]), [MissReason::NotInContact { depth_m: -1e-3 }]);
    }

    #[test]
    fn a_small_g_is_reported_with_its_maximum_and_the_other_failed_conditions() {
        assert_eq!(reasons(&[sample(0.1), sample(0.5), sample(0.2)]), [MissReason::BelowThreshold { reached: 0.25 }]);
        // Samples within a tenth of the largest g count as near it.
        let no_drop = AlarmConditions { is_drop: false, ..ALL };
        assert_eq!(
            reasons(&[sample(0.1), with(1.0, no_drop), with(0.95, no_drop), sample(0.85)]),
            [MissReason::BelowThreshold { reached: 0.5 }, MissReason::NoDrop]
        );
    }

    #[test]
    fn a_g_that_stays_at_0_is_below_the_drift() {
        let small = |distance| DetectorSample { distance, ..sample(0.0) };
        // A drift of half of the largest distance leaves the other half in g: 0.15 of γ = 2.
        let expected = [MissReason::BelowDrift { largest: 0.3 }, MissReason::BelowThreshold { reached: 0.075 }];
        assert_eq!(reasons(&[small(0.1), small(0.3), small(0.2)]), expected);
        assert_eq!(reasons(&[small(4.0)]), [MissReason::BelowDrift { largest: 4.0 }], "half of it reaches γ");
    }

    #[test]
    fn a_detector_that_arms_itself_waits_or_sees_no_fall() {
        let none = SupervisorHistory::default();
        let of = |samples: &[DetectorSample]| {
            let miss = explain(100, samples, &none, DistanceKind::WindowedDerivative).expect("a reason");
            miss.reasons().copied().collect::<Vec<_>>()
        };
        assert_eq!(of(&[sample(0.0)]), [MissReason::NoFall]);
        let waits_for = DistanceKind::WindowedDerivative.waits_for().expect("it arms itself");
        assert_eq!(of(&[with(3.0, AlarmConditions { armed: false, ..ALL })]), [MissReason::NotReady { waits_for }]);
    }

    #[test]
    fn a_fall_soon_after_an_alarm_is_attributed_to_it() {
        let of = |tick: u64| {
            let history = SupervisorHistory::of_alarms(&[100]);
            let miss = explain(tick, &[sample(0.0)], &history, DistanceKind::WindowedDerivative).expect("a reason");
            miss.reason
        };
        assert!(matches!(of(150), MissReason::AfterAlarm { .. }));
        assert_eq!(of(401), MissReason::NoFall, "0.3 s later");
    }

    /// A supervisor with an event from tick 50 to 80, and an alarm at a tick.
    fn supervisor(alarm: u64, is_taken: bool) -> SupervisorHistory {
        let mut history = SupervisorHistory::default();
        for tick in 0..200 {
            let mode = if (50..80).contains(&tick) { Mode::Augmented } else { Mode::Teleoperation };
            history.push(tick, mode, tick == alarm, is_taken);
        }
        history
    }

    #[test]
    fn an_ignored_alarm_is_explained_by_the_event_during_or_just_before_it() {
        let of =
            |alarm: u64| explain(alarm - 5, &[sample(3.0)], &supervisor(alarm, false), DistanceKind::SquaredResidual);
        let only = |reason| Some(Miss { reason, also: vec![] });
        assert_eq!(of(79), only(MissReason::EventUnderWay { begin_s: 5.05 }));
        assert_eq!(of(80), only(MissReason::Refractory { end_s: 5.08 }));
        assert_eq!(of(129), only(MissReason::Refractory { end_s: 5.08 }));
        assert_eq!(of(130), None, "it would have been taken");
        assert_eq!(of(50), None, "the event began at this tick");
    }

    #[test]
    fn an_event_in_progress_is_reported_beside_the_failed_conditions() {
        let quiet = supervisor(199, false);
        let not_armed = with(3.0, AlarmConditions { armed: false, ..ALL });
        let miss = explain(70, &[sample(0.0), not_armed], &quiet, DistanceKind::SquaredResidual).expect("a reason");
        assert_eq!(
            miss.reasons().copied().collect::<Vec<_>>(),
            [MissReason::NotArmed { quiet_s: 0.03, settle_s: 0.1 }, MissReason::EventUnderWay { begin_s: 5.05 }]
        );
    }

    #[test]
    fn an_alarm_that_counts_for_another_rupture_hides_the_samples_after_it() {
        let of = |tick, samples: &[DetectorSample]| {
            let history = SupervisorHistory::of_alarms(&[105]);
            explain(tick, samples, &history, DistanceKind::SquaredResidual).map(|miss| miss.reason)
        };
        let another = Some(MissReason::AlarmOfAnother { alarm_s: 5.105 });
        assert_eq!(of(105, &[sample(3.0)]), another);
        assert_eq!(of(100, &[sample(0.5); 10]), another);
        let not_armed = AlarmConditions { armed: false, ..ALL };
        let before = [sample(0.0), with(3.0, not_armed), sample(0.0), sample(0.0), sample(0.0), sample(9.0)];
        assert_eq!(of(100, &before), Some(MissReason::NotArmed { quiet_s: 0.03, settle_s: 0.1 }));
        // The window includes its tenth tick.
        assert_eq!(of(94, &[sample(0.5); 10]), Some(MissReason::BelowThreshold { reached: 0.25 }));
        assert_eq!(of(95, &[sample(0.5); 10]), another);
    }

    #[test]
    fn every_reason_has_a_word_a_key_and_a_remedy_that_removes_it() {
        let (mut contact_m, mut detector, mut augmentation) =
            (0.5, DetectorSettings::default(), AugmentationSettings::default());
        detector.cusum.threshold = 2.0;
        detector.arming.minimum_depth_m = 0.01;
        let cases = [
            (MissReason::NotInContact { depth_m: -1e-3 }, "not-in-contact", "estimator.contact_m"),
            (MissReason::NotArmed { quiet_s: 0.03, settle_s: 0.1 }, "not-armed", "detector.settle_s"),
            (MissReason::NoDrop, "no-drop", "detector.drop_only"),
            (MissReason::WrongMotion { velocity_m_per_s: 0.0 }, "wrong-motion", "detector.motion"),
            (MissReason::TooShallow { depth_m: 1e-3 }, "too-shallow", "detector.minimum_depth_m"),
            (MissReason::BelowThreshold { reached: 0.5 }, "below-threshold", "detector.threshold"),
            (MissReason::BelowDrift { largest: 0.3 }, "below-drift", "detector.drift"),
            (MissReason::EventUnderWay { begin_s: 1.0 }, "event-under-way", "augmentation.max_hold_s"),
            (MissReason::Refractory { end_s: 1.0 }, "refractory", "augmentation.refractory_s"),
            (MissReason::EarlierEvent, "earlier-event", "augmentation.enabled"),
            (MissReason::NotReady { waits_for: "noise" }, "not-ready", "detector.distance"),
            (MissReason::NoFall, "no-fall", "detector.distance"),
            (MissReason::AfterAlarm { alarm_s: 1.0 }, "after-alarm", "detector.threshold"),
            (MissReason::AlarmOfAnother { alarm_s: 1.0 }, "alarm-of-another", "detector.settle_s"),
        ];
        for (reason, word, key) in cases {
            assert_eq!((reason.word().as_str(), reason.key()), (word, key));
            assert!(reason.remedy().len() > 20, "{word}");
            reason.remove(&mut contact_m, &mut detector, &mut augmentation);
        }
        assert!(contact_m < -1.0 && !augmentation.enabled);
        let arming = &detector.arming;
        assert_eq!(
            (arming.settle_s, arming.drop_only, arming.motion, arming.minimum_depth_m),
            (0.0, false, Motion::Any, 0.0)
        );
        assert!((detector.cusum.threshold - 0.9).abs() < 1e-12 && (detector.cusum.drift - 0.15).abs() < 1e-12);
    }

    #[test]
    fn reasons_are_reported_in_milliseconds_millimetres_and_percent() {
        for (reason, phrase) in [
            (MissReason::NotInContact { depth_m: -1.234e-3 }, "was 1.23 mm above"),
            (MissReason::NotInContact { depth_m: -1e-6 }, "less than 0.01 mm above"),
            (MissReason::NotArmed { quiet_s: 0.01234, settle_s: 0.1 }, "for 12.3 ms"),
            (MissReason::NotArmed { quiet_s: 0.01234, settle_s: 0.1 }, "is 100 ms"),
            (MissReason::WrongMotion { velocity_m_per_s: -0.0123 }, "at -12.3 mm/s"),
            (MissReason::TooShallow { depth_m: 4.5e-3 }, "at 4.5 mm"),
            (MissReason::BelowThreshold { reached: 0.1239 }, "reached 12.4 %"),
            (MissReason::BelowThreshold { reached: 1.26e-5 }, "reached less than 0.1 % of it"),
            (MissReason::BelowDrift { largest: 0.0012 }, "exceeded 1.200e-3"),
            (MissReason::EventUnderWay { begin_s: 1.5 }, "1.500 s"),
            (MissReason::Refractory { end_s: 2.25 }, "2.250 s"),
            (MissReason::AlarmOfAnother { alarm_s: 3.0 }, "3.000 s"),
            (MissReason::AfterAlarm { alarm_s: 0.5 }, "0.500 s"),
            (MissReason::NotReady { waits_for: "the noise" }, "waits for the noise"),
            (MissReason::NoFall, "no fall"),
            (MissReason::NoDrop, "drop_only"),
            (MissReason::EarlierEvent, "an earlier alarm"),
        ] {
            let message = reason.to_string();
            assert!(message.contains(phrase), "{message}");
        }
    }

    #[test]
    fn the_recommended_threshold_is_rounded_down() {
        let remedy = |reached| MissReason::BelowThreshold { reached }.remedy().into_owned();
        assert!(remedy(0.1239).contains("below 12.3 %"), "{}", remedy(0.1239));
        assert!(
            remedy(1.26e-5).contains("far lower")
                && remedy(0.0).contains("far lower")
                && remedy(2e-3).contains("below 0.2 %")
        );
    }

    #[test]
    fn the_warning_contains_the_rupture_all_reasons_and_the_key() {
        let miss = Miss { reason: MissReason::NoDrop, also: vec![MissReason::TooShallow { depth_m: 1e-3 }] };
        assert!(miss.to_string().ends_with("; also detector.minimum_depth_m: the needle was at 1 mm"), "{miss}");
        let warning = miss.warning(2, 1.25);
        assert!(warning.message.contains("rupture 2 at 1.250 s missed: "), "{warning:?}");
        assert_eq!(warning.place.as_deref(), Some("detector.drop_only"));
        assert_eq!(warning.remedy.as_deref(), Some("set detector.drop_only = false"));
    }

    #[test]
    fn a_sample_of_a_detector_has_the_conditions_before_its_update() {
        let mut detector = CusumDetector::<f64>::new(&DetectorSettings::default(), 1e-3);
        let input = |residual_n: f64| DetectorInput {
            force_n: 5.0 + residual_n,
            predicted_force_n: 5.0,
            residual_n,
            correction: [0.0; 2],
            depth_m: 0.02,
            velocity_m_per_s: 0.03,
            in_contact: true,
        };
        for _ in 0..150 {
            DetectorSample::update(&mut detector, &input(0.0));
        }
        let (decision, sample) = DetectorSample::update(&mut detector, &input(-0.5));
        assert!(decision.alarm && sample.conditions.armed && sample.conditions.is_drop);
        assert_eq!((sample.distance, sample.decision), (decision.distance, decision.decision));
        assert_eq!((sample.depth_m, sample.velocity_m_per_s, sample.distance), (0.02, 0.03, 0.25));
    }
}
