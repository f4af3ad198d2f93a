trocar_core::choice! {
    /// Stepping between ticks: matrix exponentials, or numerical integration as a check.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum EngineKind at "simulation.engine" = Exact {
        /// Matrix exponentials.
        "exact" => Exact,
        /// Numerical integration, as a check.
        "dop853" => Dop853,
    }
}
