use std::f64::consts::PI;

use super::{ClosedLoop, LinearLoop, StabilityError};
use trocar_engine::teleoperation::ControllerKind;
use trocar_lti::Complex64;

const FREQUENCIES: usize = 4000;

/// A machine with damping `b` under the held force `F = H(z) x` of the sampled position is passive at the hand if
///
/// ```text
/// b > (T / 2) / (1 - cos ωT) · Re[ (1 - exp(-jωT)) H(exp(jωT)) ]    for all 0 <= ω <= π/T
/// ```
/// (Colgate and Schenkel, *J. Robot. Syst.* 14, 1997). A wall `K + B (z - 1) / (T z)` gives `b > K T / 2 + |B|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledWall {
    pub tick_s: f64,
}

impl SampledWall {
    /// `law` maps `ωT` in rad (above 0) to N/m.
    pub fn min_damping_n_s_per_m(&self, law: impl Fn(f64) -> Complex64) -> f64 {
        let share = |k: usize| {
            // Denser near 0; includes π, where bounds are usually greatest.
            let part = k as f64 / FREQUENCIES as f64;
            let angle = PI * part * part;
            // The half-angle formula for 1 - cos ωT avoids cancellation near 0.
            let fall = 2.0 * (0.5 * angle).sin().powi(2);
            let step = Complex64::new(fall, angle.sin());
            0.5 * self.tick_s / fall * (step * law(angle)).re
        };
        (1..=FREQUENCIES).map(share).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledBound {
    pub min_damping_n_s_per_m: f64,
    pub damping_n_s_per_m: f64,
}

impl SampledBound {
    /// `None` if the force depends on more than the sampled position, or samples arrive between ticks.
    pub fn of(settings: &LinearLoop) -> Result<Option<Self>, StabilityError> {
        let applies = !settings.master_model.is_general()
            && settings.master.force_integral_gain == 0.0
            && settings.link.controller.kind == ControllerKind::PositionForce
            && settings.actuators.master_lag_s == 0.0
            && settings.master.coupling == trocar_engine::plant::Coupling::Physical
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

    pub fn is_passive(&self) -> bool {
        self.damping_n_s_per_m > self.min_damping_n_s_per_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_virtual_wall_needs_half_a_tick_of_stiffness_and_its_damping() {
        let wall = SampledWall { tick_s: 2e-3 };
        for (k, b) in [(1000.0, 0.0), (1000.0, 3.0), (0.0, 5.0), (500.0, -2.0)] {
            let law = |angle: f64| {
                let before = Complex64::from_polar(1.0, -angle);
                (Complex64::new(1.0, 0.0) - before) * (b / wall.tick_s) + k
            };
            let min = wall.min_damping_n_s_per_m(law);
            let expected = k * wall.tick_s / 2.0 + f64::abs(b);
            assert!((min - expected).abs() < 1e-5 * (1.0 + expected), "{min} {expected}");
        }
    }
}
