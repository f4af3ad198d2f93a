use super::literature::{
    Bounds, FRICTION_N_PER_M, GRIP_N, STIFFENING_N_PER_M2, STIFFNESS_N_PER_M, THICKNESS_M, TOUGHNESS_J_PER_M2,
};
use super::model::DefaultLayer;
use trocar_core::error::{InvalidValue, require};

trocar_core::settings! {
    /// Toughness of bovine liver (Gokgol et al. 2012); the others are chosen here, for a slow rupture at 1.3 N and a
    /// cut at 0.16 N with a crack of 1 mm. Keys shared with [`LayerParameters`](super::LayerParameters) have the same
    /// defaults.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TearingLayer in "tissue.layer.*." {
        /// Thickness of the layer.
        thickness_m: f64 [POSITIVE] = 0.1,
        /// a_1 of the loading law a_1 d + a_2 d², with the deflection d; for a layer that tears k_0, the stiffness of a
        /// fast deflection.
        stiffness_n_per_m: f64 [STIFFNESS_N_PER_M.range()] = 250.0,
        /// a_2 of the loading law, which adds a_2 d² to the force at the deflection d.
        stiffening_n_per_m2: f64 [STIFFENING_N_PER_M2.range()] = 0.0,
        /// Ratio of the stiffness of a slow deflection to k_0; with 1 there is no relaxation.
        relaxed_share: f64 [POSITIVE_SHARE] = 0.5,
        /// Time constant of the relaxation of the intact layer, at least one tick.
        relaxation_time_s: f64 [POSITIVE] = 1.0,
        /// R: work that tears a unit of area; 76 to 225 in liver.
        toughness_j_per_m2: f64 [POSITIVE] = 164.0,
        /// Length of a crack that doubles the compliance of the layer; the rupture force grows with its square root.
        release_length_m: f64 [POSITIVE] = 0.02,
        /// Additional energy release of an unrelaxed force at the tip of the crack, as a factor; with 0 the rupture
        /// force is independent of the speed.
        concentration: f64 [NON_NEGATIVE] = 0.5,
        /// Friction on the shaft per length in the layer; 11 to 12 in liver (Okamura et al. 2004).
        friction_n_per_m: f64 [FRICTION_N_PER_M.range()] = 10.0,
        /// Friction on the shaft, independent of the length in the layer.
        grip_n: f64 [GRIP_N.range()] = 0.0,
    }
    where stiffness_n_per_m: |s| s.stiffness_n_per_m > 0.0, "above 0, for a layer that tears";
}

impl TearingLayer {
    /// `√(2 k₀ w ℓ R)`, for a slow insertion.
    pub fn rupture_force_n(&self, crack_width_m: f64) -> f64 {
        (2.0 * self.stiffness_n_per_m * crack_width_m * self.release_length_m * self.toughness_j_per_m2).sqrt()
    }

    /// `R w`, for steady cutting.
    pub fn cutting_force_n(&self, crack_width_m: f64) -> f64 {
        self.toughness_j_per_m2 * crack_width_m
    }

    /// Otherwise the layer gives way without a drop of force.
    pub fn ruptures(&self, crack_width_m: f64) -> bool {
        self.rupture_force_n(crack_width_m) > self.cutting_force_n(crack_width_m)
    }

    /// `k₀ + 2 a₂ d` around the deflection with `k∞ d + a₂ d² = force_n`.
    pub fn fast_slope_n_per_m(&self, force_n: f64) -> f64 {
        let slow = self.stiffness_n_per_m * self.relaxed_share;
        self.stiffness_n_per_m - slow + (slow * slow + 4.0 * self.stiffening_n_per_m2 * force_n).sqrt()
    }

    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.validate()?;
        let (key, relaxation) = ("tissue.layer.*.relaxation_time_s", self.relaxation_time_s);
        require(key, relaxation, relaxation >= tick_s, "at least simulation.tick_s").map(drop)
    }

    pub fn default_list() -> Vec<DefaultLayer> {
        vec![("organ", vec![])]
    }

    pub(super) fn measured(&self) -> [(&'static str, f64, &'static Bounds); 6] {
        [
            ("tissue.layer.*.thickness_m", self.thickness_m, &THICKNESS_M),
            ("tissue.layer.*.stiffness_n_per_m", self.stiffness_n_per_m, &STIFFNESS_N_PER_M),
            ("tissue.layer.*.stiffening_n_per_m2", self.stiffening_n_per_m2, &STIFFENING_N_PER_M2),
            ("tissue.layer.*.toughness_j_per_m2", self.toughness_j_per_m2, &TOUGHNESS_J_PER_M2),
            ("tissue.layer.*.friction_n_per_m", self.friction_n_per_m, &FRICTION_N_PER_M),
            ("tissue.layer.*.grip_n", self.grip_n, &GRIP_N),
        ]
    }
}
