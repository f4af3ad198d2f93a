//! One run from equilibrium, and what it says.

use std::sync::Arc;

use crate::channel::{Irregularity, Schedule};
use crate::engine::{Observer, Signals};
use crate::operator::Reflex;
use crate::run::RunError;
use crate::scenario::{EngineKind, OperatorSpec, Scenario, TissueSpec};
use crate::sensor::SensorSettings;
use crate::stability::LoopSettings;
use crate::time::TickGrid;
use crate::tissue::{KelvinVoigtSettings, Surface, TissueSettings};

/// How deep the needle rests, in m.
const DEPTH_M: f64 = 0.01;

/// How far the hand moves, in m, and for how long, in s.
const NUDGE_M: f64 = 1e-6;
const NUDGE_S: f64 = 0.02;

/// A share of the depth beyond which a motion has grown: contact is about to be lost.
const GROWN: f64 = 0.3;

/// A share of the greatest speed below which a motion has died out, in its square.
const DIED_OUT: f64 = 1e-18;

/// Shortest run in s, and how much longer it is for the delay around the loop.
const SHORTEST_S: f64 = 8.0;
const PER_DELAY: f64 = 60.0;

/// What a small motion comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It dies out.
    Decays,
    /// It grows.
    Grows,
    /// It is still there at the end, neither less nor more, or is no number.
    Undecided,
}

/// Watches the needle's speed over four quarters of a run.
struct Watch {
    quarter: u64,
    /// Sums of squares.
    sums: [f64; 4],
    greatest: f64,
    verdict: Option<Verdict>,
}

impl Observer<f64> for Watch {
    fn observe(&mut self, signals: &Signals<f64>) {
        let (position, velocity) = (signals.slave_position_m, signals.slave_velocity_m_per_s);
        let square = velocity * velocity;
        let now = (signals.tick / self.quarter).min(3) as usize;
        self.sums[now] += square;
        self.greatest = self.greatest.max(square);
        // False for NaN, which counts as grown too.
        let is_small = position.abs() < GROWN * DEPTH_M && square.is_finite();
        if !is_small {
            self.verdict = Some(Verdict::Grows);
        } else if signals.tick.is_multiple_of(self.quarter) && now > 0 {
            let mean = self.sums[now - 1] / self.quarter as f64;
            if self.greatest > 0.0 && mean < DIED_OUT * self.greatest {
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
/// [`RunError`] where the settings make no machine.
pub fn simulate(scenario: &Scenario, settings: &LoopSettings) -> Result<Verdict, RunError> {
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
    let mut watch = Watch { quarter: (run.grid.ticks() / 4).max(1), sums: [0.0; 4], greatest: 0.0, verdict: None };
    let integration = |source| RunError::Integration { name: scenario.name.clone(), source };
    run.build()?.run(&mut watch).map_err(integration)?;
    let [_, second, _, fourth] = watch.sums;
    Ok(watch.verdict.unwrap_or(match fourth.partial_cmp(&second) {
        Some(std::cmp::Ordering::Less) => Verdict::Decays,
        Some(std::cmp::Ordering::Greater) => Verdict::Grows,
        _ => Verdict::Undecided,
    }))
}
