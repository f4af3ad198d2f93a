use std::f64::consts::PI;

use super::response_path::{Path, Point, Segment};
use super::{ClosedLoop, StabilityError};
use trocar_base::interrupt;
use trocar_lti::Complex64;

/// Relative; an open-loop pole closer to the circle counts as on it.
const ON_THE_CIRCLE: f64 = 1e-9;

/// Above it, `1/L` is below the rounding of 1.
const LN_HUGE: f64 = 40.0;

/// Distance below which a closed-loop pole counts as on the circle.
const TOUCHES: f64 = 1e-12;

impl ClosedLoop {
    /// Includes poles on the circle.
    ///
    /// `1 - L = det(z I - M) / det(z I - M_open)`, with `M_open` the loop without its link. By the argument principle
    /// the number of poles outside is the open loop's minus the winding number of `1 - L`.
    ///
    /// If `|L| < 1`, `1 - L` stays in the right half-plane and turns by the difference of its arguments at the ends. If
    /// `|L| > 1`, it equals `-L (1 - 1/L)` and turns by the phase change of `L` plus that of `1 - 1/L`, which stays in
    /// the right half-plane.
    ///
    /// The response does not exist at an open-loop pole on the circle: a slightly smaller radius counts it as outside.
    pub fn poles_outside(&self, radius: f64) -> Result<usize, StabilityError> {
        interrupt::check();
        let mut radius = radius;
        while self.open_poles.iter().any(|pole| (pole.norm() - radius).abs() < ON_THE_CIRCLE * radius) {
            radius *= 1.0 - 2.5 * ON_THE_CIRCLE;
        }
        let outside = self.open_poles.iter().filter(|pole| pole.norm() > radius).count();
        let mut turned = 0.0;
        let mut touches = false;
        let one = Complex64::new(1.0, 0.0);
        Path::new(self, radius).walk(|segment| {
            let Segment { from, to, is_large } = segment;
            let turn = if is_large {
                // Far from 1 the magnitude may overflow.
                let rest = |point: &Point| {
                    if point.ln_gain > LN_HUGE { 0.0 } else { (one - point.gain.inv()).arg() }
                };
                let of_delay = -(self.round_trip_ticks() as f64) * (to.angle_rad - from.angle_rad);
                (to.sides / from.sides).arg() + of_delay + rest(&to) - rest(&from)
            } else {
                (one - to.gain).arg() - (one - from.gain).arg()
            };
            touches |= turn.is_nan() || (one - to.gain).norm() < TOUCHES;
            turned += turn;
        })?;
        let turns = (turned / PI).round();
        if touches || !turns.is_finite() {
            return Ok(outside.max(1));
        }
        Ok((outside as f64 - turns).max(0.0) as usize)
    }

    pub(super) fn max_gain(&self) -> Result<f64, StabilityError> {
        let mut max = 0.0_f64;
        Path::new(self, 1.0).walk(|segment| max = max.max(segment.from.gain.norm()).max(segment.to.gain.norm()))?;
        Ok(max)
    }
}
