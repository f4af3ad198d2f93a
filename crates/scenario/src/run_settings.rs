//! The settings of a scenario's run.

use super::engine_kind::EngineKind;
use trocar_engine::plant::ControlTiming;

trocar_core::settings! {
    /// The run itself.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct RunSettings in "simulation." no DEFAULT {
        /// Name of the run's folder and of its lines in figures.
        name: String at "name" => "the file's name without its extension",
        /// Time between two ticks. Estimator and detector count samples: their defaults are for 0.5 to 2 ms.
        tick_s: f64 [POSITIVE] = 1e-3,
        /// Length of the run.
        duration_s: Option<f64> [POSITIVE] => "the recording's length, or 7 s without one",
        /// How the plants are stepped.
        engine: EngineKind,
        /// In continuous time or on the tick.
        timing: ControlTiming,
        /// Seed of all random numbers.
        seed: u64 [0..] = 1,
    }
}
