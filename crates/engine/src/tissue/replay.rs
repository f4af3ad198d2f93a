//! Settings of a recording replayed as a tissue.

trocar_core::settings! {
    /// Settings of a replayed recording.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ReplaySettings in "tissue." {
        /// The index of the replay.
        index: ReplayIndex,
    }
}

trocar_core::choice! {
    /// Replay by time, or by depth: the force on a frozen slave is then constant.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum ReplayIndex at "tissue.index" = Time {
        /// By time, independent of the slave.
        "time" => Time,
        /// By the slave's position.
        "depth" => Depth in "tissue." {
            /// Travel over which the force changes to that of the withdrawal when the needle retreats, in a replay by
            /// depth.
            presliding_m: f64 [POSITIVE] = 2e-3,
        },
    }
}
