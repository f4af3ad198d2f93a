//! One layer that tears: its parameters, their keys and ranges.

use super::literature::{
    Bounds, FRICTION_N_PER_M, GRIP_N, STIFFENING_N_PER_M2, STIFFNESS_N_PER_M, THICKNESS_M, TOUGHNESS_J_PER_M2,
};
use super::model::DefaultLayer;
use trocar_core::error::{InvalidValue, require};

trocar_core::settings! {
    /// A layer that tears, see [`Tearing`](super::Tearing).
    ///
    /// The fields that [`LayerParameters`](super::LayerParameters) has too are the same keys, with the same defaults.
    ///
    /// The toughness is that of bovine liver, 164 J/m² (Gokgol, Basdogan and Canadinc, Med. Eng. Phys. 34, 2012). The
    /// other defaults are chosen here: with a crack of 1 mm in width, a slow insertion ruptures the layer at 1.3 N and
    /// cuts it at 0.16 N; an intact layer loses half of its force within seconds, as soft tissue does.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TearingLayer in "tissue.layer.*." {
        /// Thickness.
        thickness_m: f64 [POSITIVE] = 0.1,
        /// a_1 of the loading law a_1 d + a_2 d², with the deflection d; of a layer that tears k_0, the stiffness of a fast
        /// deflection.
        stiffness_n_per_m: f64 [STIFFNESS_N_PER_M.range()] = 250.0,
        /// a_2: the force has a part a_2 d² of the deflection d.
        stiffening_n_per_m2: f64 [STIFFENING_N_PER_M2.range()] = 0.0,
        /// Ratio of the stiffness of a slow deflection to k_0; 1: no relaxation.
        relaxed_share: f64 [POSITIVE_SHARE] = 0.5,
        /// Time constant of the relaxation of the intact layer, at least one tick.
        relaxation_time_s: f64 [POSITIVE] = 1.0,
        /// R: the work that tears a unit of area; 76 to 225 in liver.
        toughness_j_per_m2: f64 [POSITIVE] = 164.0,
        /// Length of a crack that doubles the compliance of the layer: the rupture force grows with its square root.
        release_length_m: f64 [POSITIVE] = 0.02,
        /// By how much more an unrelaxed force releases energy at the tip of the crack; 0: the rupture force is
        /// independent of the speed.
        concentration: f64 [NON_NEGATIVE] = 0.5,
        /// Friction on the shaft per length in the layer; 11 to 12 in liver (Okamura et al. 2004).
        friction_n_per_m: f64 [FRICTION_N_PER_M.range()] = 10.0,
        /// Friction on the shaft, independent of the length in the layer.
        grip_n: f64 [GRIP_N.range()] = 0.0,
    }
    where stiffness_n_per_m: |s| s.stiffness_n_per_m > 0.0, "above 0, for a layer that tears";
}

impl TearingLayer {
    /// Force in N at which a slow insertion ruptures the layer, with a crack of `crack_width_m` (m): `√(2 k₀ w ℓ R)`.
    #[must_use]
    pub fn rupture_force_n(&self, crack_width_m: f64) -> f64 {
        (2.0 * self.stiffness_n_per_m * crack_width_m * self.release_length_m * self.toughness_j_per_m2).sqrt()
    }

    /// Force in N at which the needle cuts on, with a crack of `crack_width_m` (m): `R w`.
    #[must_use]
    pub fn cutting_force_n(&self, crack_width_m: f64) -> f64 {
        self.toughness_j_per_m2 * crack_width_m
    }

    /// Whether it ruptures. A layer that is cut at no less than its rupture force gives way without a drop of force.
    #[must_use]
    pub fn ruptures(&self, crack_width_m: f64) -> bool {
        self.rupture_force_n(crack_width_m) > self.cutting_force_n(crack_width_m)
    }

    /// The slope in N/m of a fast deflection around a deflection under which the relaxed force is `force_n`: `k₀ + 2 a₂ d` with
    /// `k∞ d + a₂ d² = f`.
    #[must_use]
    pub fn fast_slope_n_per_m(&self, force_n: f64) -> f64 {
        let slow = self.stiffness_n_per_m * self.relaxed_share;
        self.stiffness_n_per_m - slow + (slow * slow + 4.0 * self.stiffening_n_per_m2 * force_n).sqrt()
    }

    /// Checks the ranges of its fields, on ticks of `tick_s` (s).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the key of the first number out of range.
    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.validate()?;
        let (key, relaxation) = ("tissue.layer.*.relaxation_time_s", self.relaxation_time_s);
        require(key, relaxation, relaxation >= tick_s, "at least simulation.tick_s").map(drop)
    }

    /// The layer where a scenario lists none, by name; all of its values are the defaults of the keys.
    #[must_use]
    pub fn default_list() -> Vec<DefaultLayer> {
        vec![("organ", vec![])]
    }

    /// The keys with values and ranges of measurements.
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
