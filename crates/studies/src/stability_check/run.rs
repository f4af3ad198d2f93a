//! One run from equilibrium, and its verdict.

use std::sync::Arc;

use crate::run::RunError;
use trocar_core::time::TickGrid;
use trocar_engine::channel::{Irregularity, Schedule};
use trocar_engine::engine::{Observer, Signals};
use trocar_engine::operator::{Reflex, StiffeningSettings, StretchSettings};
use trocar_engine::sensor::SensorSettings;
use trocar_engine::tissue::{KelvinVoigtSettings, Surface, TissueSettings};
use trocar_scenario::{EngineKind, OperatorSpec, Scenario, TissueSpec};
use trocar_stability::LinearLoop;

/// Depth of the resting needle, in m.
const DEPTH_M: f64 = 0.01;

/// Amplitude of the hand's motion in m, and its duration in s.
const NUDGE_M: f64 = 1e-6;
const NUDGE_S: f64 = 0.02;

/// Fraction of the depth beyond which a motion counts as grown, shortly before contact is lost.
const GROWN: f64 = 0.3;

/// Fraction of the maximum squared speed below which a motion counts as decayed.
const DECAYED: f64 = 1e-18;

/// Minimum length of a run in s, and its extension per second of round-trip delay.
const SHORTEST_S: f64 = 8.0;
const PER_DELAY: f64 = 60.0;

/// The outcome of a small motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It decays.
    Decays,
    /// It grows.
    Grows,
    /// It neither decays nor grows until the end, or is NaN.
    Undecided,
}

impl Verdict {
    /// The name used in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Decays => "decays",
            Self::Grows => "grows",
            Self::Undecided => "undecided",
        }
    }
}

struct SpeedObserver {
    quarter: u64,
    sums: [f64; 4],
    max: f64,
    verdict: Option<Verdict>,
}

impl Observer<f64> for SpeedObserver {
    fn observe(&mut self, signals: &Signals<f64>) {
        let (position, velocity) = (signals.slave_position_m, signals.slave_velocity_m_per_s);
        let square = velocity * velocity;
        let now = (signals.tick / self.quarter).min(3) as usize;
        self.sums[now] += square;
        self.max = self.max.max(square);
        // False for NaN, which also counts as grown.
        let is_small = position.abs() < GROWN * DEPTH_M && square.is_finite();
        if !is_small {
            self.verdict = Some(Verdict::Grows);
        } else if signals.tick.is_multiple_of(self.quarter) && now > 0 {
            let mean = self.sums[now - 1] / self.quarter as f64;
            if self.max > 0.0 && mean < DECAYED * self.max {
                self.verdict = Some(Verdict::Decays);
            }
        }
    }

    fn is_done(&self) -> bool {
        self.verdict.is_some()
    }
}

/// Runs a loop's settings in the engine, with the scenario's estimator and detector and without augmentation.
///
/// # Errors
/// [`RunError`] if the plant of the settings cannot be computed.
pub fn simulate(scenario: &Scenario, settings: &LinearLoop) -> Result<Verdict, RunError> {
    let tick_s = settings.tick_s;
    let length_s = SHORTEST_S + PER_DELAY * (settings.forward_delay_s + settings.backward_delay_s);
    let invalid = |error| RunError::Scenario(scenario.values().out_of_range(&error));
    let nudge = (NUDGE_S / tick_s).ceil().max(2.0);
    let desired: Arc<[f64]> = (0..=nudge as usize)
        .map(|tick| {
            let share = tick as f64 / nudge;
            4.0 * NUDGE_M * share * (1.0 - share)
        })
        .collect();
    let mut run = scenario.clone();
    run.grid = TickGrid::new(tick_s, length_s).map_err(invalid)?;
    run.engine = EngineKind::Exact;
    (run.timing, run.master, run.arm, run.slave) =
        (settings.timing, settings.master, settings.arm, settings.slave.clone());
    (run.actuators, run.link) = (settings.actuators, settings.link);
    (run.forward, run.backward) = (settings.forward(), settings.backward());
    run.irregularity = Irregularity::default();
    (run.forward_schedule, run.backward_schedule) = (Schedule::default(), Schedule::default());
    run.operator = OperatorSpec::Recording(desired);
    (run.stretch, run.stiffening) = (StretchSettings::default(), StiffeningSettings::default());
    (run.tremor.amplitude_m, run.reflex.reflex, run.augmentation.enabled) = (0.0, Reflex::None, false);
    run.tissue = TissueSpec::from(TissueSettings::KelvinVoigt(KelvinVoigtSettings {
        stiffness_n_per_m: settings.stiffness_n_per_m,
        damping_n_s_per_m: settings.damping_n_s_per_m,
        surface: Surface { contact_m: -DEPTH_M },
    }));
    run.sensor = SensorSettings {
        force_bias_n: -settings.stiffness_n_per_m * DEPTH_M,
        force_bandwidth_hz: settings.force_bandwidth_hz,
        ..SensorSettings::default()
    };
    let mut observer =
        SpeedObserver { quarter: (run.grid.ticks() / 4).max(1), sums: [0.0; 4], max: 0.0, verdict: None };
    let integration = |source| RunError::Engine { name: scenario.name.clone(), source };
    run.build()?.run(&mut observer).map_err(integration)?;
    let [_, second, _, fourth] = observer.sums;
    Ok(observer.verdict.unwrap_or(match fourth.partial_cmp(&second) {
        Some(std::cmp::Ordering::Less) => Verdict::Decays,
        Some(std::cmp::Ordering::Greater) => Verdict::Grows,
        _ => Verdict::Undecided,
    }))
}
