//! What the registry needs of a built-in tissue.

use crate::error::InvalidValue;

/// A tissue that is made of settings alone.
pub trait Model: Sized {
    /// What it is told.
    type Settings;

    /// A tissue of the settings on ticks of `tick_s` (s), of a needle whose tip begins at `start_m` (m).
    ///
    /// # Errors
    /// [`InvalidValue`] naming the setting out of range.
    fn build(settings: &Self::Settings, tick_s: f64, start_m: f64) -> Result<Self, InvalidValue>;
}
