//! From values to a layered tissue.

use trocar_core::settings::Source as _;

use super::error::ScenarioError;
use super::values::Values;
use crate::tissue::{LAYER_KEYS, LAYERS, LayerParameters, LayersParameters, ShaftParameters};

/// The layers and the shaft.
pub(super) fn layers(values: &Values) -> Result<LayersParameters, ScenarioError> {
    let mut layers = [LayerParameters::ABSENT; LAYERS];
    for (layer, keys) in layers.iter_mut().zip(&LAYER_KEYS) {
        *layer = LayerParameters {
            thickness_m: values.number(keys.thickness_m)?,
            stiffness_n_per_m: values.number(keys.stiffness_n_per_m)?,
            stiffening_n_per_m2: values.number(keys.stiffening_n_per_m2)?,
            rupture_force_n: values.number(keys.rupture_force_n)?,
            cutting_force_n: values.number(keys.cutting_force_n)?,
            relaxation_s: values.number(keys.relaxation_s)?,
            damping_s_per_m: values.number(keys.damping_s_per_m)?,
            friction_n_per_m: values.number(keys.friction_n_per_m)?,
            grip_n: values.number(keys.grip_n)?,
        };
    }
    Ok(LayersParameters {
        contact_m: values.number("tissue.contact_m")?,
        layers,
        shaft: ShaftParameters {
            stiffness_n_per_m: values.number("tissue.shaft_stiffness_n_per_m")?,
            static_ratio: values.number("tissue.static_ratio")?,
            stick_speed_m_per_s: values.number("tissue.stick_speed_m_per_s")?,
            damping_n_s_per_m2: values.number("tissue.shaft_damping_n_s_per_m2")?,
        },
    })
}
