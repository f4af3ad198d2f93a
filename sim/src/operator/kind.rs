//! The motions of a person by the words that scenarios use, and what each is told.

use std::sync::Arc;

use super::motion::{insertion_extraction, minimum_jerk, sine};

trocar_core::settings! {
    /// Where a motion begins.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StartSettings in "operator." {
        /// Where a ramp or a movement begins, and the centre of a swing.
        start_m: f64 [ANY] = 0.0,
    }
}

trocar_core::settings! {
    /// Where a motion ends.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct EndSettings in "operator." {
        /// Where a ramp or a movement ends.
        end_m: f64 [ANY] = 0.02,
    }
}

trocar_core::settings! {
    /// How long a motion takes.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MovementSettings in "operator." {
        /// How long a minimum-jerk movement or an insertion takes.
        movement_s: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::settings! {
    /// A constant speed.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RampSettings in "operator." {
        /// Where it begins.
        start: StartSettings,
        /// Where it ends.
        end: EndSettings,
        /// How fast a ramp gets there.
        speed_m_per_s: f64 [POSITIVE] = 0.01,
    }
}

trocar_core::settings! {
    /// The least jerk, from rest to rest.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MinimumJerkSettings in "operator." {
        /// Where it begins.
        start: StartSettings,
        /// Where it ends.
        end: EndSettings,
        /// How long it takes.
        movement: MovementSettings,
    }
}

trocar_core::settings! {
    /// In by pushes, a rest, and out again.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct InsertionExtractionSettings in "operator." {
        /// Where it begins.
        start: StartSettings,
        /// How deep it goes.
        end: EndSettings,
        /// How long the way in takes.
        movement: MovementSettings,
        /// In how many pushes, each from rest to rest, an insertion-extraction goes in.
        pushes: u64 [1..] = 1,
        /// How long an insertion-extraction rests inside.
        hold_s: f64 [NON_NEGATIVE] = 1.0,
        /// How long an insertion-extraction takes to come back.
        withdrawal_s: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::settings! {
    /// A swing.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SineSettings in "operator." {
        /// Its centre.
        start: StartSettings,
        /// Amplitude of a sine.
        amplitude_m: f64 [ANY] = 0.002,
        /// Frequency of a sine.
        frequency_hz: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::choice! {
    /// Replays the recording's position, moves at a constant speed or with the least jerk, in and out, or swings.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum MotionSettings at "operator.kind" = Recording {
        /// A recording.
        "recording" => Recording,
        /// A constant speed.
        "ramp" => Ramp(RampSettings),
        /// The least jerk, from rest to rest.
        "minimum-jerk" => MinimumJerk(MinimumJerkSettings),
        /// In by pushes, a rest, and out again.
        "insertion-extraction" => InsertionExtraction(InsertionExtractionSettings),
        /// A swing.
        "sine" => Sine(SineSettings),
    }
}

impl MinimumJerkSettings {
    /// Positions in m at `ticks` ticks of `tick_s` (s).
    #[must_use]
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        minimum_jerk(self.start.start_m, self.end.end_m, self.movement.movement_s, tick_s, ticks)
    }
}

impl InsertionExtractionSettings {
    /// Positions in m at `ticks` ticks of `tick_s` (s).
    #[must_use]
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        let way_in = (self.movement.movement_s, self.pushes);
        let way_out = (self.hold_s, self.withdrawal_s);
        insertion_extraction((self.start.start_m, self.end.end_m), way_in, way_out, tick_s, ticks)
    }
}

impl SineSettings {
    /// Positions in m at `ticks` ticks of `tick_s` (s).
    #[must_use]
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        sine(self.start.start_m, self.amplitude_m, self.frequency_hz, tick_s, ticks)
    }
}
