//! The dominant mode of the loop.

use super::{ClosedLoop, StabilityError};
use crate::lti::{Complex64, eigenvalues};

/// Maximum states for which all eigenvalues are computed.
const MAX_STATES: u64 = 240;

/// The closed loop's pole with the maximum modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// The pole, its imaginary part at least 0.
    pub pole: Complex64,
    /// Its modulus: the spectral radius of the one-tick matrix. The loop is stable below 1.
    pub spectral_radius: f64,
    /// `-Re s / |s|` with `z = exp(s T)`: 1 does not oscillate, below 0 it grows.
    pub damping_ratio: f64,
    /// `|Im s| / 2π` in Hz.
    pub frequency_hz: f64,
    /// `Re s` in 1/s, the growth rate.
    pub growth_per_s: f64,
}

impl Mode {
    fn new(pole: Complex64, tick_s: f64) -> Self {
        let s = pole.ln() / tick_s;
        Self {
            pole,
            spectral_radius: pole.norm(),
            damping_ratio: if s.norm() > 0.0 { -s.re / s.norm() } else { 0.0 },
            frequency_hz: s.im.abs() / std::f64::consts::TAU,
            growth_per_s: s.re,
        }
    }
}

impl ClosedLoop {
    /// The dominant mode: from the eigenvalues of the one-tick matrix, or, if a long delay makes it large, by counting
    /// the poles outside circles.
    ///
    /// # Errors
    /// [`StabilityError`] if neither can be computed.
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

    /// The outermost pole, by bisecting the radius of a circle with poles outside.
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
        let mut nearest = (f64::INFINITY, 0.0);
        self.walk(outside, |from, to| {
            for sample in [from, to] {
                let distance = (Complex64::new(1.0, 0.0) - sample.gain).norm();
                if distance < nearest.0 {
                    nearest = (distance, sample.angle_rad);
                }
            }
        })?;
        Ok(Complex64::from_polar(outside, nearest.1))
    }
}
