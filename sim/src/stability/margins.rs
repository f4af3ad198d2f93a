//! The stability margins of the loop gain.

use std::f64::consts::{PI, TAU};

use super::winding::Sample;
use super::{ClosedLoop, StabilityError};

/// Number of bisections of a crossing.
const BISECTIONS: usize = 60;

/// The changes of the loop gain that make the loop unstable. `None` where no such change does.
///
/// The critical point is `L = 1` (the link feeds back with the sign that `L` has), so a loop gain that crosses the
/// positive real axis does so at its phase crossover. `L` is the sampled loop gain at `z = exp(jωT)`, including the
/// holds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Margins {
    /// Minimum destabilising factor above 1 on the gain.
    pub gain: Option<f64>,
    /// Its frequency in Hz.
    pub gain_frequency_hz: Option<f64>,
    /// Maximum destabilising factor below 1, for a conditionally stable loop.
    pub gain_below: Option<f64>,
    /// Minimum phase in rad, in either direction.
    pub phase_rad: Option<f64>,
    /// Its frequency in Hz.
    pub phase_frequency_hz: Option<f64>,
    /// Minimum additional delay in s around the loop, as a continuous delay.
    pub delay_s: Option<f64>,
}

impl ClosedLoop {
    /// The margins of a stable loop; all `None` for an unstable one.
    ///
    /// # Errors
    /// [`StabilityError::TooFast`].
    pub fn margins(&self) -> Result<Margins, StabilityError> {
        let mut margins = Margins::default();
        if !self.is_stable()? {
            return Ok(margins);
        }
        let mut steps: Vec<(Sample, Sample)> = vec![];
        self.walk(1.0, |from, to| steps.push((*from, *to)))?;
        let hz = |angle: f64| angle / (TAU * self.tick_s());
        let mut phase_crossover = |angle: f64| {
            let real = self.loop_gain(1.0, angle).re;
            if real <= 0.0 {
                return;
            }
            let factor = 1.0 / real;
            if factor > 1.0 && margins.gain.is_none_or(|min| factor < min) {
                (margins.gain, margins.gain_frequency_hz) = (Some(factor), Some(hz(angle)));
            }
            if factor < 1.0 && margins.gain_below.is_none_or(|max| factor > max) {
                margins.gain_below = Some(factor);
            }
        };
        phase_crossover(0.0);
        phase_crossover(PI);
        for (from, to) in &steps {
            if from.gain.im * to.gain.im < 0.0 {
                phase_crossover(self.crossing(from, to, |sample| sample.gain.im));
            }
        }
        for (from, to) in &steps {
            let excess = |sample: &Sample| sample.gain.norm() - 1.0;
            if excess(from) * excess(to) >= 0.0 {
                continue;
            }
            let angle = self.crossing(from, to, excess);
            let lead = self.loop_gain(1.0, angle).arg();
            if margins.phase_rad.is_none_or(|min| lead.abs() < min) {
                (margins.phase_rad, margins.phase_frequency_hz) = (Some(lead.abs()), Some(hz(angle)));
            }
            let delay_s = lead.rem_euclid(TAU) / angle * self.tick_s();
            if margins.delay_s.is_none_or(|min| delay_s < min) {
                margins.delay_s = Some(delay_s);
            }
        }
        Ok(margins)
    }

    /// The angle in rad between two samples at which a function of the response changes its sign.
    fn crossing(&self, from: &Sample, to: &Sample, of: impl Fn(&Sample) -> f64) -> f64 {
        let (mut low, mut high) = (from.angle_rad, to.angle_rad);
        let sign = of(from).signum();
        for _ in 0..BISECTIONS {
            let angle_rad = 0.5 * (low + high);
            let middle = Sample { angle_rad, gain: self.loop_gain(1.0, angle_rad) };
            if of(&middle).signum() == sign { low = angle_rad } else { high = angle_rad }
        }
        0.5 * (low + high)
    }
}
