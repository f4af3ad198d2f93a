//! How an estimator forgets, and how it sees friction.

use crate::error::{InvalidValue, positive, require};

/// How the estimator gives up what it has learnt.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Forgetting {
    /// All of the gain is restored when enough has been learnt (eq. 17).
    #[default]
    Resetting,
    /// With each correction everything older counts less, within bounds.
    ///
    /// ```text
    /// D_k = D_{k-1} + δ (α φ φᵀ - (1-λ) D_{k-1}),   F_k = (1/F_0 + D_k)⁻¹
    /// ```
    Exponential {
        /// λ, from 0 to [`MAX_FORGETTING_FACTOR`].
        factor: f64,
    },
}

/// Greatest factor: a memory of 1e5 corrections. Closer to 1 the information would outgrow what a double can invert.
pub const MAX_FORGETTING_FACTOR: f64 = 0.99999;

impl Forgetting {
    /// The factor unless another is given. In the long run a correction takes `1 - λ` of an error, where the default's
    /// resetting takes 0.28 on average over the ten between two restorations (`κ / (1 + κ k)`, `κ = 10`).
    pub const DEFAULT_FACTOR: f64 = 0.7;

    pub(super) fn validate(self) -> Result<(), InvalidValue> {
        if let Self::Exponential { factor } = self {
            let allowed = (0.0..=MAX_FORGETTING_FACTOR).contains(&factor);
            require("estimator.forgetting_factor", factor, allowed, "from 0 to 0.99999, a memory of 1e5 corrections")?;
        }
        Ok(())
    }
}

/// The regressor of friction, `length v / (|v| + speed)`.
///
/// Both numbers are chosen here. At the speed half of the friction acts; the slower, the more a needle that nearly rests
/// shakes the regressor. The length says how much of an error is put down to friction: as much as to the stiffness at that
/// depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionShape {
    /// In m/s, above 0.
    pub speed_m_per_s: f64,
    /// In m, above 0.
    pub length_m: f64,
}

impl FrictionShape {
    /// The defaults.
    pub const DEFAULT: Self = Self { speed_m_per_s: 3e-3, length_m: 5e-3 };

    pub(super) fn validate(&self) -> Result<(), InvalidValue> {
        positive("estimator.friction_speed_m_per_s", self.speed_m_per_s)?;
        positive("estimator.friction_length_m", self.length_m)?;
        Ok(())
    }
}

impl Default for FrictionShape {
    fn default() -> Self {
        Self::DEFAULT
    }
}
