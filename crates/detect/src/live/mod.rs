use serde::Serialize;

use super::chain::{DetectionChain, Step, VelocitySource};
use super::even::EVEN_SHARE;
use trocar_base::moments::Moments;
use trocar_core::chain::Measurement;
use trocar_core::error::{InvalidValue, require};
use trocar_core::set_back::SetBack;
use trocar_recording::{Limits, LiveSample};
use trocar_scenario::DetectionSettings;

/// In intervals; a longer step has lost samples.
const MAX_INTERVALS_OF_ONE_TICK: f64 = 1.5;

#[derive(Debug, Clone, Copy)]
pub struct LiveStep {
    pub time_s: f64,
    /// From 0.
    pub sample: u64,
    /// Interpolated if a sample was lost.
    pub measurement: Measurement<f64>,
    pub step: Step,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimestampAnomaly {
    /// The sample is omitted.
    NotLater {
        /// Time of the last sample.
        last_s: f64,
        time_s: f64,
    },
    /// After ten consecutive earlier rows. The detection restarts.
    SetBack {
        /// Time of the last sample.
        last_s: f64,
        time_s: f64,
    },
    /// Too long for interpolation. The detection restarts.
    Gap {
        /// Time of the last sample.
        last_s: f64,
        time_s: f64,
    },
}

#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LiveSummary {
    pub samples: u64,
    /// `None` before it is known.
    pub interval_s: Option<f64>,
    pub duration_s: f64,
    pub contact_s: f64,
    pub alarms: u64,
    /// Ticks for lost samples.
    pub interpolated: u64,
    /// Steps that differ by more than 1 % from the interval.
    pub uneven: u64,
    /// Omitted samples.
    pub not_later: u64,
    pub restarts: u64,
    /// Residual; `None` without samples.
    pub mean_n: Option<f64>,
    pub std_n: Option<f64>,
    pub mean_absolute_n: Option<f64>,
    pub max_absolute_n: Option<f64>,
}

/// Estimator and detector on a stream, in constant memory.
///
/// The stream is divided into ticks of `interval_s`, or of the first interval. Samples lost in a step of 1.5 to ten
/// intervals are interpolated linearly. After a longer step, or a clock that was set back, the chain restarts.
///
/// Evenly spaced samples give the same results, bit for bit, as [`detect`](super::detect).
#[derive(Debug)]
pub struct LiveDetector {
    settings: DetectionSettings,
    velocity: VelocitySource,
    interval_s: Option<f64>,
    chain: Option<DetectionChain>,
    last: Option<LiveSample>,
    behind: SetBack<f64>,
    in_contact: u64,
    residual: ResidualSums,
    summary: LiveSummary,
}

impl LiveDetector {
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
            behind: SetBack::default(),
            in_contact: 0,
            residual: ResidualSums::default(),
            summary: LiveSummary::default(),
        };
        if let Some(interval_s) = interval_s {
            detector.set_interval(interval_s)?;
        }
        Ok(detector)
    }

    /// Calls `emit` for each completed tick, and returns the anomaly of the sample's time. A sample that is not finite
    /// is an error.
    pub fn take(
        &mut self,
        sample: &LiveSample,
        mut emit: impl FnMut(&LiveStep),
    ) -> Result<Option<TimestampAnomaly>, InvalidValue> {
        let LiveSample { time_s, position_m, velocity_m_per_s, force_n } = *sample;
        let numbers = [
            ("time_s", time_s),
            ("position_m", position_m),
            ("velocity_m_per_s", velocity_m_per_s),
            ("force_n", force_n),
        ];
        for (name, value) in numbers {
            require(name, value, value.is_finite(), "a finite number")?;
        }
        let Some(last) = self.last else {
            // Without an interval, the first sample waits for the second.
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
        self.behind.clear();
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
        let ticks = if steps > MAX_INTERVALS_OF_ONE_TICK { steps.round() } else { 1.0 };
        self.summary.uneven += u64::from((steps / ticks - 1.0).abs() > EVEN_SHARE);
        for lost in 1..ticks as u32 {
            self.summary.interpolated += 1;
            let share = f64::from(lost) / ticks;
            self.tick(&between(&last, sample, share), &mut emit);
        }
        self.tick(sample, &mut emit);
        Ok(None)
    }

    pub fn interval_s(&self) -> Option<f64> {
        self.interval_s
    }

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
        if !self.behind.note(time_s) {
            self.summary.not_later += 1;
            return TimestampAnomaly::NotLater { last_s, time_s };
        }
        self.last = Some(*sample);
        self.restart(sample, emit);
        TimestampAnomaly::SetBack { last_s, time_s }
    }

    fn restart(&mut self, sample: &LiveSample, emit: &mut impl FnMut(&LiveStep)) {
        let Some(interval_s) = self.interval_s else { return };
        self.summary.restarts += 1;
        // Cannot fail: interval and settings are unchanged.
        let restarted = |chain: DetectionChain| chain.restarted(&self.settings, interval_s, self.velocity).ok();
        self.chain = self.chain.take().and_then(restarted);
        self.tick(sample, emit);
    }

    #[inline]
    fn tick(&mut self, sample: &LiveSample, emit: &mut impl FnMut(&LiveStep)) {
        let Some(chain) = &mut self.chain else { return };
        let (time_s, measurement) = (sample.time_s, measurement(sample));
        let step = chain.step(&measurement);
        self.residual.add(step.estimate.residual_n);
        self.in_contact += u64::from(step.depth_m > 0.0);
        self.summary.alarms += u64::from(step.decision.alarm);
        emit(&LiveStep { time_s, sample: self.summary.samples, measurement, step });
        self.summary.samples += 1;
    }
}

fn measurement(sample: &LiveSample) -> Measurement<f64> {
    let &LiveSample { position_m, velocity_m_per_s, force_n, .. } = sample;
    Measurement { position_m, velocity_m_per_s, force_n }
}

fn between(from: &LiveSample, to: &LiveSample, share: f64) -> LiveSample {
    let Measurement { position_m, velocity_m_per_s, force_n } = measurement(from).between(&measurement(to), share);
    let time_s = from.time_s + (to.time_s - from.time_s) * share;
    LiveSample { time_s, position_m, velocity_m_per_s, force_n }
}

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
