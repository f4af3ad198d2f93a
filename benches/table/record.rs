//! The inputs of each component of an engine over a whole run.

use trocar::augmentation::SupervisorInput;
use trocar::detector::DetectorInput;
use trocar::engine::{Observer, Signals};
use trocar::estimation::{Estimator, Rls};
use trocar::operator::Operator;
use trocar::scenario::Scenario;

struct Recorder(Vec<Signals<f64>>);

impl Observer<f64> for Recorder {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.0.push(*signals);
    }
}

/// The inputs of a run, one per tick.
pub struct Inputs {
    /// `x_d` now and at the next tick (m), the feedback force (N), the slave's reference (m).
    pub plants: Vec<[f64; 4]>,
    /// The tick, and the slave's position and velocity (m, m/s).
    pub tissue: Vec<(u64, f64, f64)>,
    /// The tissue force, in N.
    pub sensor: Vec<f64>,
    /// Measured force (N), depth below the contact (m), velocity (m/s).
    pub estimator: Vec<[f64; 3]>,
    pub detector: Vec<DetectorInput<f64>>,
    /// The supervisor's situation, and the measured force scaled to the master (N).
    pub supervisor: Vec<(SupervisorInput<f64>, [f64; 2])>,
    pub observer: Vec<Signals<f64>>,
}

impl Inputs {
    /// Runs a scenario that reads positions exactly, with the paper's estimator. Checks that the recorded inputs
    /// reproduce the predictions of the run bit for bit.
    pub fn of(scenario: &Scenario) -> Self {
        let mut recorder = Recorder(Vec::with_capacity(scenario.grid.ticks() as usize));
        let mut engine = scenario.general_engine::<f64>(0).expect("a shipped scenario builds");
        let mut operator = engine.parts.operator.clone();
        engine.run(&mut recorder).expect("runs");
        let signals = recorder.0;
        let mut estimator = Rls::<f64>::new(&scenario.estimator);
        let mut evidence_of = |s: &Signals<f64>| {
            let (depth_m, velocity_m_per_s) = (s.slave_position_m - scenario.contact_m, s.slave_velocity_m_per_s);
            let estimate = estimator.update(s.measured_force_n, depth_m, velocity_m_per_s);
            assert_eq!(estimate.residual_n.to_bits(), s.residual_n.to_bits(), "tick {}", s.tick);
            DetectorInput::new(s.measured_force_n, depth_m, velocity_m_per_s, &estimate)
        };
        let machines = &scenario.link.machines;
        let input = |s: &Signals<f64>| {
            let input = SupervisorInput {
                tick: s.tick,
                alarm: s.alarm,
                decision: s.decision,
                hand_m: machines.position_scale * s.master_position_m,
                slave_m: s.slave_position_m,
                force_n: s.measured_force_n,
            };
            (input, [machines.force_scale * s.measured_force_n, s.master_velocity_m_per_s])
        };
        let mut plants_input = |s: &Signals<f64>| {
            let next_m = operator.desired_position_m(s.tick + 1, s.operator_force_n);
            [s.desired_position_m, next_m, s.feedback_force_n, s.slave_reference_m]
        };
        let detector: Vec<_> = signals.iter().map(&mut evidence_of).collect();
        Self {
            plants: signals.iter().map(&mut plants_input).collect(),
            tissue: signals.iter().map(|s| (s.tick, s.slave_position_m, s.slave_velocity_m_per_s)).collect(),
            sensor: signals.iter().map(|s| s.tissue_force_n).collect(),
            estimator: detector.iter().map(|e| [e.force_n, e.depth_m, e.velocity_m_per_s]).collect(),
            supervisor: signals.iter().map(input).collect(),
            detector,
            observer: signals,
        }
    }
}
