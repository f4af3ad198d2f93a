//! The interface of a built-in tissue to the registry.

use super::literature::Outside;
use trocar_core::error::InvalidValue;
use trocar_core::settings::Key;

/// Error for a tissue that cannot be built from its settings alone.
pub(super) const NEEDS_FILE: InvalidValue =
    InvalidValue { name: "tissue.kind", value: 0.0, requirement: "built with its file", item: None };

/// The springs that a tissue shows to a linear loop between ruptures. Ranges are the smallest and the largest slope of
/// the force over the position, in N/m, without damping and sliding friction. The number after a range is the largest
/// damping, in N·s/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Springs {
    /// A spring (N/m) and a damper (N·s/m).
    SpringDamper(f64, f64),
    /// Slopes of a tissue without layers, down to a depth.
    ToDepth((f64, f64), f64),
    /// Slopes of layers, which end at their ruptures.
    Layers((f64, f64), f64),
}

/// A default layer: its name, and the values of the keys that differ from the defaults.
pub type DefaultLayer = (&'static str, Vec<(&'static str, f64)>);

/// Properties of a layer, from its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedLayer<'a> {
    /// Name of the layer.
    pub name: &'a str,
    /// Thickness in m.
    pub thickness_m: f64,
    /// True if the layer ruptures. Other layers are cut without a rupture.
    pub ruptures: bool,
    /// Deflection at the rupture, in m.
    pub deflection_m: f64,
}

/// Requirements of the registry besides the trait.
pub trait Model: Sized {
    /// Settings of the tissue.
    type Settings;
    /// Keys of a layer in the list of layers.
    const LIST_KEYS: &'static [Key] = &[];

    /// Creates the tissue, with the needle tip at `start_m`.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range; also if the tissue needs a file.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// Checks the settings for [`Model::build`]. A tissue that needs memory checks them without building.
    ///
    /// # Errors
    /// See [`Model::build`].
    fn check(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        Self::build(settings, tick_s, start_m).map(drop)
    }

    /// The layers of a scenario that lists none.
    fn default_layers() -> Vec<DefaultLayer> {
        vec![]
    }

    /// The layers, from the surface down. Each ruptures at most once, and in this order.
    fn layers(_settings: &Self::Settings) -> Vec<StatedLayer<'_>> {
        vec![]
    }

    /// The surface of the undeformed tissue, in m; `None` if it is unknown.
    fn surface_m(_settings: &Self::Settings) -> Option<f64> {
        None
    }

    /// The springs down to a depth in m below the surface; `None` if they are unknown, or depend on an unknown depth.
    fn springs(_settings: &Self::Settings, _depth_m: Option<f64>) -> Option<Springs> {
        None
    }

    /// The properties outside the range of the measurements.
    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
