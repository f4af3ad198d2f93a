//! The interface of a built-in tissue to the registry.

use super::literature::Outside;
use crate::error::InvalidValue;

/// A tissue that is built from settings alone.
pub trait Model: Sized {
    /// Its settings.
    type Settings;

    /// The tissue of the settings on ticks of `tick_s` (s), with the needle tip initially at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;

    /// The names of its layers that rupture, from the surface down: each ruptures at most once, and in this order.
    fn rupturing_layers(_settings: &Self::Settings) -> Vec<&'static str> {
        vec![]
    }

    /// Its properties outside the range of the measurements.
    fn outside_measured(_settings: &Self::Settings) -> Vec<Outside> {
        vec![]
    }
}
