//! A nonlinear spring until the layer ruptures, then a constant cutting force and friction along the shaft (Simone
//! 2002, Okamura et al. 2004).
//!
//! Defaults and measurements (see [`literature`](super::literature)): rupture force 0.3 to 3 N (median 1.22 N; liver
//! 1.48 to 3.13 N), cutting force 0.3 to 1 N (0.05 to 1.3 N), `a₁` 60 to 150 N/m (liver 2 to 48), `a₂` 0 to 35 000 N/m²
//! (liver 2300 to 5200), friction 0 to 50 N/m (liver 10.6 to 12). The others are chosen here, as is the division of the
//! total of Barbé et al. (2007, 3.2.2): up to 5.69 N with a pull of 2.45 N.

use super::literature::{
    Bounds, CUTTING_FORCE_N, DAMPING_S_PER_M, DEFLECTION_M, FRICTION_N_PER_M, GRIP_N, RUPTURE_FORCE_N,
    STIFFENING_N_PER_M2, STIFFNESS_N_PER_M, THICKNESS_M,
};
use super::model::DefaultLayer;
use trocar_core::error::{InvalidValue, require};

pub const MAX_RELAXATION_S: f64 = 10.0;

trocar_core::settings! {
    /// `f(d) = (a₁ d + a₂ d²) max(1 + c v, 0)` for `d >= 0`: the polynomial of Okamura et al., damped as in eq. 2
    /// (`λ = c μ`).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LayerParameters in "tissue.layer.*." {
        /// Thickness of the layer.
        thickness_m: f64 [POSITIVE] = 0.1,
        /// a_1 of the loading law a_1 d + a_2 d², with the deflection d; for a layer that tears k_0, the stiffness of a
        /// fast deflection.
        stiffness_n_per_m: f64 [STIFFNESS_N_PER_M.range()] = 250.0,
        /// a_2 of the loading law, which adds a_2 d² to the force at the deflection d.
        stiffening_n_per_m2: f64 [STIFFENING_N_PER_M2.range()] = 0.0,
        /// Force at which the layer ruptures, median 1.22 (van Gerwen et al. 2012); at least the cutting force.
        rupture_force_n: f64 [RUPTURE_FORCE_N.range()] = 0.3,
        /// Force at which the needle cuts through the layer after the rupture, median 0.95 (van Gerwen et al. 2012).
        cutting_force_n: f64 [CUTTING_FORCE_N.range()] = 0.3,
        /// Time constant of the layer's relaxation, after the rupture and after the last cut: 0 (immediate), or from
        /// one tick to 10.
        relaxation_s: f64 [NON_NEGATIVE] = 0.02,
        /// c: the force is (1 + c v) times the force of the loading law.
        damping_s_per_m: f64 [DAMPING_S_PER_M.range()] = 2.0,
        /// Friction on the shaft per length in the layer; 11 to 12 in liver (Okamura et al. 2004).
        friction_n_per_m: f64 [FRICTION_N_PER_M.range()] = 10.0,
        /// Friction on the shaft, independent of the length in the layer.
        grip_n: f64 [GRIP_N.range()] = 0.0,
    }
    where rupture_force_n: |s| s.rupture_force_n >= s.cutting_force_n, "at least tissue.layer.*.cutting_force_n";
    where stiffness_n_per_m: |s| s.deflection_m(s.rupture_force_n) <= DEFLECTION_M.high,
        "enough to reach tissue.layer.*.rupture_force_n within 0.1 m, with tissue.layer.*.stiffening_n_per_m2";
}

impl LayerParameters {
    pub const DEFAULT_LIST: [(&str, Self); 5] = [
        (
            "skin",
            Self {
                thickness_m: 2e-3,
                stiffness_n_per_m: 150.0,
                stiffening_n_per_m2: 3.5e4,
                rupture_force_n: 3.0,
                cutting_force_n: 1.0,
                grip_n: 0.3,
                ..Self::DEFAULT
            },
        ),
        ("fat", Self { thickness_m: 0.01, stiffness_n_per_m: 60.0, ..Self::DEFAULT }),
        (
            "muscle",
            Self {
                thickness_m: 0.015,
                stiffness_n_per_m: 150.0,
                stiffening_n_per_m2: 1e4,
                rupture_force_n: 1.2,
                cutting_force_n: 0.8,
                friction_n_per_m: 50.0,
                grip_n: 0.2,
                ..Self::DEFAULT
            },
        ),
        (
            "capsule",
            Self {
                thickness_m: 5e-4,
                stiffness_n_per_m: 60.0,
                stiffening_n_per_m2: 1e4,
                rupture_force_n: 1.2,
                relaxation_s: 0.015,
                friction_n_per_m: 0.0,
                grip_n: 0.1,
                ..Self::DEFAULT
            },
        ),
        ("organ", Self { stiffness_n_per_m: 60.0, friction_n_per_m: 8.0, ..Self::DEFAULT }),
    ];

    pub fn default_list() -> Vec<DefaultLayer> {
        let values = |layer: &Self| {
            let relaxation = ("tissue.layer.*.relaxation_s", layer.relaxation_s);
            layer.measured().into_iter().map(|(key, value, _)| (key, value)).chain([relaxation]).collect()
        };
        Self::DEFAULT_LIST.iter().map(|(name, layer)| (*name, values(layer))).collect()
    }

    pub fn ruptures(&self) -> bool {
        self.rupture_force_n > self.cutting_force_n
    }

    /// `d >= 0` with `a₁ d + a₂ d² = force_n`.
    pub fn deflection_m(&self, force_n: f64) -> f64 {
        let (a1, a2) = (self.stiffness_n_per_m, self.stiffening_n_per_m2);
        let root = (a1 * a1 + 4.0 * a2 * force_n).sqrt();
        if a1 + root > 0.0 { 2.0 * force_n / (a1 + root) } else { f64::INFINITY }
    }

    pub fn force_n(&self, deflection_m: f64) -> f64 {
        (self.stiffness_n_per_m + self.stiffening_n_per_m2 * deflection_m) * deflection_m
    }

    /// `√(a₁² + 4 a₂ f)`.
    pub fn slope_n_per_m(&self, force_n: f64) -> f64 {
        (self.stiffness_n_per_m.powi(2) + 4.0 * self.stiffening_n_per_m2 * force_n).sqrt()
    }

    pub fn validate_on_ticks(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.validate()?;
        let relaxation = self.relaxation_s;
        let resolved = relaxation == 0.0 || (tick_s..=MAX_RELAXATION_S).contains(&relaxation);
        let requirement = "0 (at once), or from simulation.tick_s to 10";
        require("tissue.layer.*.relaxation_s", relaxation, resolved, requirement).map(drop)
    }

    pub(super) fn measured(&self) -> [(&'static str, f64, &'static Bounds); 8] {
        [
            ("tissue.layer.*.thickness_m", self.thickness_m, &THICKNESS_M),
            ("tissue.layer.*.stiffness_n_per_m", self.stiffness_n_per_m, &STIFFNESS_N_PER_M),
            ("tissue.layer.*.stiffening_n_per_m2", self.stiffening_n_per_m2, &STIFFENING_N_PER_M2),
            ("tissue.layer.*.cutting_force_n", self.cutting_force_n, &CUTTING_FORCE_N),
            ("tissue.layer.*.rupture_force_n", self.rupture_force_n, &RUPTURE_FORCE_N),
            ("tissue.layer.*.damping_s_per_m", self.damping_s_per_m, &DAMPING_S_PER_M),
            ("tissue.layer.*.friction_n_per_m", self.friction_n_per_m, &FRICTION_N_PER_M),
            ("tissue.layer.*.grip_n", self.grip_n, &GRIP_N),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::TearingLayer;

    #[test]
    fn the_deflection_inverts_the_loading_law() {
        for (a1, a2) in [(150.0, 3e4), (0.0, 1e4), (200.0, 0.0), (1e3, 1e-9)] {
            let layer = LayerParameters { stiffness_n_per_m: a1, stiffening_n_per_m2: a2, ..LayerParameters::DEFAULT };
            for force in [5e-4, 0.3, 3.0, 19.2] {
                let d = layer.deflection_m(force);
                assert!((a1 * d + a2 * d * d - force).abs() < 1e-12, "{a1} {a2} {force}");
                let slope = a1 + 2.0 * a2 * d;
                assert!((layer.slope_n_per_m(force) - slope).abs() < 1e-9 * slope, "{a1} {a2} {force}");
            }
        }
    }

    #[test]
    fn a_layer_ruptures_if_its_rupture_force_is_above_its_cutting_force() {
        let ruptures = |rupture_force_n, cutting_force_n| {
            LayerParameters { rupture_force_n, cutting_force_n, ..LayerParameters::DEFAULT }.ruptures()
        };
        assert_eq!([ruptures(1.0, 0.9), ruptures(1.0, 1.0), ruptures(0.9, 1.0)], [true, false, false]);
    }

    #[test]
    fn a_layer_without_stiffness_has_no_deflection() {
        let limp = LayerParameters { stiffness_n_per_m: 0.0, stiffening_n_per_m2: 0.0, ..LayerParameters::DEFAULT };
        assert_eq!(limp.deflection_m(1.0), f64::INFINITY);
        assert_eq!(limp.deflection_m(0.0), f64::INFINITY);
    }

    #[test]
    fn the_defaults_are_allowed_and_impossible_values_are_named() {
        LayerParameters::DEFAULT.validate_on_ticks(1e-3).expect("allowed");
        for (_, layer) in &LayerParameters::DEFAULT_LIST {
            layer.validate_on_ticks(1e-3).expect("allowed");
        }
        let (_, skin) = LayerParameters::DEFAULT_LIST[0];
        let refused = |layer: LayerParameters| layer.validate_on_ticks(1e-3).expect_err("refused").name;
        assert_eq!(refused(LayerParameters { thickness_m: 0.0, ..skin }), "tissue.layer.*.thickness_m");
        assert_eq!(refused(LayerParameters { relaxation_s: -1.0, ..skin }), "tissue.layer.*.relaxation_s");
        assert_eq!(refused(LayerParameters { relaxation_s: 1e-4, ..skin }), "tissue.layer.*.relaxation_s");
        assert_eq!(refused(LayerParameters { cutting_force_n: 4.0, ..skin }), "tissue.layer.*.rupture_force_n");
        assert_eq!(refused(LayerParameters { rupture_force_n: -1.0, ..skin }), "tissue.layer.*.rupture_force_n");
        let firm = LayerParameters { rupture_force_n: 50.0, ..skin };
        firm.validate_on_ticks(1e-3).expect("outside of the measurements is allowed");
        let limp = LayerParameters { stiffness_n_per_m: 0.0, stiffening_n_per_m2: 0.0, ..skin };
        assert_eq!(refused(limp), "tissue.layer.*.stiffness_n_per_m");
    }

    #[test]
    fn the_default_list_gives_a_value_to_every_key() {
        for (name, values) in LayerParameters::default_list() {
            assert_eq!(values.len(), LayerParameters::KEYS.len(), "{name}");
            for key in LayerParameters::KEYS {
                assert!(values.iter().any(|(path, _)| *path == key.path), "{name}: {}", key.path);
            }
        }
    }

    #[test]
    fn a_key_shared_by_both_kinds_of_layers_has_one_declaration() {
        let mut shared = 0;
        for key in LayerParameters::KEYS {
            let Some(other) = TearingLayer::KEYS.iter().find(|other| other.path == key.path) else { continue };
            shared += 1;
            assert_eq!((key.kind, key.fallback), (other.kind, other.fallback), "{}", key.path);
            assert_eq!(key.meaning, other.meaning, "{}", key.path);
        }
        assert_eq!(shared, 5);
    }
}
