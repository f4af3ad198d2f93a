//! The chain on a live stream: samples come one by one, some late, some not at all.

use serde::Serialize;

use super::EVEN_SHARE;
use super::chain::{DetectionChain, Step, VelocitySource};
use crate::chain::Reading;
use crate::error::InvalidValue;
use crate::moments::Moments;
use crate::recording::{Limits, LiveSample};
use crate::scenario::DetectionSettings;

/// After how many rows on end, each later than the one before but all earlier than the last sample, the clock counts as
/// set back.
const SET_BACK_ROWS: u32 = 10;

/// A step of more intervals than this has lost samples in it.
const MAX_OF_ONE_STEP: f64 = 1.5;

/// One tick of the stream with what came of it.
#[derive(Debug, Clone, Copy)]
pub struct LiveStep {
    /// When, in the stream's own time, in s.
    pub time_s: f64,
    /// Which tick, from 0.
    pub sample: u64,
    /// What was measured, or interpolated where a sample was lost.
    pub reading: Reading<f64>,
    /// What came of it.
    pub step: Step,
}

/// What is odd about a sample's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimestampAnomaly {
    /// It does not come after the last one; the sample is left out.
    NotLater {
        /// The time of the last sample in s.
        last_s: f64,
        /// Its own in s.
        time_s: f64,
    },
    /// So many rows were earlier than the last sample that the clock must have been set back; all begins anew.
    SetBack {
        /// The time of the last sample in s.
        last_s: f64,
        /// Its own in s.
        time_s: f64,
    },
    /// Nothing came for longer than may be interpolated; all begins anew.
    Gap {
        /// The time of the last sample in s.
        last_s: f64,
        /// Its own in s.
        time_s: f64,
    },
}

/// What has been found so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LiveSummary {
    /// Ticks that estimator and detector took.
    pub samples: u64,
    /// Their interval in s; none before it is known.
    pub interval_s: Option<f64>,
    /// Their time, in s.
    pub duration_s: f64,
    /// Of that in contact, in s.
    pub contact_s: f64,
    /// Alarms.
    pub alarms: u64,
    /// Of the ticks, those that were interpolated as their samples were lost.
    pub interpolated: u64,
    /// Steps of time that differ by more than 1 % from the interval.
    pub uneven: u64,
    /// Samples left out as their time does not come after the last one's.
    pub not_later: u64,
    /// Times that all began anew: after a gap, or as the clock was set back.
    pub restarts: u64,
    /// Mean of the residual in N; none without samples, like the next three.
    pub mean_n: Option<f64>,
    /// Its standard deviation in N.
    pub std_n: Option<f64>,
    /// Mean of its magnitude in N.
    pub mean_absolute_n: Option<f64>,
    /// Its largest magnitude in N.
    pub max_absolute_n: Option<f64>,
}

/// Estimator and detector on a stream, in constant memory.
///
/// # Time
/// Both count samples, so the stream is taken as ticks, `interval_s` apart: given, or the time between the first two samples.
/// A step of up to 1.5 intervals is one tick. A longer one, of up to ten intervals, has lost samples in it: they are
/// interpolated linearly, as a file's are. After a longer one, and when the clock has been set back (ten rows on end, each
/// later than the one before, all earlier than the last sample), nothing before it says anything of what follows: filter,
/// estimator and detector begin anew, and no alarm is taken until the contact has been quiet for the detector's
/// `settle_s`. A sample that does not come after the last one is left out.
///
/// Evenly spaced samples give the bits that [`detect`](super::detect) gives with the same interval.
#[derive(Debug)]
pub struct LiveDetector {
    settings: DetectionSettings,
    velocity: VelocitySource,
    interval_s: Option<f64>,
    chain: Option<DetectionChain>,
    last: Option<LiveSample>,
    /// The last row that was not later than the last sample, and how many such have ascended.
    behind: (f64, u32),
    in_contact: u64,
    residual: ResidualSums,
    summary: LiveSummary,
}

impl LiveDetector {
    /// A detector that has seen nothing, for ticks of `interval_s` (s), or of what the first two samples say.
    ///
    /// # Errors
    /// [`InvalidValue`] for an interval or a step of the positions that is not a positive finite number.
    pub fn new(
        settings: DetectionSettings,
        interval_s: Option<f64>,
        velocity: VelocitySource,
    ) -> Result<Self, InvalidValue> {
        let mut detector = Self {
            settings,
            velocity,
            interval_s: None,
            chain: None,
            last: None,
            behind: (f64::NEG_INFINITY, 0),
            in_contact: 0,
            residual: ResidualSums::default(),
            summary: LiveSummary::default(),
        };
        if let Some(interval_s) = interval_s {
            detector.set_interval(interval_s)?;
        }
        Ok(detector)
    }

    /// Takes a sample, hands each tick that it completes to `emit`, and says what is odd about it.
    ///
    /// # Errors
    /// [`InvalidValue`] where the first two samples are no interval that the velocity filter can work with.
    pub fn take(
        &mut self,
        sample: &LiveSample,
        mut emit: impl FnMut(&LiveStep),
    ) -> Result<Option<TimestampAnomaly>, InvalidValue> {
        let Some(last) = self.last else {
            // Without an interval the first sample waits for the second.
            self.last = Some(*sample);
            if self.interval_s.is_some() {
                self.tick(sample, &mut emit);
            }
            return Ok(None);
        };
        let (last_s, time_s) = (last.time_s, sample.time_s);
        if time_s <= last_s {
            return Ok(Some(self.not_later(sample, last_s, &mut emit)));
        }
        self.behind.1 = 0;
        self.last = Some(*sample);
        let interval_s = match self.interval_s {
            Some(interval_s) => interval_s,
            None => {
                let interval_s = time_s - last_s;
                self.set_interval(interval_s)?;
                self.tick(&last, &mut emit);
                interval_s
            }
        };
        let steps = (time_s - last_s) / interval_s;
        if steps > Limits::GAP_IN_MEDIANS * (1.0 + 1e-9) {
            self.restart(sample, &mut emit);
            return Ok(Some(TimestampAnomaly::Gap { last_s, time_s }));
        }
        let ticks = if steps > MAX_OF_ONE_STEP { steps.round() } else { 1.0 };
        self.summary.uneven += u64::from((steps / ticks - 1.0).abs() > EVEN_SHARE);
        for lost in 1..ticks as u32 {
            self.summary.interpolated += 1;
            let share = f64::from(lost) / ticks;
            self.tick(&between(&last, sample, share), &mut emit);
        }
        self.tick(sample, &mut emit);
        Ok(None)
    }

    /// How far apart the ticks are, in s; none before it is known.
    #[must_use]
    pub fn interval_s(&self) -> Option<f64> {
        self.interval_s
    }

    /// What has been found so far.
    #[must_use]
    pub fn summary(&self) -> LiveSummary {
        let interval_s = self.interval_s.unwrap_or(0.0);
        let ResidualSums { moments, absolute_n, max_absolute_n } = &self.residual;
        let count = moments.count as f64;
        let defined = |value: f64| (moments.count > 0).then_some(value);
        LiveSummary {
            interval_s: self.interval_s,
            duration_s: self.summary.samples as f64 * interval_s,
            contact_s: self.in_contact as f64 * interval_s,
            mean_n: defined(moments.mean),
            std_n: defined((moments.squares / count).sqrt()),
            mean_absolute_n: defined(absolute_n / count),
            max_absolute_n: defined(*max_absolute_n),
            ..self.summary.clone()
        }
    }

    fn set_interval(&mut self, interval_s: f64) -> Result<(), InvalidValue> {
        self.chain = Some(DetectionChain::new(&self.settings, interval_s, self.velocity)?);
        self.interval_s = Some(interval_s);
        Ok(())
    }

    fn not_later(&mut self, sample: &LiveSample, last_s: f64, emit: &mut impl FnMut(&LiveStep)) -> TimestampAnomaly {
        let time_s = sample.time_s;
        let (before_s, rows) = self.behind;
        let ascends = rows > 0 && time_s > before_s;
        self.behind = (time_s, if ascends { rows + 1 } else { 1 });
        if self.behind.1 < SET_BACK_ROWS {
            self.summary.not_later += 1;
            return TimestampAnomaly::NotLater { last_s, time_s };
        }
        self.behind.1 = 0;
        self.last = Some(*sample);
        self.restart(sample, emit);
        TimestampAnomaly::SetBack { last_s, time_s }
    }

    /// Begins anew with a sample; before the interval is known there is nothing to begin.
    fn restart(&mut self, sample: &LiveSample, emit: &mut impl FnMut(&LiveStep)) {
        let Some(interval_s) = self.interval_s else { return };
        self.summary.restarts += 1;
        // The same interval and settings as before, which were good.
        self.chain = DetectionChain::new(&self.settings, interval_s, self.velocity).ok();
        self.tick(sample, emit);
    }

    #[inline]
    fn tick(&mut self, sample: &LiveSample, emit: &mut impl FnMut(&LiveStep)) {
        let Some(chain) = &mut self.chain else { return };
        let &LiveSample { time_s, position_m, velocity_m_per_s, force_n } = sample;
        let reading = Reading { position_m, velocity_m_per_s, force_n };
        let step = chain.step(&reading);
        self.residual.add(step.estimate.residual_n);
        self.in_contact += u64::from(step.depth_m > 0.0);
        self.summary.alarms += u64::from(step.decision.alarm);
        emit(&LiveStep { time_s, sample: self.summary.samples, reading, step });
        self.summary.samples += 1;
    }
}

/// The sample at a share of the way from one to another.
fn between(from: &LiveSample, to: &LiveSample, share: f64) -> LiveSample {
    let mix = |from: f64, to: f64| from + (to - from) * share;
    LiveSample {
        time_s: mix(from.time_s, to.time_s),
        position_m: mix(from.position_m, to.position_m),
        velocity_m_per_s: mix(from.velocity_m_per_s, to.velocity_m_per_s),
        force_n: mix(from.force_n, to.force_n),
    }
}

/// What the summary says of the residual.
#[derive(Debug, Default)]
struct ResidualSums {
    moments: Moments,
    absolute_n: f64,
    max_absolute_n: f64,
}

impl ResidualSums {
    #[inline]
    fn add(&mut self, residual_n: f64) {
        self.moments.add(residual_n);
        self.absolute_n += residual_n.abs();
        self.max_absolute_n = self.max_absolute_n.max(residual_n.abs());
    }
}

#[cfg(test)]
mod tests;
