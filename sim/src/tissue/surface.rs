//! Where a tissue begins.

trocar_core::settings! {
    /// The surface of a tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Surface in "tissue." {
        /// Surface of every tissue but a recording.
        ///
        /// In m; the needle is in contact beyond.
        contact_m: f64 [ANY] = 0.0,
    }
}
