use super::Parameters;

/// Closer to 1 the information is too large to invert.
pub const MAX_FORGETTING_FACTOR: f64 = 0.99999;

crate::choice! {
    /// Restore the whole gain at reset_threshold (eq. 17), or forget a little with each correction.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Forgetting at "estimator.forgetting" = Resetting {
        "resetting" => Resetting,
        "exponential" => Exponential in "estimator.forgetting_" {
            /// Weight of older samples after a correction, for exponential.
            factor: f64 [crate::settings::Range::stated(
                0.0, MAX_FORGETTING_FACTOR, "from 0 to 0.99999, a memory of 1e5 corrections"
            )] = Forgetting::DEFAULT_FACTOR,
        },
    }
}

impl Forgetting {
    /// A correction takes `1 - λ` of an error; default resetting takes 0.28 on average.
    pub const DEFAULT_FACTOR: f64 = 0.7;
}

crate::settings! {
    /// Where the depth begins.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ContactSettings in "estimator." {
        /// Position of the tissue surface assumed by the estimator.
        contact_m: f64 [ANY] = 0.0,
    }
}

crate::settings! {
    /// The regressor of friction, `length v / (|v| + speed)`, noisier near standstill with a lower speed.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FrictionShape in "estimator.friction_" {
        /// Speed at which half of the friction acts.
        speed_m_per_s: f64 [POSITIVE]
            for Parameters::StiffnessDampingFriction | LeastResidual = 3e-3,
        /// Depth at which an error is attributed to stiffness and friction in equal parts.
        length_m: f64 [POSITIVE] for Parameters::StiffnessDampingFriction | LeastResidual = 5e-3,
    }
}

crate::settings! {
    /// Weighting, dead zone and forgetting of the estimator.
    ///
    /// With `F_0` one update corrects the share `F_0 φᵀφ / (1 + (β + F_0) φᵀφ)` of an error (eq. 14), beyond the depth
    /// `1/√β` nearly `κ / (1 + κ)`, `κ = F_0 / β`. With `α_0 = tr(F_0⁻¹) + N/β` about `N` full corrections restore the
    /// gain. By default `1/√β` is 1 mm, `κ = N = 10`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RlsSettings in "estimator." {
        /// Estimated parameters.
        parameters: Parameters,
        /// Regressor of friction.
        friction: FrictionShape,
        /// Kind of forgetting.
        forgetting: Forgetting,
        /// β of eq. 14 in 1/m²: beyond the depth 1/sqrt(β) the gain does not depend on the depth; 0 gives constant
        /// weighting.
        normalisation: f64 [NON_NEGATIVE] = 1e6,
        /// F_0 of eq. 13, times the identity.
        initial_gain: f64 [POSITIVE] => "10 times the normalisation, or 1e4 without one"
            if normalisation > 0.0 { 10.0 * normalisation } else { 1e4 },
        /// α_0 of eq. 17, at which F_0 is restored.
        reset_threshold: f64 [POSITIVE] for Forgetting::Resetting =>
            "2/initial_gain + 10/normalisation (ten full corrections), or 2/initial_gain + 5e-4 without one"
            2.0 / initial_gain + if normalisation > 0.0 { 10.0 / normalisation } else { 5e-4 },
        /// N_0 of eq. 15: smaller errors cause no correction.
        dead_zone_n: f64 [NON_NEGATIVE] = 0.03,
    }
    where reset_threshold: |s| s.reset_threshold > 2.0 / s.initial_gain, "above 2 / estimator.initial_gain (eq. 17)";
}

impl RlsSettings {
    /// The depth is `1/√β`, the ratio `κ`, the memory `N`.
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
