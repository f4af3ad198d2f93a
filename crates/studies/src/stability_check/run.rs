use std::sync::Arc;

use crate::run::RunError;
use trocar_core::safety::SafetySettings;
use trocar_core::time::TickGrid;
use trocar_engine::channel::{Irregularity, Schedule};
use trocar_engine::engine::{Observer, Signals, UserDefinedParts};
use trocar_engine::operator::{Reflex, StiffeningSettings, StretchSettings};
use trocar_engine::plant::{MasterModelSettings, SlaveParameters};
use trocar_engine::sensor::SensorSettings;
use trocar_engine::teleoperation::EncoderSettings;
use trocar_engine::tissue::{OrganMotion, Reaction, Tissue};
use trocar_scenario::{EngineKind, OperatorSpec, Scenario};
use trocar_stability::LinearLoop;

const NUDGE_M: f64 = 1e-6;
const NUDGE_S: f64 = 0.02;

/// A motion has grown beyond this distance from the start.
const GROWN_M: f64 = 3e-3;

/// Fraction of the maximum squared speed.
const DECAYED: f64 = 1e-18;

/// The round-trip delay extends a run.
const SHORTEST_S: f64 = 8.0;
const PER_DELAY: f64 = 60.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Decays,
    Grows,
    /// Neither until the end, or NaN.
    Undecided,
}

impl Verdict {
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
        // False for NaN.
        let is_small = position.abs() < GROWN_M && square.is_finite();
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

/// `f = K x + B v` at any position: 0 at the start, and the needle cannot leave.
struct Spring {
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

impl Tissue<f64> for Spring {
    fn react(&mut self, _tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64> {
        let force_n = self.stiffness_n_per_m * position_m + self.damping_n_s_per_m * velocity_m_per_s;
        Reaction { force_n, ruptured: false }
    }
}

pub fn simulate(scenario: &Scenario, settings: &LinearLoop) -> Result<Verdict, RunError> {
    let run = linear_parts(scenario, settings)?;
    let tissue =
        Spring { stiffness_n_per_m: settings.stiffness_n_per_m, damping_n_s_per_m: settings.damping_n_s_per_m };
    let mut observer =
        SpeedObserver { quarter: (run.grid.ticks() / 4).max(1), sums: [0.0; 4], max: 0.0, verdict: None };
    let integration = |source| RunError::Engine { name: scenario.name.clone(), source };
    run.build_with(UserDefinedParts::default().tissue(tissue))?.run_compiled(&mut observer).map_err(integration)?;
    let [_, second, _, fourth] = observer.sums;
    Ok(observer.verdict.unwrap_or(match fourth.partial_cmp(&second) {
        Some(std::cmp::Ordering::Less) => Verdict::Decays,
        Some(std::cmp::Ordering::Greater) => Verdict::Grows,
        _ => Verdict::Undecided,
    }))
}

fn linear_parts(scenario: &Scenario, settings: &LinearLoop) -> Result<Scenario, RunError> {
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
    (run.timing, run.master, run.arm) = (settings.timing, settings.master, settings.arm);
    run.master_model =
        MasterModelSettings { coulomb_friction_n: 0.0, constant_force_n: 0.0, ..settings.master_model.clone() };
    run.slave =
        SlaveParameters { coulomb_friction_n: 0.0, constant_force_n: 0.0, start_m: None, ..settings.slave.clone() };
    (run.encoder, run.clutch) = (EncoderSettings::default(), Arc::default());
    (run.actuators, run.link, run.safety) = (settings.actuators, settings.link, SafetySettings::default());
    (run.forward, run.backward) = (settings.forward(), settings.backward());
    run.irregularity = Irregularity::default();
    (run.forward_schedule, run.backward_schedule) = (Schedule::default(), Schedule::default());
    run.operator = OperatorSpec::Recording(desired);
    (run.stretch, run.stiffening) = (StretchSettings::default(), StiffeningSettings::default());
    (run.tremor.amplitude_m, run.reflex.reflex, run.augmentation.enabled) = (0.0, Reflex::None, false);
    run.organ_motion = OrganMotion::default();
    run.sensor = SensorSettings { force_bandwidth_hz: settings.force_bandwidth_hz, ..SensorSettings::default() };
    Ok(run)
}
