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

crate::settings! {
    /// How the estimator weighs, ignores and forgets.
    ///
    /// # Choosing the gain
    /// The share of an error that one update corrects is `φᵀFφ / (1/α + φᵀFφ)`. With the constant weighting `α = 1`
    /// (`normalisation = 0`) that share depends on the depth through `F_0 φᵀφ`: settings for a needle centimetres deep
    /// hardly correct at all a few millimetres deep. With eq. 14 it is `F_0 φᵀφ / (1 + (β + F_0) φᵀφ)`: beyond the depth
    /// `1/√β` it becomes `κ / (1 + κ)` with `κ = F_0 / β`, whatever the depth. The same holds for forgetting: each update
    /// adds `δ α φᵀφ → δ/β` to `x`, so that the gain is restored after about `N` full corrections when
    /// `α_0 = tr(F_0⁻¹) + N/β`.
    ///
    /// [`RlsSettings::normalised`] is that rule; its defaults (1 mm, κ = 10, N = 10 updates) serve depths from millimetres
    /// to decimetres and rates of 1 and 2 kHz alike. The price: within the first millimetre the estimator is slow.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RlsSettings in "estimator." {
        /// Which parameters there are.
        parameters: Parameters,
        /// How the regressor of friction turns with the velocity.
        friction: FrictionShape,
        /// How what was learnt is given up.
        forgetting: Forgetting,
        /// beta of eq. 14 in 1/m²: the gain no longer depends on depths beyond 1/sqrt(beta); 0: constant weighting.
        ///
        /// `β I`; 0 is `α = 1`.
        normalisation: f64 [NON_NEGATIVE] = 1e6,
        /// F_0 of eq. 13, times the identity.
        ///
        /// In 1/m² when the weighting is constant, per unit of `φᵀφ` in general.
        initial_gain: f64 [POSITIVE] => "10 times the normalisation, or 1e4 without one"
            if normalisation > 0.0 { 10.0 * normalisation } else { 1e4 },
        /// alpha_0 of eq. 17, at which F_0 is restored.
        ///
        /// Above `tr(F_0⁻¹) = 2 / initial_gain`.
        reset_threshold: f64 [POSITIVE] =>
            "2/initial_gain + 10/normalisation (ten full corrections), or 2/initial_gain + 5e-4 without one"
            2.0 / initial_gain + if normalisation > 0.0 { 10.0 / normalisation } else { 5e-4 },
        /// N_0 of eq. 15: smaller errors teach nothing.
        dead_zone_n: f64 [NON_NEGATIVE] = 0.03,
    }
    where reset_threshold: |s| s.reset_threshold > 2.0 / s.initial_gain, "above 2 / estimator.initial_gain (eq. 17)";
}

impl RlsSettings {
    /// The rule of the type's documentation: depth beyond which the gain is constant (m), `κ = F_0/β`, updates between
    /// two restorations of the gain, dead zone (N).
    #[must_use]
    pub fn normalised(full_gain_depth_m: f64, gain_ratio: f64, memory_updates: f64, dead_zone_n: f64) -> Self {
        let normalisation = 1.0 / (full_gain_depth_m * full_gain_depth_m);
        let initial_gain = gain_ratio * normalisation;
        let reset_threshold = 2.0 / initial_gain + memory_updates / normalisation;
        Self {
            initial_gain,
            reset_threshold,
            dead_zone_n,
            normalisation,
            parameters: Parameters::default(),
            forgetting: Forgetting::default(),
            friction: FrictionShape::default(),
        }
    }
}
