use std::f64::consts::TAU;

use super::response_path::Path;
use super::{ClosedLoop, StabilityError};
use trocar_lti::{Complex64, eigenvalues};

const MAX_STATES: u64 = 240;

const NEWTON_STEPS: usize = 4;
const MAX_STEP: f64 = 1e-6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// With a nonnegative imaginary part.
    pub pole: Complex64,
    pub spectral_radius: f64,
    /// `-Re s / |s|` with `z = exp(s T)`.
    pub damping_ratio: f64,
    /// `|Im s| / 2π`.
    pub frequency_hz: f64,
    /// `Re s`.
    pub growth_per_s: f64,
}

impl Mode {
    fn new(pole: Complex64, tick_s: f64) -> Self {
        let s = pole.ln() / tick_s;
        Self {
            pole,
            spectral_radius: pole.norm(),
            damping_ratio: if s.norm() > 0.0 { -s.re / s.norm() } else { 0.0 },
            frequency_hz: s.im.abs() / TAU,
            growth_per_s: s.re,
        }
    }
}

impl ClosedLoop {
    /// Counts poles outside circles if the matrix is too large for eigenvalues.
    pub fn dominant_mode(&self) -> Result<Mode, StabilityError> {
        let pole = if self.states() <= MAX_STATES {
            let (matrix, _, _) = self.matrix()?;
            let poles = eigenvalues(&matrix)?;
            let dominant = poles.into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
            dominant.unwrap_or_else(|| Complex64::new(0.0, 0.0))
        } else {
            self.outermost_pole()?
        };
        Ok(Mode::new(Complex64::new(pole.re, pole.im.abs()), self.tick_s()))
    }

    fn outermost_pole(&self) -> Result<Complex64, StabilityError> {
        let (mut inside, mut outside) = (0.0, 1.0);
        while self.poles_outside(outside)? > 0 {
            inside = outside;
            outside *= 2.0;
        }
        if inside == 0.0 {
            inside = 0.5;
        }
        while outside - inside > 1e-12 {
            let middle = 0.5 * (inside + outside);
            if self.poles_outside(middle)? > 0 { inside = middle } else { outside = middle }
        }
        // At a pole |L| crosses 1 on its circle.
        let mut nearest = (f64::INFINITY, 0.0);
        Path::new(self, outside).unit_crossings(|point| {
            let distance = (Complex64::new(1.0, 0.0) - point.gain).norm();
            if distance < nearest.0 {
                nearest = (distance, point.angle_rad);
            }
        })?;
        Ok(self.polished(Complex64::from_polar(outside, nearest.1)))
    }

    fn polished(&self, estimate: Complex64) -> Complex64 {
        let ticks = self.round_trip_ticks() as f64;
        let mut z = estimate;
        for _ in 0..NEWTON_STEPS {
            let [master, slave] = self.responses_at(z);
            let [of_master, of_slave] = self.relative_slopes_at(z);
            let ln_gain = (master * slave).ln() - z.ln() * ticks;
            let turns = (ln_gain.im / TAU).round();
            let step = (ln_gain - Complex64::new(0.0, TAU * turns)) / (of_master + of_slave - z.inv() * ticks);
            // A long step leads to another pole.
            if !step.is_finite() || step.norm() > MAX_STEP {
                return estimate;
            }
            z -= step;
        }
        z
    }
}
