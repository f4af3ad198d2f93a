//! How far the loop gain is from making the loop unstable.

use std::f64::consts::{PI, TAU};

use super::winding::Sample;
use super::{ClosedLoop, StabilityError};

/// Halvings by which a crossing is found.
const HALVINGS: usize = 60;

/// What the loop gain can be changed by, at one frequency after the other, before the loop is no longer stable. `None` where no
/// such change does it.
///
/// The critical point is `L = 1` (the link feeds back with the sign that `L` has), so a loop gain that crosses the positive
/// real axis does so at its phase crossover. `L` is that of the ticks: `z = exp(jωT)`, held inputs and all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Margins {
    /// Least factor above 1 on the gain.
    pub gain: Option<f64>,
    /// Where that is, in Hz.
    pub gain_frequency_hz: Option<f64>,
    /// Greatest factor below 1: a loop that needs its gain has one.
    pub gain_below: Option<f64>,
    /// Least phase in rad, either way.
    pub phase_rad: Option<f64>,
    /// Where that is, in Hz.
    pub phase_frequency_hz: Option<f64>,
    /// Least further delay in s around the loop, in one continuous piece.
    pub delay_s: Option<f64>,
}

impl ClosedLoop {
    /// The margins of a stable loop; none of one that is not.
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
            if factor > 1.0 && margins.gain.is_none_or(|least| factor < least) {
                (margins.gain, margins.gain_frequency_hz) = (Some(factor), Some(hz(angle)));
            }
            if factor < 1.0 && margins.gain_below.is_none_or(|greatest| factor > greatest) {
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
            if margins.phase_rad.is_none_or(|least| lead.abs() < least) {
                (margins.phase_rad, margins.phase_frequency_hz) = (Some(lead.abs()), Some(hz(angle)));
            }
            let delay_s = lead.rem_euclid(TAU) / angle * self.tick_s();
            if margins.delay_s.is_none_or(|least| delay_s < least) {
                margins.delay_s = Some(delay_s);
            }
        }
        Ok(margins)
    }

    /// The angle in rad between two samples at which something of the response changes its sign.
    fn crossing(&self, from: &Sample, to: &Sample, of: impl Fn(&Sample) -> f64) -> f64 {
        let (mut low, mut high) = (from.angle_rad, to.angle_rad);
        let sign = of(from).signum();
        for _ in 0..HALVINGS {
            let angle_rad = 0.5 * (low + high);
            let middle = Sample { angle_rad, gain: self.loop_gain(1.0, angle_rad) };
            if of(&middle).signum() == sign { low = angle_rad } else { high = angle_rad }
        }
        0.5 * (low + high)
    }
}
