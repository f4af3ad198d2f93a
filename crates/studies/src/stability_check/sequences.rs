//! Runs random sequences of events in the engine, to compare them with the bounds of an analysis.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

use super::CheckError;
use crate::run::RunError;
use trocar_base::parallel::try_map;
use trocar_core::time::TickGrid;
use trocar_engine::engine::{Observer, Signals};
use trocar_engine::tissue::{KelvinVoigtSettings, Surface, TissueSettings};
use trocar_scenario::{OperatorSpec, Scenario, ScenarioError, Source, TissueSpec};
use trocar_stability::Phases;

/// Depth of the resting needle in m, which keeps it in contact.
const DEPTH_M: f64 = 0.05;

/// Range of the hand's distance from its desired position at the release, as exponents of 10 in m: from far below to
/// far above the distance that a ramp closes in a tick.
const DISTANCE_EXPONENT: (f64, f64) = (-6.0, -2.0);

/// Maximum ticks between alarms. The supervisor ignores alarms that are too early.
const SPACINGS: [u64; 3] = [5, 50, 250];

/// A release of the hand with events, with one stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRun {
    /// `K` in N/m.
    pub stiffness_n_per_m: f64,
    /// Distance of the hand from its desired position, in m.
    pub distance_m: f64,
    /// Number of frozen ticks of each event.
    pub held_ticks: u64,
    /// Ticks of the alarms, ascending.
    pub alarms: Vec<u64>,
    /// Number of ticks of the run.
    pub ticks: u64,
}

/// The record of an engine run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EventRecord {
    /// Maximum distance of the slave from the resting position, in m.
    pub slave_m: f64,
    /// Number of events.
    pub events: u64,
    /// Position of the slave at the beginning of each event, in m.
    pub at_events_m: Vec<f64>,
    is_augmented: bool,
}

/// The maxima over many runs, per metre of the hand's distance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Farthest {
    /// Position of the slave, in m/m.
    pub slave: f64,
    /// Number of events of all runs.
    pub events: u64,
}

impl Observer<f64> for EventRecord {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.slave_m = self.slave_m.max(signals.slave_position_m.abs());
        let is_augmented = signals.mode.is_augmented();
        if is_augmented && !self.is_augmented {
            self.events += 1;
            self.at_events_m.push(signals.slave_position_m);
        }
        self.is_augmented = is_augmented;
    }
}

/// Loads a scenario without noise, in which only prescribed events occur.
///
/// # Errors
/// As [`Scenario::load`].
pub fn without_alarms(source: &Source, settings: &[String]) -> Result<Scenario, ScenarioError> {
    let quiet = ["sensor.force_noise_std_n=0.0", "detector.threshold=1e6", "augmentation.exit_quiet_s=0.0"];
    let all: Vec<String> = settings.iter().cloned().chain(quiet.map(str::to_owned)).collect();
    Scenario::load(source, &all)
}

impl EventRun {
    /// Draws a random run: the stiffness from a range, and an allowed length of the freeze.
    #[must_use]
    pub fn drawn(seed: u64, index: u64, stiffness_n_per_m: (f64, f64), phases: Phases, ticks: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let stiffness_n_per_m = rng.random_range(stiffness_n_per_m.0..=stiffness_n_per_m.1);
        let held_ticks = rng.random_range(phases.held.0..=phases.held.1);
        let distance_m = libm::exp10(rng.random_range(DISTANCE_EXPONENT.0..DISTANCE_EXPONENT.1));
        let mut alarms = vec![];
        let mut tick = 0;
        let spacing = SPACINGS[(index % SPACINGS.len() as u64) as usize];
        while tick < ticks {
            tick += rng.random_range(1..=spacing);
            alarms.push(tick);
        }
        Self { stiffness_n_per_m, distance_m, held_ticks, alarms, ticks }
    }

    /// Runs it in the engine: the needle rests in a spring and a damper of 5 N·s/m, and the hand is released.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn run(&self, base: &Scenario) -> Result<EventRecord, RunError> {
        let tick_s = base.grid.tick_s();
        let mut run = base.clone();
        let invalid = |error| RunError::Scenario(base.values().out_of_range(&error));
        run.grid = TickGrid::new(tick_s, self.ticks as f64 * tick_s).map_err(invalid)?;
        run.operator = OperatorSpec::Ramp {
            start_m: self.distance_m,
            end_m: 0.0,
            // The desired position is reached in the first tick.
            speed_m_per_s: 2.0 * self.distance_m.abs() / tick_s,
        };
        run.tissue = TissueSpec::from(TissueSettings::KelvinVoigt(KelvinVoigtSettings {
            stiffness_n_per_m: self.stiffness_n_per_m,
            damping_n_s_per_m: 5.0,
            surface: Surface { contact_m: -DEPTH_M },
        }));
        run.sensor.force_bias_n = -DEPTH_M * self.stiffness_n_per_m;
        run.augmentation.automaton.min_hold_s = self.held_ticks as f64 * tick_s;
        run.augmentation.automaton.max_hold_s = self.held_ticks as f64 * tick_s;
        run.events = Arc::from(self.alarms.as_slice());
        let mut record = EventRecord::default();
        let integration = |source| RunError::Engine { name: base.name.clone(), source };
        run.build()?.run(&mut record).map_err(integration)?;
        Ok(record)
    }
}

/// Runs random sequences of events, in parallel.
///
/// # Errors
/// [`CheckError`] if a run fails.
pub fn random_sequences(
    base: &Scenario,
    (stiffness_n_per_m, phases): ((f64, f64), Phases),
    (count, ticks): (u64, u64),
    seed: u64,
) -> Result<Farthest, CheckError> {
    let one = |index: u64| -> Result<Farthest, CheckError> {
        let run = EventRun::drawn(seed, index, stiffness_n_per_m, phases, ticks);
        let record = run.run(base)?;
        Ok(Farthest {
            slave: record.slave_m / run.distance_m,
            events: record.events,
        })
    };
    let farther = |a: Farthest, b: Farthest| Farthest {
        slave: a.slave.max(b.slave),
        events: a.events + b.events,
    };
    Ok(try_map(count as usize, |index| one(index as u64))?.into_iter().fold(Farthest::default(), farther))
}
