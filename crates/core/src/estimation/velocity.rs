use crate::error::{InvalidValue, positive, require};
use crate::lane::Lane;

/// A Kalman filter in steady state (Bélanger 1992): transition `p += T v`, acceleration of standard deviation `a` held
/// over each tick, position in steps of `q` (variance `q²/12`):
///
/// ```text
/// p⁻ = p + T v,   p = p⁻ + l₀ (y - p⁻),   v = v + l₁ (y - p⁻)
/// ```
#[derive(Debug, Clone)]
pub struct VelocityFilter<L> {
    tick_s: L,
    gain: [L; 2],
    position_m: L,
    velocity_m_per_s: L,
    started: bool,
}

impl<L: Lane> VelocityFilter<L> {
    /// `acceleration_m_per_s2` is a standard deviation.
    pub fn new(tick_s: f64, resolution_m: f64, acceleration_m_per_s2: f64) -> Result<Self, InvalidValue> {
        positive("simulation.tick_s", tick_s)?;
        positive("sensor.position_resolution_m", resolution_m)?;
        positive("sensor.acceleration_std_m_per_s2", acceleration_m_per_s2)?;
        let gain = steady_gain(tick_s, resolution_m * resolution_m / 12.0, acceleration_m_per_s2);
        let usable = gain.iter().all(|gain| gain.is_finite());
        require("sensor.position_resolution_m", resolution_m, usable, "a step that is realistic for an encoder")?;
        Ok(Self {
            tick_s: L::splat(tick_s),
            gain: gain.map(L::splat),
            position_m: L::zero(),
            velocity_m_per_s: L::zero(),
            started: false,
        })
    }

    /// Returns the velocity (m/s); the first position (m) starts the filter at rest.
    #[inline(always)]
    pub fn update(&mut self, position_m: L) -> L {
        if !self.started {
            self.started = true;
            self.position_m = position_m;
        }
        let predicted = self.position_m + self.tick_s * self.velocity_m_per_s;
        let innovation = position_m - predicted;
        self.position_m = predicted + self.gain[0] * innovation;
        self.velocity_m_per_s = self.velocity_m_per_s + self.gain[1] * innovation;
        self.velocity_m_per_s
    }

    /// Resumes at a position (m) after a gap; returns the last velocity (m/s).
    pub fn resume(&mut self, position_m: L) -> L {
        self.started = true;
        self.position_m = position_m;
        self.velocity_m_per_s
    }
}

/// For a measurement variance `r` (m²) (Kalata 1984): `Λ = a T² / √r`, `ρ = (4 + Λ - √(8Λ + Λ²)) / 4`, `l₀ = 1 - ρ²`,
/// `T l₁ = 2 (1 - ρ)²`.
fn steady_gain(tick_s: f64, r: f64, acceleration: f64) -> [f64; 2] {
    let index = acceleration * tick_s * tick_s / libm::sqrt(r);
    let rho = (4.0 + index - libm::sqrt(8.0 * index + index * index)) / 4.0;
    [1.0 - rho * rho, 2.0 * (1.0 - rho) * (1.0 - rho) / tick_s]
}

crate::lane::gather!(VelocityFilter { tick_s, gain, position_m, velocity_m_per_s } same { started } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gain_is_the_limit_of_the_riccati_recursion() {
        let (t, resolution, acceleration): (f64, f64, f64) = (1e-3, 1e-5, 2.0);
        let (r, a) = (resolution * resolution / 12.0, acceleration * acceleration);
        let (q00, q01, q11) = (a * t.powi(4) / 4.0, a * t.powi(3) / 2.0, a * t * t);
        let (mut p00, mut p01, mut p11) = (r, 0.0, r / (t * t));
        let mut gain = [0.0, 0.0];
        for _ in 0..20_000 {
            let (m00, m01, m11) = (p00 + 2.0 * t * p01 + t * t * p11 + q00, p01 + t * p11 + q01, p11 + q11);
            gain = [m00 / (m00 + r), m01 / (m00 + r)];
            (p00, p01, p11) = ((1.0 - gain[0]) * m00, (1.0 - gain[0]) * m01, m11 - gain[1] * m01);
        }
        let closed = steady_gain(t, r, acceleration);
        assert!((gain[0] - closed[0]).abs() < 1e-9, "{gain:?} {closed:?}");
        assert!((gain[1] - closed[1]).abs() < 1e-9 * closed[1], "{gain:?} {closed:?}");
    }

    #[test]
    fn the_filter_beats_differences_on_quantised_positions() {
        let (tick, resolution) = (1e-3, 1e-5);
        let mut filter = VelocityFilter::<f64>::new(tick, resolution, 0.5).expect("valid");
        let (mut filtered, mut differenced, mut last) = (0.0, 0.0, 0.0);
        for k in 0..4000 {
            let t = f64::from(k) * tick;
            let (position, velocity) = (0.01 * (3.0 * t).sin(), 0.03 * (3.0 * t).cos());
            let read = (position / resolution).round() * resolution;
            let estimate = filter.update(read);
            if k > 500 {
                filtered += (estimate - velocity).powi(2);
                differenced += ((read - last) / tick - velocity).powi(2);
            }
            last = read;
        }
        assert!(filtered < 0.05 * differenced, "{filtered} {differenced}");
    }

    #[test]
    fn a_resolution_of_zero_is_refused() {
        assert!(VelocityFilter::<f64>::new(1e-3, 0.0, 1.0).is_err());
    }
}
