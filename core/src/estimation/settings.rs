//! What is estimated, from where, how it is forgotten, and how friction is seen.

crate::choice! {
    /// K and B; K alone, as the paper tries in 3.2.1; with friction; mu, lambda and n of eq. 2; or with and without
    /// friction, the smaller error counting.
    ///
    /// The first two are estimated by [`Rls`](super::Rls), all of them by an [`Estimator`](super::Estimator).
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Parameters at "estimator.parameters" = StiffnessAndDamping {
        /// `K` and `B`: `φ = (p, v)` (eq. 8).
        "stiffness-and-damping" => StiffnessAndDamping,
        /// `K` alone, as the paper tries on direct access (3.2.1): `φ = (p, 0)`, and `B` stays 0.
        "stiffness" => Stiffness,
        /// `K`, `B` and a friction force: what the paper leaves for the future (its conclusion).
        "stiffness-damping-friction" => StiffnessDampingFriction,
        /// `μ`, `λ` and the power `n` of Hunt and Crossley (eq. 2).
        "hunt-crossley" => HuntCrossley,
        /// Both with friction and without, and of each sample the smaller of the two errors.
        "least-residual" => LeastResidual,
    }
}

/// Greatest factor: a memory of 1e5 corrections. Closer to 1 the information would outgrow what a double can invert.
pub const MAX_FORGETTING_FACTOR: f64 = 0.99999;

crate::choice! {
    /// Restore the whole gain at reset_threshold (eq. 17), or forget a little with each correction.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Forgetting at "estimator.forgetting" = Resetting {
        /// All of the gain is restored when enough has been learnt (eq. 17).
        "resetting" => Resetting,
        /// With each correction everything older counts less, within bounds.
        ///
        /// ```text
        /// D_k = D_{k-1} + δ (α φ φᵀ - (1-λ) D_{k-1}),   F_k = (1/F_0 + D_k)⁻¹
        /// ```
        "exponential" => Exponential in "estimator.forgetting_" {
            /// How much everything older counts after a correction, for exponential.
            ///
            /// λ, from 0 to [`MAX_FORGETTING_FACTOR`].
            factor: f64 [crate::settings::Range::stated(
                0.0, MAX_FORGETTING_FACTOR, "from 0 to 0.99999, a memory of 1e5 corrections"
            )] = Forgetting::DEFAULT_FACTOR,
        },
    }
}

impl Forgetting {
    /// The factor unless another is given. In the long run a correction takes `1 - λ` of an error, where the default's
    /// resetting takes 0.28 on average over the ten between two restorations (`κ / (1 + κ k)`, `κ = 10`).
    pub const DEFAULT_FACTOR: f64 = 0.7;
}

crate::settings! {
    /// Where the depth of the samples begins.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ContactSettings in "estimator." {
        /// Where the estimator takes the tissue to begin.
        contact_m: f64 [ANY] = 0.0,
    }
}

crate::settings! {
    /// The regressor of friction, `length v / (|v| + speed)`.
    ///
    /// Both numbers are chosen here. The slower the speed, the more a needle that nearly rests shakes the regressor.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FrictionShape in "estimator.friction_" {
        /// Speed at which half of the friction acts.
        speed_m_per_s: f64 [POSITIVE]
            for Parameters::StiffnessDampingFriction | LeastResidual = 3e-3,
        /// Depth at which as much of an error is put down to the stiffness as to friction.
        length_m: f64 [POSITIVE] for Parameters::StiffnessDampingFriction | LeastResidual = 5e-3,
    }
}
