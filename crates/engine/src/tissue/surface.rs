//! The surface of a tissue.

use trocar_core::error::{InvalidValue, require};

trocar_core::settings! {
    /// The surface of a tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Surface in "tissue." {
        /// Position of the surface, for every tissue except a recording.
        ///
        /// In m. A deeper needle is in contact.
        contact_m: f64 [ANY] = 0.0,
    }
}

/// Checks that a needle that starts at `start_m` is outside of a tissue with its surface at `contact_m`.
pub(super) fn starts_outside(contact_m: f64, start_m: f64) -> Result<(), InvalidValue> {
    let requirement = "at least the needle's start, which is outside the tissue";
    require("tissue.contact_m", contact_m, start_m <= contact_m, requirement).map(drop)
}
