//! The interface of a built-in tissue to the registry.

use super::literature::Outside;
use trocar_core::error::InvalidValue;

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

/// A tissue that is built from settings alone.
pub trait Model: Sized {
    /// Its settings.
    type Settings;

    /// The tissue of the settings on ticks of `tick_s` (s), with the needle tip initially at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// Checks the settings for [`Model::build`]. A tissue that needs memory checks them without building.
    ///
    /// # Errors
    /// As [`Model::build`].
    fn check(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<(), InvalidValue> {
        Self::build(settings, tick_s, start_m).map(drop)
    }

    /// The names of its layers that rupture, from the surface down: each ruptures at most once, and in this order.
    fn rupturing_layers(_settings: &Self::Settings) -> Vec<&str> {
        vec![]
    }

    /// The surface of the undeformed tissue, in m.
    fn surface_m(settings: &Self::Settings) -> f64;

    /// The springs that it shows down to a depth in m below the surface; `None` if they depend on an unknown depth.
    fn springs(settings: &Self::Settings, depth_m: Option<f64>) -> Option<Springs>;

    /// Its properties outside the range of the measurements.
    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
