//! The keys of a layered tissue: the same for each layer, so that they are made and not written out.

use super::keys::{Fallback, Key};
use super::value::{Kind, Range as R, Value};
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
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.thickness_m),
                "Thickness, up to 0.3; 0: the layer is absent.",
            ),
            key(
                NAMES.stiffness_n_per_m,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.stiffness_n_per_m),
                "a_1 of its loading law, a_1 d + a_2 d² of the deflection d.",
            ),
            key(
                NAMES.stiffening_n_per_m2,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.stiffening_n_per_m2),
                "a_2 of its loading law.",
            ),
            key(
                NAMES.rupture_force_n,
                R::POSITIVE,
                || Value::Number(DEFAULTS.rupture_force_n),
                "Where it gives way: 5e-4 to 19.2, median 1.22 (van Gerwen et al. 2012), and at least the cutting force.",
            ),
            key(
                NAMES.cutting_force_n,
                R::POSITIVE,
                || Value::Number(DEFAULTS.cutting_force_n),
                "Where the needle cuts on through it: 5e-4 to 19.2.",
            ),
            key(
                NAMES.relaxation_s,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.relaxation_s),
                "How fast it relaxes once ruptured, and once through: 0 (at once), or a tick to 10.",
            ),
            key(
                NAMES.damping_s_per_m,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.damping_s_per_m),
                "c: its force is (1 + c v) times that of the loading law.",
            ),
            key(
                NAMES.friction_n_per_m,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.friction_n_per_m),
                "Friction on the shaft per length in it.",
            ),
            key(
                NAMES.grip_n,
                R::NON_NEGATIVE,
                || Value::Number(DEFAULTS.grip_n),
                "Friction on the shaft whatever the length in it.",
            ),
        ]
    }};
}

const fn key(path: &'static str, range: R, default: fn() -> Value, meaning: &'static str) -> Key {
    Key { path, kind: Kind::Number(range), fallback: Fallback::Value(default), meaning }
}

/// The keys of every layer, from the surface down.
pub(super) const LAYERED_KEYS: [[Key; KEYS_PER_LAYER]; LAYERS] =
    [keys_of_layer!(0), keys_of_layer!(1), keys_of_layer!(2), keys_of_layer!(3), keys_of_layer!(4)];

/// Keys followed by those of every layer, `COUNT` in all.
pub(super) const fn with_layers<const COUNT: usize>(keys: &[Key]) -> [Key; COUNT] {
    let mut all = [keys[0]; COUNT];
    let mut index = 0;
    while index < COUNT {
        all[index] = if index < keys.len() {
            keys[index]
        } else {
            let place = index - keys.len();
            LAYERED_KEYS[place / KEYS_PER_LAYER][place % KEYS_PER_LAYER]
        };
        index += 1;
    }
    all
}

/// How many keys the layers have together.
pub(super) const LAYERED_COUNT: usize = KEYS_PER_LAYER * LAYERS;
