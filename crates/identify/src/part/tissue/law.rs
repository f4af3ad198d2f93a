use super::super::signals::Signals;
use super::super::{Range, Spec};
use crate::filter::half;
use crate::measured::{VELOCITY_HALF_S, deviation};

/// At the depth d > 0 and the velocity v.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Law {
    /// `f = K d + B v`.
    KelvinVoigt,
    /// `f = μ dⁿ + λ dⁿ v`.
    HuntCrossley,
    /// `f = (a₁ d + a₂ d²) max(1 + c v, 0)`.
    Layer,
}

impl Law {
    pub(super) fn specs(self) -> [Option<Spec>; 3] {
        let positive = |key, name, unit| Some(Spec::new(key, name, unit, Range::Positive));
        match self {
            Self::KelvinVoigt => [
                positive("stiffness_n_per_m", "stiffness", "N/m"),
                positive("damping_n_s_per_m", "damping", "N·s/m"),
                None,
            ],
            Self::HuntCrossley => [
                positive("mu", "stiffness μ", "N/m^n"),
                positive("lambda", "damping λ", "N·s/m^(n+1)"),
                positive("power", "power n of the depth", "1"),
            ],
            Self::Layer => [
                positive("stiffness_n_per_m", "stiffness a₁", "N/m"),
                positive("damping_s_per_m", "damping c", "s/m"),
                positive("stiffening_n_per_m2", "stiffening a₂", "N/m²"),
            ],
        }
    }

    /// In N, at a depth above 0.
    pub(super) fn force_n(self, values: &[f64], depth_m: f64, velocity: f64) -> f64 {
        match self {
            Self::KelvinVoigt => values[0] * depth_m + values[1] * velocity,
            Self::HuntCrossley => depth_m.powf(values[2]) * (values[0] + values[1] * velocity),
            Self::Layer => depth_m * (values[0] + values[2] * depth_m) * (1.0 + values[1] * velocity).max(0.0),
        }
    }

    /// Matches a spring and damper at half the depth.
    pub(super) fn start(self, stiffness: f64, damping: f64, depth_m: f64) -> Vec<f64> {
        match self {
            Self::KelvinVoigt => vec![stiffness, damping],
            Self::HuntCrossley => {
                let power = (0.5 * depth_m).powf(1.25);
                vec![stiffness * 0.5 * depth_m / power, damping / power, 1.25]
            }
            Self::Layer => vec![stiffness, damping / (0.5 * stiffness * depth_m), 0.1 * stiffness / depth_m],
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Velocity {
    /// Over 5 ms, for tissues.
    Slope,
    /// As the program of a virtual tissue computes it.
    Difference,
}

impl Velocity {
    pub(super) fn of(self, signals: &Signals) -> Vec<f64> {
        let Signals { position_m, interval_s, velocity_m_per_s, .. } = signals;
        match self {
            Self::Slope => velocity_m_per_s.clone(),
            Self::Difference => {
                let first = std::iter::once(0.0);
                first.chain(position_m.windows(2).map(|pair| (pair[1] - pair[0]) / interval_s)).collect()
            }
        }
    }

    /// Factor by which rounded positions reduce the estimated damping: `1 - σ²/s²` with the variances s² of the
    /// velocity and σ² of its rounding error. Positions rounded to q have an error of variance q²/12.
    pub(super) fn reduction(self, recordings: &[Signals]) -> f64 {
        let (mut rounding, mut total) = (0.0, 0.0);
        for one in recordings {
            let changes = one.position_m.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            // Smaller differences are rounding errors of double precision.
            let step_m = changes.filter(|change| *change > 1e-12).fold(f64::INFINITY, f64::min);
            // Σ of the squared weights of the positions in the velocity, times the interval squared.
            let weights = match self {
                Self::Slope => {
                    let half = half(VELOCITY_HALF_S, one.interval_s);
                    1.0 / (1..=half).map(|k| 2.0 * (k * k) as f64).sum::<f64>()
                }
                Self::Difference => 2.0,
            };
            let velocities = self.of(one);
            // Rounding does not change at rest.
            let moving = velocities.iter().filter(|velocity| **velocity != 0.0).count();
            rounding += moving as f64 * weights * (step_m / one.interval_s).powi(2) / 12.0;
            total += deviation(&velocities).powi(2);
        }
        (1.0 - rounding / total).clamp(0.5, 1.0)
    }

    pub(super) fn other(self) -> Self {
        match self {
            Self::Slope => Self::Difference,
            Self::Difference => Self::Slope,
        }
    }
}
