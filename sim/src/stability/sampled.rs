//! The passivity of a machine that is fed a force computed from its sampled position.

use std::f64::consts::PI;

use super::{ClosedLoop, LoopSettings, StabilityError};
use crate::lti::Complex64;
use crate::teleoperation::ControllerKind;

/// How many frequencies a bound is the greatest of.
const FREQUENCIES: usize = 4000;

/// `F = H(z) x` from the sampled position, held from tick to tick, against a machine of damping `b`: passive towards the hand
/// where
///
/// ```text
/// b > (T / 2) / (1 - cos ωT) · Re[ (1 - exp(-jωT)) H(exp(jωT)) ]    for all 0 <= ω <= π/T
/// ```
/// (Colgate and Schenkel 1997, *Passivity of a class of sampled-data systems: application to haptic interfaces*). A wall
/// `K + B (z - 1) / (T z)` gives `b > K T / 2 + |B|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledWall {
    /// The tick in s.
    pub tick_s: f64,
}

impl SampledWall {
    /// The least damping in N·s/m for a force law, which is given `ωT` in rad, 0 excluded, and answers in N/m.
    #[must_use]
    pub fn min_damping_n_s_per_m(&self, law: impl Fn(f64) -> Complex64) -> f64 {
        let share = |k: usize| {
            // Close to 0 as well as to π, where bounds are usually greatest.
            let part = k as f64 / FREQUENCIES as f64;
            let angle = PI * part * part;
            // 1 - cos ωT by half the angle, as the difference is all rounding close to 0.
            let fall = 2.0 * (0.5 * angle).sin().powi(2);
            let step = Complex64::new(fall, angle.sin());
            0.5 * self.tick_s / fall * (step * law(angle)).re
        };
        (1..=FREQUENCIES).map(share).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The condition applied to a loop: the force that comes back over the link is the law, the master's own damping is `b`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledBound {
    /// Damping that passivity asks for in N·s/m.
    pub min_damping_n_s_per_m: f64,
    /// Damping that there is.
    pub damping_n_s_per_m: f64,
}

impl SampledBound {
    /// The bound of a loop. `None` where the condition says nothing about it: with a force integral (the force then depends
    /// on more than the sampled position), with another controller than the paper's, with samples that arrive between
    /// ticks, or with a motor that lags.
    ///
    /// # Errors
    /// [`StabilityError`] where the loop cannot be built.
    pub fn of(settings: &LoopSettings) -> Result<Option<Self>, StabilityError> {
        let applies = settings.master.force_integral_gain == 0.0
            && settings.link.controller.kind == ControllerKind::PositionForce
            && settings.actuators.master_lag_s == 0.0
            && settings.master.coupling == crate::plant::Coupling::Physical
            && settings.backward().share == 0.0;
        if !applies {
            return Ok(None);
        }
        let closed = ClosedLoop::new(settings)?;
        let scale = settings.link.machines.position_scale;
        let wall = SampledWall { tick_s: settings.tick_s };
        let law = |angle: f64| closed.force_per_reference(angle) * scale;
        Ok(Some(Self {
            min_damping_n_s_per_m: wall.min_damping_n_s_per_m(law),
            damping_n_s_per_m: settings.master.damping_n_s_per_m,
        }))
    }

    /// Whether there is enough.
    #[must_use]
    pub fn is_passive(&self) -> bool {
        self.damping_n_s_per_m > self.min_damping_n_s_per_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_virtual_wall_asks_for_half_a_tick_of_stiffness_and_its_damping() {
        let wall = SampledWall { tick_s: 2e-3 };
        for (k, b) in [(1000.0, 0.0), (1000.0, 3.0), (0.0, 5.0), (500.0, -2.0)] {
            let law = |angle: f64| {
                let before = Complex64::from_polar(1.0, -angle);
                (Complex64::new(1.0, 0.0) - before) * (b / wall.tick_s) + k
            };
            let least = wall.min_damping_n_s_per_m(law);
            let expected = k * wall.tick_s / 2.0 + f64::abs(b);
            assert!((least - expected).abs() < 1e-5 * (1.0 + expected), "{least} {expected}");
        }
    }
}
