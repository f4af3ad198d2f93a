use super::engine_kind::EngineKind;
use trocar_engine::plant::ControlTiming;

trocar_core::settings! {
    /// The run itself.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct RunSettings in "simulation." no DEFAULT {
        /// Name of the run's folder, and of the run in figures.
        name: String at "name" => "the file's name without its extension",
        /// Time between two ticks. The defaults of estimator and detector, which count samples, suit 0.5 to 2 ms.
        tick_s: f64 [POSITIVE] = 1e-3,
        /// Length of the run.
        duration_s: Option<f64> [POSITIVE] => "the recording's length, or 7 s without one",
        /// Method of stepping the plants.
        engine: EngineKind,
        /// Timing of the controllers.
        timing: ControlTiming,
        /// Seed of all random numbers.
        seed: u64 [0..] = 1,
    }
}
