use std::f64::consts::{PI, TAU};

use super::response_path::{Path, Point};
use super::{ClosedLoop, StabilityError};

/// `L` is a rounding error above it.
pub const MAX_GAIN_MARGIN: f64 = 1e9;

/// Infinite if no change destabilises the loop. The critical point is `L = 1`: `L` includes the sign of the feedback.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Margins {
    /// Above 1.
    pub gain: Option<f64>,
    pub gain_frequency_hz: Option<f64>,
    /// Below 1, for a conditionally stable loop.
    pub gain_below: Option<f64>,
    /// In either direction.
    pub phase_rad: Option<f64>,
    pub phase_frequency_hz: Option<f64>,
    /// In continuous time.
    pub delay_s: Option<f64>,
}

impl ClosedLoop {
    pub fn margins(&self) -> Result<Margins, StabilityError> {
        if !self.is_stable()? {
            return Ok(Margins::default());
        }
        let unlimited = Some(f64::INFINITY);
        let mut margins = Margins { gain: unlimited, phase_rad: unlimited, delay_s: unlimited, ..Margins::default() };
        let hz = |angle: f64| angle / (TAU * self.tick_s());
        let path = Path::new(self, 1.0).down_to(1.0 / MAX_GAIN_MARGIN);
        let mut at_crossover = |point: Point| {
            if point.gain.re <= 0.0 {
                return;
            }
            let factor = (-point.ln_gain).exp();
            if factor > 1.0 && factor < MAX_GAIN_MARGIN && margins.gain.is_none_or(|min| factor < min) {
                (margins.gain, margins.gain_frequency_hz) = (Some(factor), Some(hz(point.angle_rad)));
            }
            if factor < 1.0 && margins.gain_below.is_none_or(|max| factor > max) {
                margins.gain_below = Some(factor);
            }
        };
        // L is real at both ends.
        at_crossover(path.at(0.0));
        at_crossover(path.at(PI));
        path.resolve(|from, to| path.positive_crossings(&from, &to, &mut at_crossover))?;
        Path::new(self, 1.0).unit_crossings(|point| {
            let angle = point.angle_rad;
            let lead = point.gain.arg();
            if margins.phase_rad.is_none_or(|min| lead.abs() < min) {
                (margins.phase_rad, margins.phase_frequency_hz) = (Some(lead.abs()), Some(hz(angle)));
            }
            let delay_s = lead.rem_euclid(TAU) / angle * self.tick_s();
            if margins.delay_s.is_none_or(|min| delay_s < min) {
                margins.delay_s = Some(delay_s);
            }
        })?;
        Ok(margins)
    }

    /// `ln` of the smallest gain change; infinite if not below `bound`, 0 for an unstable loop.
    pub(super) fn destabilising_change(&self, bound: f64) -> Result<f64, StabilityError> {
        if !self.is_stable()? {
            return Ok(0.0);
        }
        let bound = bound.min(MAX_GAIN_MARGIN.ln());
        let path = Path::new(self, 1.0).down_to((-bound).exp());
        let mut least = f64::INFINITY;
        let mut at_crossover = |point: Point| {
            let change = point.ln_gain.abs();
            if point.gain.re > 0.0 && change < bound {
                least = least.min(change);
            }
        };
        at_crossover(path.at(0.0));
        at_crossover(path.at(PI));
        path.resolve(|from, to| path.positive_crossings(&from, &to, &mut at_crossover))?;
        Ok(least)
    }
}
