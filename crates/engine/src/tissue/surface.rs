//! The surface of a tissue.

trocar_core::settings! {
    /// The surface of a tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Surface in "tissue." {
        /// Position of the surface, for every tissue except a recording and an FMU.
        ///
        /// In m; a deeper needle is in contact.
        contact_m: f64 [ANY] = 0.0,
    }
}
