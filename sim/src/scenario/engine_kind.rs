//! How the plants are brought from tick to tick.

trocar_core::choice! {
    /// Between ticks: matrix exponentials, or numerical integration as a check.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum EngineKind at "simulation.engine" = Exact {
        /// By matrix exponentials.
        "exact" => Exact,
        /// By numerical integration, as a check.
        "dop853" => Dop853,
    }
}
