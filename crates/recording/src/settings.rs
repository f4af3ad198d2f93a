trocar_core::settings! {
    /// The recording and the times of its ruptures.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FileSettings in "recording." no const {
        /// A file (CSV, .mat, NumPy, Parquet, MCAP, TDMS; see `trocar detect FILE --list`), or builtin:in_vivo_like.csv, builtin:own_ctrl_pop.csv.
        file: Option<String> [FILE],
        /// Times of the ruptures, counted from the recording's first sample.
        ruptures_s: Vec<f64> = [],
        /// Duration of the beginning, with the needle free, whose mean force is subtracted from all forces; 0 subtracts nothing.
        tare_s: f64 [NON_NEGATIVE] = 0.0,
        /// True if the first position is subtracted from all positions.
        zero_at_start: bool = false,
    }
}

trocar_core::settings! {
    /// The signs of the file's numbers.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SignSettings in "recording." {
        /// -1 if the file has negative forces when the tissue resists insertion.
        force_sign: f64 [SIGN] = 1.0,
        /// -1 if the file's positions decrease into the tissue.
        position_sign: f64 [SIGN] = 1.0,
        /// -1 if the file has negative velocities during insertion.
        velocity_sign: f64 [SIGN] => "that of the position" position_sign,
    }
}

trocar_core::settings! {
    /// The names of the columns in the file's header, or of the signals in a file of arrays.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ColumnSettings in "recording.columns." no const {
        /// Time.
        time_s: String = "time_s",
        /// Position of the needle.
        position_m: String = "position_m",
        /// Velocity of the needle; estimated from the position when not given or "", which removes an inherited column.
        velocity_m_per_s: Option<String>,
        /// Force on the needle.
        force_n: String = "force_n",
    }
}

trocar_core::settings! {
    /// The factors that convert the columns to SI units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ScaleSettings in "recording.scale." {
        /// To seconds.
        time_s: f64 [POSITIVE] = 1.0,
        /// To metres, such as 0.075 for the angle of a lever of that length.
        position_m: f64 [POSITIVE] = 1.0,
        /// To metres per second.
        velocity_m_per_s: f64 [POSITIVE] = 1.0,
        /// To newtons.
        force_n: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::settings! {
    /// The offsets that are added to the scaled columns, in SI units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct OffsetSettings in "recording.offset." {
        /// To the times.
        time_s: f64 [ANY] = 0.0,
        /// To the positions, such as 0.1 with `position_sign = -1` for an axis that counts down from 0.1 m.
        position_m: f64 [ANY] = 0.0,
        /// To the velocities.
        velocity_m_per_s: f64 [ANY] = 0.0,
        /// To the forces.
        force_n: f64 [ANY] = 0.0,
    }
}
