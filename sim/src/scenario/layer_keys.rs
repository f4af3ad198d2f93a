//! The keys of a layered tissue: the same for each layer, so that they are made and not written out.

use trocar_core::settings::{Key, Range as R};

use crate::tissue::literature;
use crate::tissue::{LAYER_KEYS, LAYERS, LayerKeys, LayerParameters};

/// How many keys a layer has.
const KEYS_PER_LAYER: usize = 9;

macro_rules! keys_of_layer {
    ($layer:literal) => {{
        const NAMES: &LayerKeys = &LAYER_KEYS[$layer];
        const DEFAULTS: LayerParameters = LayerParameters::DEFAULTS[$layer];
        [
            Key::number(
                NAMES.thickness_m,
                literature::THICKNESS_M.range(),
                DEFAULTS.thickness_m,
                "Thickness, up to 0.3; 0: the layer is absent.",
            ),
            Key::number(
                NAMES.stiffness_n_per_m,
                literature::STIFFNESS_N_PER_M.range(),
                DEFAULTS.stiffness_n_per_m,
                "a_1 of its loading law, a_1 d + a_2 d² of the deflection d.",
            ),
            Key::number(
                NAMES.stiffening_n_per_m2,
                literature::STIFFENING_N_PER_M2.range(),
                DEFAULTS.stiffening_n_per_m2,
                "a_2 of its loading law.",
            ),
            Key::number(
                NAMES.rupture_force_n,
                literature::RUPTURE_FORCE_N.range(),
                DEFAULTS.rupture_force_n,
                "Where it gives way, median 1.22 (van Gerwen et al. 2012); at least the cutting force.",
            ),
            Key::number(
                NAMES.cutting_force_n,
                literature::CUTTING_FORCE_N.range(),
                DEFAULTS.cutting_force_n,
                "Where the needle cuts on through it, median 0.95 (van Gerwen et al. 2012).",
            ),
            Key::number(
                NAMES.relaxation_s,
                R::NON_NEGATIVE,
                DEFAULTS.relaxation_s,
                "How fast it relaxes once ruptured, and once through: 0 (at once), or a tick to 10.",
            ),
            Key::number(
                NAMES.damping_s_per_m,
                literature::DAMPING_S_PER_M.range(),
                DEFAULTS.damping_s_per_m,
                "c: its force is (1 + c v) times that of the loading law.",
            ),
            Key::number(
                NAMES.friction_n_per_m,
                literature::FRICTION_N_PER_M.range(),
                DEFAULTS.friction_n_per_m,
                "Friction on the shaft per length in it; 11 to 12 in liver (Okamura et al. 2004).",
            ),
            Key::number(
                NAMES.grip_n,
                literature::GRIP_N.range(),
                DEFAULTS.grip_n,
                "Friction on the shaft whatever the length in it.",
            ),
        ]
    }};
}

/// The keys of every layer, from the surface down.
pub(super) const LAYERED_KEYS: &[[Key; KEYS_PER_LAYER]; LAYERS] =
    &[keys_of_layer!(0), keys_of_layer!(1), keys_of_layer!(2), keys_of_layer!(3), keys_of_layer!(4)];
