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

/// Keeps the resting needle in contact.
const DEPTH_M: f64 = 0.05;

/// Exponents of 10 in m, from far below to far above the distance that a ramp closes in a tick.
const AMPLITUDE_EXPONENT: (f64, f64) = (-6.0, -2.0);

const PERIOD_S: (f64, f64) = (0.05, 2.0);

const DAMPING_N_S_PER_M: f64 = 5.0;

/// The supervisor ignores alarms that are too early.
const SPACINGS: [u64; 3] = [5, 50, 250];

#[derive(Debug, Clone, PartialEq)]
pub struct EventRun {
    /// `K`.
    pub stiffness_n_per_m: f64,
    /// Motion of the tissue away from the needle and back.
    pub amplitude_m: f64,
    pub period_s: f64,
    /// Frozen ticks per event.
    pub held_ticks: u64,
    /// Ticks, ascending.
    pub alarms: Vec<u64>,
    pub ticks: u64,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct EventRecord {
    /// Maximum distance from the resting position.
    pub slave_m: f64,
    pub events: u64,
    pub at_events_m: Vec<f64>,
    is_augmented: bool,
}

/// Maxima per newton of the force that the tissue's motion adds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Farthest {
    pub needle_m_per_n: f64,
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

/// Noise is off; only prescribed events occur.
pub fn without_alarms(source: &Source, settings: &[String]) -> Result<Scenario, ScenarioError> {
    let quiet = ["sensor.force_noise_std_n=0.0", "detector.threshold=1e6", "augmentation.exit_quiet_s=0.0"];
    let all: Vec<String> = settings.iter().cloned().chain(quiet.map(str::to_owned)).collect();
    Scenario::load(source, &all)
}

impl EventRun {
    pub fn drawn(seed: u64, index: u64, stiffness_n_per_m: (f64, f64), phases: Phases, ticks: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index);
        let stiffness_n_per_m = rng.random_range(stiffness_n_per_m.0..=stiffness_n_per_m.1);
        let held_ticks = rng.random_range(phases.held.0..=phases.held.1);
        let amplitude_m = libm::exp10(rng.random_range(AMPLITUDE_EXPONENT.0..AMPLITUDE_EXPONENT.1));
        let period_s = rng.random_range(PERIOD_S.0..PERIOD_S.1);
        let mut alarms = vec![];
        let mut tick = 0;
        let spacing = SPACINGS[(index % SPACINGS.len() as u64) as usize];
        while tick < ticks {
            tick += rng.random_range(1..=spacing);
            alarms.push(tick);
        }
        Self { stiffness_n_per_m, amplitude_m, period_s, held_ticks, alarms, ticks }
    }

    /// Largest additional force: `K A + B A π / T`.
    pub fn additional_force_n(&self) -> f64 {
        self.amplitude_m * (self.stiffness_n_per_m + DAMPING_N_S_PER_M * std::f64::consts::PI / self.period_s)
    }

    /// The needle rests in a spring and a damper of 5 N·s/m, which move as by a heartbeat.
    pub fn run(&self, base: &Scenario) -> Result<EventRecord, RunError> {
        let tick_s = base.grid.tick_s();
        let mut run = base.clone();
        let invalid = |error| RunError::Scenario(base.values().out_of_range(&error));
        run.grid = TickGrid::new(tick_s, self.ticks as f64 * tick_s).map_err(invalid)?;
        run.operator = OperatorSpec::Ramp { start_m: 0.0, end_m: 0.0, speed_m_per_s: 1.0 };
        run.organ_motion.heartbeat_amplitude_m = self.amplitude_m;
        run.organ_motion.heartbeat_period_s = self.period_s;
        run.tissue = TissueSpec::from(TissueSettings::KelvinVoigt(KelvinVoigtSettings {
            stiffness_n_per_m: self.stiffness_n_per_m,
            damping_n_s_per_m: DAMPING_N_S_PER_M,
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

pub fn random_sequences(
    base: &Scenario,
    (stiffness_n_per_m, phases): ((f64, f64), Phases),
    (count, ticks): (u64, u64),
    seed: u64,
) -> Result<Farthest, CheckError> {
    let one = |index: u64| -> Result<Farthest, CheckError> {
        let run = EventRun::drawn(seed, index, stiffness_n_per_m, phases, ticks);
        let record = run.run(base)?;
        Ok(Farthest { needle_m_per_n: record.slave_m / run.additional_force_n(), events: record.events })
    };
    let farther = |a: Farthest, b: Farthest| Farthest {
        needle_m_per_n: a.needle_m_per_n.max(b.needle_m_per_n),
        events: a.events + b.events,
    };
    Ok(try_map(count as usize, |index| one(index as u64))?.into_iter().fold(Farthest::default(), farther))
}
