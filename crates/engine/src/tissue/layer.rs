//! One layer of tissue: its parameters, their keys and ranges.
//!
//! # Sources of the numbers
//! The form is that of Simone (*Modeling of needle insertion forces for percutaneous therapies*, 2002) and of Okamura,
//! Simone and O'Leary (2004) for the liver: a nonlinear spring until the capsule gives way, then a constant cutting
//! force and friction along the shaft. The measured values of each quantity and its range are in
//! [`literature`](super::literature). Barbé et al. (2007) state, for one needle in vivo, the total over all layers: up
//! to 1.45 N with a pull of 0.37 N on direct access to a pig's liver, up to 5.69 N with a pull of 2.45 N through the
//! skin, most of it from skin, fat and muscle (3.2.1, 3.2.2). How these totals are divided among the layers is chosen
//! here: a layer bulges by millimetres before it gives way, as figure 1 and the 9 mm lurch of 5.2 show, and relaxes
//! within hundredths of a second.
//!
//! | default | skin | fat | muscle | capsule | organ | measured |
//! |---|---|---|---|---|---|---|
//! | thickness | 2 mm | 10 mm | 15 mm | 0.5 mm | 0.1 m | chosen here |
//! | rupture force | 3 N | 0.3 N | 1.2 N | 1.2 N | 0.3 N | median 1.22 N; liver 1.48 to 3.13 N |
//! | cutting force | 1 N | 0.3 N | 0.8 N | 0.3 N | 0.3 N | 0.05 to 1.3 N; liver 0.58 to 1.3 N |
//! | `a₁` in N/m | 150 | 60 | 150 | 60 | 60 | liver 2 to 48 ex vivo; a pig's is 2 to 6 times as stiff in vivo |
//! | `a₂` in N/m² | 35 000 | 0 | 10 000 | 10 000 | 0 | liver 2300 to 5200 |
//! | friction in N/m | 10 | 10 | 50 | 0 | 8 | liver 10.6 to 12.0 |
//! | grip | 0.3 N | 0 | 0.2 N | 0.1 N | 0 | chosen here |
//! | relaxation | 20 ms | 20 ms | 20 ms | 15 ms | 20 ms | chosen here |
//! | `c` in s/m | 2 | 2 | 2 | 2 | 2 | chosen here |

use trocar_core::settings::{Key, Range, Source, joined};

use super::literature::{
    Bounds, CUTTING_FORCE_N, DAMPING_S_PER_M, DEFLECTION_M, FRICTION_N_PER_M, GRIP_N, RUPTURE_FORCE_N,
    STIFFENING_N_PER_M2, STIFFNESS_N_PER_M, THICKNESS_M,
};
use trocar_core::error::{InvalidValue, require};

/// Maximum number of layers.
pub const LAYERS: usize = 5;

/// Largest time constant of a relaxation in s.
pub const MAX_RELAXATION_S: f64 = 10.0;

/// Declares the parameters of a layer: the struct, its keys for every layer, and how it is read.
macro_rules! layer_settings {
    (
        $(#[doc = $about:literal])*
        pub struct LayerParameters in $($layer:literal)* {
            $(
                $(#[doc = $doc:literal])*
                $field:ident [$range:expr],
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct LayerParameters {
            $(
                $(#[doc = $doc])*
                pub $field: f64,
            )*
        }

        /// A layer's keys in scenarios.
        #[derive(Debug)]
        #[allow(missing_docs, reason = "named as the fields of LayerParameters")]
        pub struct LayerKeys {
            $(pub $field: &'static str,)*
            at_least_cutting: &'static str,
            reaches_rupture: &'static str,
        }

        impl LayerParameters {
            /// Reads the layer of the keys.
            pub(super) fn read<S: Source>(source: &S, keys: &LayerKeys) -> Result<Self, S::Error> {
                Ok(Self { $($field: source.number(keys.$field)?,)* })
            }

            /// The keys of the layer `index` of [`LAYER_NAMES`].
            const fn keys(index: usize) -> [Key; LAYER_KEY_COUNT] {
                let (names, default) = (&LAYER_KEYS[index], Self::DEFAULTS[index]);
                let keys: &[Key] = &[$(
                    Key::number(names.$field, $range, default.$field, trocar_core::settings!(@meaning $($doc)*)),
                )*];
                joined(&[keys])
            }
        }

        const LAYER_KEY_COUNT: usize = [$(stringify!($field)),*].len();

        /// The layers' names in scenarios, from the surface down.
        pub const LAYER_NAMES: [&str; LAYERS] = [$($layer),*];

        layer_settings!(@names {$($field)*} $($layer)*);
    };
    (@names $fields:tt $($layer:literal)*) => {
        /// The keys of each layer, in the order of [`LAYER_NAMES`].
        pub const LAYER_KEYS: [LayerKeys; LAYERS] = [$(layer_settings!(@layer $layer $fields)),*];
    };
    (@layer $layer:literal {$($field:ident)*}) => {
        LayerKeys {
            $($field: concat!("tissue.", $layer, ".", stringify!($field)),)*
            at_least_cutting: concat!("at least tissue.", $layer, ".cutting_force_n"),
            reaches_rupture: concat!(
                "enough to reach tissue.",
                $layer,
                ".rupture_force_n within 0.1 m, with tissue.",
                $layer,
                ".stiffening_n_per_m2"
            ),
        }
    };
}

/// The keys of every layer, from the surface down.
pub(super) const LAYERED_KEYS: &[[Key; LAYER_KEY_COUNT]; LAYERS] = &[
    LayerParameters::keys(0),
    LayerParameters::keys(1),
    LayerParameters::keys(2),
    LayerParameters::keys(3),
    LayerParameters::keys(4),
];

layer_settings! {
    /// The parameters of a layer.
    ///
    /// Its loading law is `f(d) = (a₁ d + a₂ d²) max(1 + c v, 0)`: a polynomial of the deflection `d >= 0`, as Okamura
    /// et al. use for the capsule, and a damping proportional to it, as in Hunt-Crossley's model (eq. 2 with
    /// `λ = c μ`), so that the force starts without a step and never pulls.
    pub struct LayerParameters in "skin" "fat" "muscle" "capsule" "organ" {
        /// Thickness; 0: the layer is absent.
        ///
        /// In m; the other parameters of an absent layer have no effect.
        thickness_m [THICKNESS_M.range()],
        /// a_1 of the loading law a_1 d + a_2 d², with the deflection d.
        stiffness_n_per_m [STIFFNESS_N_PER_M.range()],
        /// a_2 of the loading law.
        ///
        /// `a₁` or `a₂` is above 0.
        stiffening_n_per_m2 [STIFFENING_N_PER_M2.range()],
        /// Force at which the layer ruptures, median 1.22 (van Gerwen et al. 2012); at least the cutting force.
        rupture_force_n [RUPTURE_FORCE_N.range()],
        /// Force at which the needle cuts through it after the rupture, median 0.95 (van Gerwen et al. 2012).
        cutting_force_n [CUTTING_FORCE_N.range()],
        /// Time constant of its relaxation, after the rupture and after the last cut: 0 (immediate), or from one tick
        /// to 10.
        ///
        /// In s, from the rupture force to the cutting force and, once cut through, to 0.
        relaxation_s [Range::NON_NEGATIVE],
        /// c: the force is (1 + c v) times that of the loading law.
        damping_s_per_m [DAMPING_S_PER_M.range()],
        /// Friction on the shaft per length in the layer; 11 to 12 in liver (Okamura et al. 2004).
        friction_n_per_m [FRICTION_N_PER_M.range()],
        /// Friction on the shaft, independent of the length in the layer.
        ///
        /// Caused by the rim of the layer, in N.
        grip_n [GRIP_N.range()],
    }
}

impl LayerParameters {
    /// The default layers, in the order of [`LAYER_NAMES`].
    pub const DEFAULTS: [Self; LAYERS] = [
        Self {
            thickness_m: 2e-3,
            stiffness_n_per_m: 150.0,
            stiffening_n_per_m2: 3.5e4,
            rupture_force_n: 3.0,
            cutting_force_n: 1.0,
            relaxation_s: 0.02,
            damping_s_per_m: 2.0,
            friction_n_per_m: 10.0,
            grip_n: 0.3,
        },
        Self {
            thickness_m: 0.01,
            stiffness_n_per_m: 60.0,
            stiffening_n_per_m2: 0.0,
            rupture_force_n: 0.3,
            cutting_force_n: 0.3,
            relaxation_s: 0.02,
            damping_s_per_m: 2.0,
            friction_n_per_m: 10.0,
            grip_n: 0.0,
        },
        Self {
            thickness_m: 0.015,
            stiffness_n_per_m: 150.0,
            stiffening_n_per_m2: 1e4,
            rupture_force_n: 1.2,
            cutting_force_n: 0.8,
            relaxation_s: 0.02,
            damping_s_per_m: 2.0,
            friction_n_per_m: 50.0,
            grip_n: 0.2,
        },
        Self {
            thickness_m: 5e-4,
            stiffness_n_per_m: 60.0,
            stiffening_n_per_m2: 1e4,
            rupture_force_n: 1.2,
            cutting_force_n: 0.3,
            relaxation_s: 0.015,
            damping_s_per_m: 2.0,
            friction_n_per_m: 0.0,
            grip_n: 0.1,
        },
        Self {
            thickness_m: 0.1,
            stiffness_n_per_m: 60.0,
            stiffening_n_per_m2: 0.0,
            rupture_force_n: 0.3,
            cutting_force_n: 0.3,
            relaxation_s: 0.02,
            damping_s_per_m: 2.0,
            friction_n_per_m: 8.0,
            grip_n: 0.0,
        },
    ];

    /// An absent layer.
    pub const ABSENT: Self = Self { thickness_m: 0.0, ..Self::DEFAULTS[0] };

    /// Whether the layer is present.
    #[must_use]
    pub fn is_present(&self) -> bool {
        self.thickness_m > 0.0
    }

    /// `d >= 0` in m with `a₁ d + a₂ d² = force_n`.
    ///
    /// The form avoids cancellation for small `a₂`.
    #[must_use]
    pub fn deflection_m(&self, force_n: f64) -> f64 {
        let (a1, a2) = (self.stiffness_n_per_m, self.stiffening_n_per_m2);
        let root = (a1 * a1 + 4.0 * a2 * force_n).sqrt();
        if a1 + root > 0.0 { 2.0 * force_n / (a1 + root) } else { f64::INFINITY }
    }

    /// The slope in N/m of the loading law where its force is `force_n`: `√(a₁² + 4 a₂ f)`.
    #[must_use]
    pub fn slope_n_per_m(&self, force_n: f64) -> f64 {
        (self.stiffness_n_per_m.powi(2) + 4.0 * self.stiffening_n_per_m2 * force_n).sqrt()
    }

    /// Checks the fields, on ticks of `tick_s`, with the keys of layer `index` of [`LAYER_NAMES`].
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first key out of range.
    pub fn validate(&self, index: usize, tick_s: f64) -> Result<(), InvalidValue> {
        let keys = &LAYER_KEYS[index];
        THICKNESS_M.range().check(keys.thickness_m, self.thickness_m)?;
        if !self.is_present() {
            return Ok(());
        }
        for (key, value, bounds) in self.measured(index) {
            bounds.range().check(key, value)?;
        }
        let rupture = self.rupture_force_n;
        require(keys.rupture_force_n, rupture, rupture >= self.cutting_force_n, keys.at_least_cutting)?;
        let reaches = self.deflection_m(rupture) <= DEFLECTION_M.high;
        require(keys.stiffness_n_per_m, self.stiffness_n_per_m, reaches, keys.reaches_rupture)?;
        let relaxation = self.relaxation_s;
        let resolved = relaxation == 0.0 || (tick_s..=MAX_RELAXATION_S).contains(&relaxation);
        require(keys.relaxation_s, relaxation, resolved, "0 (at once), or from simulation.tick_s to 10").map(drop)
    }

    /// The keys of layer `index` of [`LAYER_NAMES`] with values and ranges of measurements.
    pub(super) fn measured(&self, index: usize) -> [(&'static str, f64, &'static Bounds); 8] {
        let keys = &LAYER_KEYS[index];
        [
            (keys.thickness_m, self.thickness_m, &THICKNESS_M),
            (keys.stiffness_n_per_m, self.stiffness_n_per_m, &STIFFNESS_N_PER_M),
            (keys.stiffening_n_per_m2, self.stiffening_n_per_m2, &STIFFENING_N_PER_M2),
            (keys.cutting_force_n, self.cutting_force_n, &CUTTING_FORCE_N),
            (keys.rupture_force_n, self.rupture_force_n, &RUPTURE_FORCE_N),
            (keys.damping_s_per_m, self.damping_s_per_m, &DAMPING_S_PER_M),
            (keys.friction_n_per_m, self.friction_n_per_m, &FRICTION_N_PER_M),
            (keys.grip_n, self.grip_n, &GRIP_N),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deflection_inverts_the_loading_law() {
        for (a1, a2) in [(150.0, 3e4), (0.0, 1e4), (200.0, 0.0), (1e3, 1e-9)] {
            let layer =
                LayerParameters { stiffness_n_per_m: a1, stiffening_n_per_m2: a2, ..LayerParameters::DEFAULTS[0] };
            for force in [5e-4, 0.3, 3.0, 19.2] {
                let d = layer.deflection_m(force);
                assert!((a1 * d + a2 * d * d - force).abs() < 1e-12, "{a1} {a2} {force}");
                let slope = a1 + 2.0 * a2 * d;
                assert!((layer.slope_n_per_m(force) - slope).abs() < 1e-9 * slope, "{a1} {a2} {force}");
            }
        }
    }

    #[test]
    fn the_defaults_are_allowed_and_what_cannot_be_is_named() {
        for (index, layer) in LayerParameters::DEFAULTS.iter().enumerate() {
            layer.validate(index, 1e-3).expect("allowed");
        }
        let skin = LayerParameters::DEFAULTS[0];
        let refused = |layer: LayerParameters| layer.validate(3, 1e-3).expect_err("refused").name;
        assert_eq!(refused(LayerParameters { relaxation_s: -1.0, ..skin }), "tissue.capsule.relaxation_s");
        assert_eq!(refused(LayerParameters { relaxation_s: 1e-4, ..skin }), "tissue.capsule.relaxation_s");
        assert_eq!(refused(LayerParameters { cutting_force_n: 4.0, ..skin }), "tissue.capsule.rupture_force_n");
        assert_eq!(refused(LayerParameters { rupture_force_n: -1.0, ..skin }), "tissue.capsule.rupture_force_n");
        let firm = LayerParameters { rupture_force_n: 50.0, ..skin };
        firm.validate(3, 1e-3).expect("outside of the measurements is allowed");
        let limp = LayerParameters { stiffness_n_per_m: 0.0, stiffening_n_per_m2: 0.0, ..skin };
        assert_eq!(refused(limp), "tissue.capsule.stiffness_n_per_m");
        LayerParameters { relaxation_s: -1.0, ..LayerParameters::ABSENT }.validate(0, 1e-3).expect("it is absent");
    }
}
