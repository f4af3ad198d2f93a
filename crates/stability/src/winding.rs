//! The number of closed-loop poles outside a circle, by the argument principle.

use std::f64::consts::PI;

use super::response_path::{Path, Point, Segment};
use super::{ClosedLoop, StabilityError};
use trocar_base::interrupt;
use trocar_lti::Complex64;

/// An open-loop pole nearer to the circle than this, relative to its radius, counts as on it.
const ON_THE_CIRCLE: f64 = 1e-9;

/// `ln |L|` from which `1/L` is below the rounding of 1.
const LN_HUGE: f64 = 40.0;

/// The distance of `L` from 1, on the circle, below which a closed-loop pole counts as on it.
const TOUCHES: f64 = 1e-12;

impl ClosedLoop {
    /// The number of closed-loop poles outside or on the circle of a radius.
    ///
    /// `1 - L = det(z I - M) / det(z I - M_open)`, with `M_open` the loop without its link. By the argument principle
    /// the number of poles outside is that of the open loop minus the winding number of `1 - L` along the circle.
    ///
    /// The phase of the delay is known exactly, so the cost does not depend on its length. Where `|L| < 1`, `1 - L` stays in
    /// the right half-plane and turns by the difference of its arguments at the ends. Where `|L| > 1`, it is `-L (1 - 1/L)`,
    /// and turns by the change of the phase of `L`, that of the sides minus `N Δω` of the delay, plus that of `1 - 1/L`, which
    /// stays in the right half-plane.
    ///
    /// At an open-loop pole on the circle the response does not exist: the radius is then reduced by a few parts in
    /// 10⁹, which counts such poles as outside.
    ///
    /// # Errors
    /// [`StabilityError::TooFast`] if the response of the sides changes too fast to be followed.
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
        // Upper half of the circle; the lower half contributes the same.
        let turns = (turned / PI).round();
        if touches || !turns.is_finite() {
            return Ok(outside.max(1));
        }
        Ok((outside as f64 - turns).max(0.0) as usize)
    }

    /// The largest magnitude of the loop gain on the unit circle, to within the resolution of a walk along it.
    pub(super) fn max_gain(&self) -> Result<f64, StabilityError> {
        let mut max = 0.0_f64;
        Path::new(self, 1.0).walk(|segment| max = max.max(segment.from.gain.norm()).max(segment.to.gain.norm()))?;
        Ok(max)
    }
}
