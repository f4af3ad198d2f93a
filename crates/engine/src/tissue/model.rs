//! The interface of a built-in tissue to the registry.

use super::literature::Outside;
use trocar_core::error::InvalidValue;
use trocar_core::settings::Key;

/// The error of a tissue that is not built from its settings alone.
pub(super) const NEEDS_FILE: InvalidValue =
    InvalidValue { name: "tissue.kind", value: 0.0, requirement: "built with its file", item: None };

/// The springs, in a linear loop, that a tissue shows between its ruptures. Ranges are the smallest and the largest slope of the
/// force over the position, in N/m, without damping and sliding friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Springs {
    /// The tissue is a spring (N/m) and a damper (N·s/m).
    SpringDamper(f64, f64),
    /// The slopes of a tissue without layers, down to a depth.
    ToDepth((f64, f64)),
    /// The slopes of layers, which end where they rupture.
    Layers((f64, f64)),
}

/// A layer of a list that no scenario gives: its name, and the values of those keys that differ from the defaults.
pub type DefaultLayer = (&'static str, Vec<(&'static str, f64)>);

/// A layer of a tissue, as its settings state it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedLayer<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its thickness in m.
    pub thickness_m: f64,
    /// True if it ruptures; other layers are cut without a rupture.
    pub ruptures: bool,
    /// Its deflection at its rupture, in m.
    pub deflection_m: f64,
}

/// What the registry needs of a tissue besides the trait.
pub trait Model: Sized {
    /// Its settings.
    type Settings;
    /// Its keys of a layer in the list of layers.
    const LIST_KEYS: &'static [Key] = &[];

    /// The tissue of the settings on ticks of `tick_s` (s), with the needle tip initially at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range; also if the tissue needs a file.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// Checks the settings for [`Model::build`]. A tissue that needs memory checks them without building.
    ///
    /// # Errors
    /// As [`Model::build`].
    fn check(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        Self::build(settings, tick_s, start_m).map(drop)
    }

    /// The layers where a scenario lists none.
    fn default_layers() -> Vec<DefaultLayer> {
        vec![]
    }

    /// Its layers, from the surface down: each ruptures at most once, and in this order.
    fn layers(_settings: &Self::Settings) -> Vec<StatedLayer<'_>> {
        vec![]
    }

    /// The surface of the undeformed tissue, in m; `None` if it is unknown.
    fn surface_m(_settings: &Self::Settings) -> Option<f64> {
        None
    }

    /// The springs that it shows down to a depth in m below the surface; `None` if they are unknown, or depend on an
    /// unknown depth.
    fn springs(_settings: &Self::Settings, _depth_m: Option<f64>) -> Option<Springs> {
        None
    }

    /// Its properties outside the range of the measurements.
    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
