use trocar_core::error::{InvalidValue, require};

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Surface in "tissue." {
        /// Position of the surface, for every tissue except a recording.
        contact_m: f64 [ANY] = 0.0,
    }
}

pub(super) fn starts_outside(contact_m: f64, start_m: f64) -> Result<(), InvalidValue> {
    let requirement = "at least the needle's start, which is outside the tissue";
    require("tissue.contact_m", contact_m, start_m <= contact_m, requirement).map(drop)
}
