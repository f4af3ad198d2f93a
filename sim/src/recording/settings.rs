//! What a scenario says of a recording: its file and labels, its signs, and the names and scales of its columns.
//!
//! How much of it is read is [`Limits`](super::Limits).

trocar_core::settings! {
    /// The recording and when layers rupture in it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FileSettings in "recording." no const {
        /// A CSV file, or builtin:in_vivo_like.csv, builtin:own_ctrl_pop.csv.
        file: Option<String> [FILE],
        /// When layers rupture, counted from the recording's first sample.
        ruptures_s: Vec<f64> = [],
    }
}

trocar_core::settings! {
    /// The signs of the file's numbers.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SignSettings in "recording." {
        /// -1 where the file counts resistance to insertion as negative.
        force_sign: f64 [SIGN] = 1.0,
        /// -1 where the file's positions shrink into the tissue.
        position_sign: f64 [SIGN] = 1.0,
        /// -1 where the file's velocities are negative into the tissue.
        velocity_sign: f64 [SIGN] => "that of the position" position_sign,
    }
}

trocar_core::settings! {
    /// The columns by the names in the file's header.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ColumnSettings in "recording.columns." no const {
        /// Time.
        time_s: String = "time_s",
        /// Position of the needle.
        position_m: String = "position_m",
        /// Velocity of the needle; estimated from the position when not given.
        velocity_m_per_s: Option<String>,
        /// Force on the needle.
        force_n: String = "force_n",
    }
}

trocar_core::settings! {
    /// The factors that turn the columns into SI.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ScaleSettings in "recording.scale." {
        /// To seconds.
        time_s: f64 [POSITIVE] = 1.0,
        /// To metres, as 0.075 for the angle of a lever of that length.
        position_m: f64 [POSITIVE] = 1.0,
        /// To metres per second.
        velocity_m_per_s: f64 [POSITIVE] = 1.0,
        /// To newtons.
        force_n: f64 [POSITIVE] = 1.0,
    }
}
