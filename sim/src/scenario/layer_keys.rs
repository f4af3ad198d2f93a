//! The keys of a layered tissue: the same for each layer, so that they are made and not written out.

use super::keys::{Fallback, Key};
use super::value::{Kind, Range as R, Value};
use crate::tissue::literature::{self, Bounds};
use crate::tissue::{LAYER_KEYS, LAYERS, LayerKeys, LayerParameters};

/// How many keys a layer has.
const KEYS_PER_LAYER: usize = 9;

macro_rules! keys_of_layer {
    ($layer:literal) => {{
        const NAMES: &LayerKeys = &LAYER_KEYS[$layer];
        const DEFAULTS: LayerParameters = LayerParameters::DEFAULTS[$layer];
        [
            key(
                NAMES.thickness_m,
                within(&literature::THICKNESS_M),
                || Value::Number(DEFAULTS.thickness_m),
                "Thickness, up to 0.3; 0: the layer is absent.",
            ),
            key(
                NAMES.stiffness_n_per_m,
                within(&literature::STIFFNESS_N_PER_M),
                || Value::Number(DEFAULTS.stiffness_n_per_m),
                "a_1 of its loading law, a_1 d + a_2 d² of the deflection d.",
            ),
            key(
                NAMES.stiffening_n_per_m2,
                within(&literature::STIFFENING_N_PER_M2),
                || Value::Number(DEFAULTS.stiffening_n_per_m2),
                "a_2 of its loading law.",
            ),
            key(
                NAMES.rupture_force_n,
                within(&literature::RUPTURE_FORCE_N),
                || Value::Number(DEFAULTS.rupture_force_n),
                "Where it gives way, median 1.22 (van Gerwen et al. 2012); at least the cutting force.",
            ),
            key(
                NAMES.cutting_force_n,
                within(&literature::CUTTING_FORCE_N),
                || Value::Number(DEFAULTS.cutting_force_n),
                "Where the needle cuts on through it, median 0.95 (van Gerwen et al. 2012).",
            ),
            key(
                NAMES.relaxation_s,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.relaxation_s),
                "How fast it relaxes once ruptured, and once through: 0 (at once), or a tick to 10.",
            ),
            key(
                NAMES.damping_s_per_m,
                within(&literature::DAMPING_S_PER_M),
                || Value::Number(DEFAULTS.damping_s_per_m),
                "c: its force is (1 + c v) times that of the loading law.",
            ),
            key(
                NAMES.friction_n_per_m,
                within(&literature::FRICTION_N_PER_M),
                || Value::Number(DEFAULTS.friction_n_per_m),
                "Friction on the shaft per length in it; 11 to 12 in liver (Okamura et al. 2004).",
            ),
            key(
                NAMES.grip_n,
                within(&literature::GRIP_N),
                || Value::Number(DEFAULTS.grip_n),
                "Friction on the shaft whatever the length in it.",
            ),
        ]
    }};
}

/// The range that the literature makes.
pub(super) const fn within(bounds: &Bounds) -> R {
    R::stated(bounds.low, bounds.high, bounds.requirement)
}

const fn key(path: &'static str, range: R, default: fn() -> Value, meaning: &'static str) -> Key {
    Key { path, kind: Kind::Number(range), fallback: Fallback::Value(default), meaning }
}

/// The keys of every layer, from the surface down.
pub(super) const LAYERED_KEYS: &[[Key; KEYS_PER_LAYER]; LAYERS] =
    &[keys_of_layer!(0), keys_of_layer!(1), keys_of_layer!(2), keys_of_layer!(3), keys_of_layer!(4)];
