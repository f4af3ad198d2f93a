//! How a recording is replayed as a tissue.

trocar_core::settings! {
    /// What a replayed recording is told.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ReplaySettings in "tissue." {
        /// By what it is replayed.
        index: ReplayIndex,
    }
}

trocar_core::choice! {
    /// Replay by time, or by depth: then a frozen slave feels a held force.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ReplayIndex at "tissue.index" = Time {
        /// By time, whatever the slave does.
        "time" => Time,
        /// By where the slave is.
        "depth" => Depth in "tissue." {
            /// Travel over which a retreat in a replay by depth turns to the force of the way out.
            presliding_m: f64 [POSITIVE] = 2e-3,
        },
    }
}
