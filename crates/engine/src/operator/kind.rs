use std::sync::Arc;

use super::motion::{insertion_extraction, minimum_jerk, sine};

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StartSettings in "operator." {
        /// Start of a ramp or a movement, or centre of a sine.
        start_m: f64 [ANY] = 0.0,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct EndSettings in "operator." {
        /// End of a ramp or a movement.
        end_m: f64 [ANY] = 0.02,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MovementSettings in "operator." {
        /// Duration of a minimum-jerk movement or an insertion.
        movement_s: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RampSettings in "operator." {
        start: StartSettings,
        end: EndSettings,
        /// Speed of a ramp.
        speed_m_per_s: f64 [POSITIVE] = 0.01,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MinimumJerkSettings in "operator." {
        start: StartSettings,
        end: EndSettings,
        movement: MovementSettings,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct InsertionExtractionSettings in "operator." {
        start: StartSettings,
        end: EndSettings,
        movement: MovementSettings,
        /// Number of pushes, each from rest to rest, of an insertion-extraction.
        pushes: u64 [1..] = 1,
        /// Duration of the pause between insertion and withdrawal of an insertion-extraction.
        hold_s: f64 [NON_NEGATIVE] = 1.0,
        /// Duration of the withdrawal of an insertion-extraction.
        withdrawal_s: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SineSettings in "operator." {
        start: StartSettings,
        /// Amplitude of a sine.
        amplitude_m: f64 [ANY] = 0.002,
        /// Frequency of a sine.
        frequency_hz: f64 [POSITIVE] = 1.0,
    }
}

trocar_core::choice! {
    /// Desired position: the recording, a constant speed, a minimum-jerk movement, an insertion and extraction, or a
    /// sine.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum MotionSettings at "operator.kind" = Recording {
        "recording" => Recording,
        "ramp" => Ramp(RampSettings),
        "minimum-jerk" => MinimumJerk(MinimumJerkSettings),
        "insertion-extraction" => InsertionExtraction(InsertionExtractionSettings),
        "sine" => Sine(SineSettings),
    }
}

impl MinimumJerkSettings {
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        minimum_jerk(self.start.start_m, self.end.end_m, self.movement.movement_s, tick_s, ticks)
    }
}

impl InsertionExtractionSettings {
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        let way_in = (self.movement.movement_s, self.pushes);
        let way_out = (self.hold_s, self.withdrawal_s);
        insertion_extraction((self.start.start_m, self.end.end_m), way_in, way_out, tick_s, ticks)
    }
}

impl SineSettings {
    pub fn positions_m(&self, tick_s: f64, ticks: u64) -> Arc<[f64]> {
        sine(self.start.start_m, self.amplitude_m, self.frequency_hz, tick_s, ticks)
    }
}
