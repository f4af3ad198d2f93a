//! The number of closed-loop poles outside a circle, by the argument principle.

use std::f64::consts::PI;

use super::{ClosedLoop, StabilityError};
use crate::interrupt;
use crate::lti::Complex64;

/// Maximum number of evaluations of a response.
const MAX_EVALUATIONS: usize = 4_000_000;

/// Below this gain `1 - L` cannot encircle 0.
const SMALL_GAIN: f64 = 0.25;

/// An open-loop pole nearer to the circle than this, relative to its radius, counts as on it.
const ON_THE_CIRCLE: f64 = 1e-9;

/// A point of the response.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) angle_rad: f64,
    pub(super) gain: Complex64,
}

impl Sample {
    /// `1 - L`.
    fn difference(&self) -> Complex64 {
        Complex64::new(1.0, 0.0) - self.gain
    }
}

impl ClosedLoop {
    /// The number of closed-loop poles outside or on the circle of a radius.
    ///
    /// `1 - L = det(z I - M) / det(z I - M_open)`, with `M_open` the loop without its link. By the argument principle
    /// the number of poles outside is that of the open loop minus the winding number of `1 - L` along the circle. The
    /// points are dense near open-loop poles; steps are bisected until `1 - L` changes by less than 0.6 of its distance
    /// from 0 and the delay's phase by less than 0.8 rad, or the loop gain is too small to matter.
    ///
    /// At an open-loop pole on the circle the response does not exist: the radius is then reduced by a few parts in
    /// 10⁹, which counts such poles as outside.
    ///
    /// # Errors
    /// [`StabilityError::TooFast`] if that needs too many points.
    pub fn poles_outside(&self, radius: f64) -> Result<usize, StabilityError> {
        interrupt::check();
        let mut radius = radius;
        while self.open_poles.iter().any(|pole| (pole.norm() - radius).abs() < ON_THE_CIRCLE * radius) {
            radius *= 1.0 - 2.5 * ON_THE_CIRCLE;
        }
        let outside = self.open_poles.iter().filter(|pole| pole.norm() > radius).count();
        let mut turned = 0.0;
        let mut touches = false;
        self.walk(radius, |from, to| {
            let step = (to.difference() / from.difference()).arg();
            touches |= step.abs().is_nan() || step.abs() > 1.5;
            turned += step;
        })?;
        // Upper half of the circle; the lower half contributes the same.
        let turns = (turned / PI).round();
        if touches || !turns.is_finite() {
            return Ok(outside.max(1));
        }
        Ok((outside as f64 - turns).max(0.0) as usize)
    }

    /// The largest magnitude of the loop gain at the points of a walk along the unit circle.
    pub(super) fn max_gain(&self) -> Result<f64, StabilityError> {
        let mut max = 0.0_f64;
        self.walk(1.0, |from, to| max = max.max(from.gain.norm_sqr()).max(to.gain.norm_sqr()))?;
        Ok(max.sqrt())
    }

    /// Walks along the upper half of a circle in steps over which `1 - L` changes little; calls `step` with the ends of
    /// each.
    pub(super) fn walk(&self, radius: f64, mut step: impl FnMut(&Sample, &Sample)) -> Result<(), StabilityError> {
        let sample = |angle_rad: f64| Sample { angle_rad, gain: self.loop_gain(radius, angle_rad) };
        let ticks = 1.0 + self.round_trip_ticks() as f64;
        let mut evaluations = 0;
        let mut last: Option<Sample> = None;
        let mut open: Vec<Sample> = vec![];
        for angle_rad in self.angles(radius) {
            let end = sample(angle_rad);
            let Some(mut from) = last.replace(end) else { continue };
            open.clear();
            open.push(end);
            while let Some(&to) = open.last() {
                let width = to.angle_rad - from.angle_rad;
                let is_small = |sample: &Sample| sample.gain.norm_sqr() < SMALL_GAIN * SMALL_GAIN;
                let small = is_small(&from) && is_small(&to);
                let (a, b) = (from.difference(), to.difference());
                let nearest = a.norm_sqr().min(b.norm_sqr());
                let straight = ticks * width < 0.8 && (b - a).norm_sqr() < 0.6 * 0.6 * nearest;
                if small || straight || width < 1e-14 {
                    step(&from, &to);
                    from = to;
                    open.pop();
                    continue;
                }
                evaluations += 1;
                if evaluations > MAX_EVALUATIONS {
                    return Err(StabilityError::TooFast { evaluations });
                }
                open.push(sample(0.5 * (from.angle_rad + to.angle_rad)));
            }
        }
        Ok(())
    }

    /// Initial angles of the response in rad, increasing from 0 to π.
    fn angles(&self, radius: f64) -> Vec<f64> {
        const OFFSETS: [f64; 4] = [0.0, 0.5, 1.6, 6.0];
        let mut angles: Vec<f64> = vec![0.0, PI];
        angles.extend((0..12).map(|k| PI * 0.5_f64.powi(k)));
        for pole in self.open_poles.iter().filter(|pole| pole.im >= 0.0 && pole.norm() > 1e-3) {
            let (at, reach) = (pole.arg(), (pole.norm() / radius - 1.0).abs());
            angles.extend(OFFSETS.iter().flat_map(|share| [at - share * reach, at + share * reach]));
        }
        angles.retain(|angle| (0.0..=PI).contains(angle));
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    }
}
