use nalgebra::{Matrix3, Vector3};

use crate::IdentifyError;
use crate::filter::{slope, smooth};
use crate::intervals::{BLOCKS, student};
use crate::measured::{Measured, deviation};

/// Half the smoothing window. Both sides of the regression pass the same filter, so it adds no bias; it removes encoder
/// noise, which would bias the gains towards 0.
const HALF_WINDOW_S: f64 = 10e-3;

const REPEATED: usize = 3;

const LONGEST_DELAY_S: f64 = 0.05;

/// Minimum explained share of the actuator's force.
const LEAST_SHARE: f64 = 0.5;

/// With a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// In N/m, N·s/m and s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Controller {
    pub(crate) position_gain: Bounded,
    pub(crate) velocity_gain: Bounded,
    pub(crate) delay: Bounded,
}

impl Controller {
    /// The regression `u(t + δ_0) = c_0 e + c_1 ė + c_2 ë` gives `K_p = c_0`; for a controller that acts δ later,
    /// `c_1 = K_d - K_p δ` and `c_2 = K_p δ²/2 - K_d δ`. Repeating it with δ_0 increased by δ removes the error of the
    /// expansion. The interval includes the changes at half and at twice the smoothing. `None` without an actuator
    /// force.
    pub(crate) fn of(recordings: &[Measured]) -> Result<Option<Self>, IdentifyError> {
        let with_actuator: Vec<&Measured> = recordings.iter().filter(|one| one.actuator_n.is_some()).collect();
        if with_actuator.is_empty() {
            return Ok(None);
        }
        let regression = Regression::of(&with_actuator, HALF_WINDOW_S);
        let rougher = Regression::of(&with_actuator, 0.5 * HALF_WINDOW_S);
        let refuse =
            |share: f64, gain: f64| IdentifyError::Actuator { gain_n_per_m: gain, share_percent: 100.0 * share };
        let smoother = Regression::of(&with_actuator, 2.0 * HALF_WINDOW_S);
        let (Some(regression), Some(rougher), Some(smoother)) = (regression, rougher, smoother) else {
            return Err(refuse(0.0, 0.0));
        };
        let gain = regression.coefficients[0];
        if regression.share < LEAST_SHARE || gain <= 0.0 {
            return Err(refuse(regression.share, gain));
        }
        let values = regression.physical();
        let others = [rougher, smoother].map(|other| other.physical());
        let bounded = |index: usize| {
            let mut gradient = Vector3::zeros();
            for (k, slope) in gradient.iter_mut().enumerate() {
                let step = 1e-6 * regression.coefficients[k].abs();
                let mut moved = regression.coefficients;
                moved[k] += step;
                let change = physical(&moved)[index] - physical(&regression.coefficients)[index];
                *slope = if step > 0.0 { change / step } else { 0.0 };
            }
            let variance = gradient.dot(&(regression.covariance * gradient)).max(0.0);
            let freedom = (BLOCKS * with_actuator.len()) as f64 - 3.0;
            let value = values[index];
            let changes: f64 = others.iter().map(|other| (other[index] - value).abs()).sum();
            let half = student(freedom) * variance.sqrt() + changes;
            Bounded { value, low: (value - half).max(0.0), high: value + half }
        };
        Ok(Some(Self { position_gain: bounded(0), velocity_gain: bounded(1), delay: bounded(2) }))
    }
}

fn physical(coefficients: &Vector3<f64>) -> [f64; 3] {
    let [gain, rate, second] = [coefficients[0], coefficients[1], coefficients[2]];
    let discriminant = rate * rate - 2.0 * gain * second;
    if !(gain > 0.0 && discriminant >= 0.0) {
        return [gain, rate, 0.0];
    }
    let delay_s = (discriminant.sqrt() - rate) / gain;
    [gain, rate + gain * delay_s, delay_s]
}

struct Regression {
    /// Assumed by the regression.
    delay_s: f64,
    coefficients: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Explained share of the actuator's force.
    share: f64,
}

impl Regression {
    /// `None` if the error between master and slave does not vary.
    fn of(recordings: &[&Measured], half_s: f64) -> Option<Self> {
        let smoothed: Vec<Smoothed> = recordings.iter().filter_map(|one| Smoothed::of(one, half_s)).collect();
        let mut regression = Self::with_delay(&smoothed, 0.0)?;
        for _ in 0..REPEATED {
            let [.., delay_s] = regression.physical();
            regression = Self::with_delay(&smoothed, delay_s)?;
        }
        Some(regression)
    }

    fn physical(&self) -> [f64; 3] {
        let [gain, rate, delay_s] = physical(&self.coefficients);
        [gain, rate.max(0.0), (self.delay_s + delay_s).clamp(0.0, LONGEST_DELAY_S)]
    }

    fn with_delay(recordings: &[Smoothed], delay_s: f64) -> Option<Self> {
        let mut normal = Matrix3::zeros();
        let mut right = Vector3::zeros();
        let parts: Vec<Vec<(Vector3<f64>, f64)>> = recordings.iter().map(|one| one.rows(delay_s)).collect();
        for (row, target) in parts.iter().flatten() {
            normal += row * row.transpose();
            right += row * *target;
        }
        let inverse = scaled_inverse(&normal)?;
        let coefficients = inverse * right;
        let mut meat = Matrix3::zeros();
        let mut squares = 0.0;
        for part in &parts {
            for block in part.chunks(part.len().div_ceil(BLOCKS).max(1)) {
                let mut score = Vector3::zeros();
                for (row, target) in block {
                    let residual = target - row.dot(&coefficients);
                    score += row * residual;
                    squares += residual * residual;
                }
                meat += score * score.transpose();
            }
        }
        let spread: f64 =
            parts.iter().map(|part| deviation(&part.iter().map(|row| row.1).collect::<Vec<_>>()).powi(2)).sum();
        let covariance = inverse * meat * inverse;
        let is_finite = coefficients.iter().chain(covariance.iter()).all(|value| value.is_finite());
        (is_finite && spread > 0.0).then(|| Self {
            delay_s,
            coefficients,
            covariance,
            share: 1.0 - (squares / spread).sqrt(),
        })
    }
}

/// e, ė, ë and the actuator's force.
struct Smoothed {
    interval_s: f64,
    error: [Vec<f64>; 3],
    force_n: Vec<f64>,
    /// Samples at each end that smoothing distorts.
    skipped: usize,
}

impl Smoothed {
    fn of(measured: &Measured, half_s: f64) -> Option<Self> {
        let actuator_n = measured.actuator_n.as_ref()?;
        let half = ((half_s / measured.interval_s).round() as usize).clamp(1, measured.len() / 16);
        let error_m: Vec<f64> =
            measured.master_m.iter().zip(&measured.slave_m).map(|(master, slave)| master - slave).collect();
        let error_m = smooth(&error_m, half);
        let rate = slope(&error_m, 1, measured.interval_s);
        let second = slope(&rate, 1, measured.interval_s);
        let (error, force_n) = ([error_m, rate, second], smooth(actuator_n, half));
        Some(Self { interval_s: measured.interval_s, error, force_n, skipped: 2 * half + 2 })
    }

    /// Rows (e, ė, ë) with the actuator's force a delay later, without the ends.
    fn rows(&self, delay_s: f64) -> Vec<(Vector3<f64>, f64)> {
        let Self { interval_s, error: [error_m, rate, second], force_n, skipped } = self;
        let (later, share) = ((delay_s / interval_s) as usize, (delay_s / interval_s).fract());
        let inner = *skipped..force_n.len().saturating_sub(skipped + later);
        let delayed_n = |k: usize| force_n[k + later] + share * (force_n[k + later + 1] - force_n[k + later]);
        inner.map(|k| (Vector3::new(error_m[k], rate[k], second[k]), delayed_n(k))).collect()
    }
}

/// Scaled, because the units differ; `None` if singular.
fn scaled_inverse(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let scale = matrix.diagonal().map(|value| 1.0 / value.sqrt());
    let scaling = Matrix3::from_diagonal(&scale);
    let inverse = (scaling * matrix * scaling).cholesky()?.inverse();
    Some(scaling * inverse * scaling)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A controller that acts 1.2 ms late, on a motion of 1 and 3 Hz, without noise.
    fn controlled(sign: f64) -> Measured {
        let (gain, damping, delay_s) = (4000.0, 25.0, 1.2e-3);
        let error = |t: f64| 1e-3 * (6.0 * t).sin() + 5e-4 * (19.0 * t).cos();
        let rate = |t: f64| 6e-3 * (6.0 * t).cos() - 9.5e-3 * (19.0 * t).sin();
        let mut one =
            crate::measured::tests::measured(0.0005, 8000, |t| (0.01 * t.sin() + error(t), 0.01 * t.sin(), 0.0));
        let at = |k: usize| k as f64 * 0.0005 - delay_s;
        one.actuator_n = Some((0..8000).map(|k| sign * (gain * error(at(k)) + damping * rate(at(k)))).collect());
        one
    }

    #[test]
    fn gains_and_delay_are_recovered_from_the_actuators_force() {
        let controller = Controller::of(&[controlled(1.0)]).expect("good").expect("an actuator");
        for (bounded, truth) in
            [(controller.position_gain, 4000.0), (controller.velocity_gain, 25.0), (controller.delay, 1.2e-3)]
        {
            assert!((bounded.value / truth - 1.0).abs() < 0.01, "{bounded:?} against {truth}");
        }
    }

    #[test]
    fn an_actuator_with_the_opposite_sign_is_refused() {
        let error = Controller::of(&[controlled(-1.0)]).expect_err("refused").to_string();
        assert!(error.contains("check the sign and the column of --actuator"), "{error}");
    }
}
