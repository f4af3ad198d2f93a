//! What each component of an engine is given over a whole run.

use trocar::augmentation::Situation;
use trocar::detect::evidence;
use trocar::detection::Evidence;
use trocar::engine::{Engine, ExactPlants, Observer, Signals};
use trocar::teleoperation::Connection;

/// Keeps every tick.
struct Recorder(Vec<Signals<f64>>);

impl Observer<f64> for Recorder {
    fn observe(&mut self, signals: &Signals<f64>) {
        self.0.push(*signals);
    }
}

/// The inputs of a run, tick by tick.
pub struct Inputs {
    /// `x_d` now and at the next tick (m), the fed-back force (N), the slave's reference (m).
    pub plants: Vec<[f64; 4]>,
    /// The tick, and where the slave is and how it moves (m, m/s).
    pub tissue: Vec<(u64, f64, f64)>,
    /// The tissue's force in N.
    pub sensor: Vec<f64>,
    /// Measured force (N), depth below the contact (m), velocity (m/s).
    pub estimator: Vec<[f64; 3]>,
    /// What the estimator made of it.
    pub detector: Vec<Evidence<f64>>,
    /// What the detector made of that, and the hand.
    pub supervisor: Vec<Situation<f64>>,
    /// What an observer sees.
    pub observer: Vec<Signals<f64>>,
}

impl Inputs {
    /// Runs a copy of an engine that reads positions exactly. What the estimator is given is checked to be what it was
    /// given in the run: it has to foretell the same, to the last bit.
    pub fn of(engine: &Engine<f64, ExactPlants<f64>>) -> Self {
        let mut recorder = Recorder(Vec::with_capacity(engine.grid.ticks() as usize));
        engine.clone().run(&mut recorder).expect("runs");
        let signals = recorder.0;
        let mut operator = engine.operator.clone();
        let mut estimator = engine.estimator.clone();
        let mut detector_sees = |s: &Signals<f64>| {
            let (depth_m, velocity_m_per_s) = (s.slave_position_m - engine.contact_m, s.slave_velocity_m_per_s);
            let estimate = estimator.update(s.measured_force_n, depth_m, velocity_m_per_s);
            assert_eq!(estimate.residual_n.to_bits(), s.residual_n.to_bits(), "tick {}", s.tick);
            evidence(s.measured_force_n, depth_m, velocity_m_per_s, &estimate)
        };
        let situation = |s: &Signals<f64>| Situation {
            tick: s.tick,
            alarm: s.alarm,
            decision: s.decision,
            hand_m: engine.link.position_scale() * s.master_position_m,
            slave_m: s.slave_position_m,
            force_n: engine.link.force_scale() * s.measured_force_n,
        };
        let mut side = |s: &Signals<f64>| {
            let next_m = operator.desired_position_m(s.tick + 1, s.operator_force_n);
            [s.desired_position_m, next_m, s.feedback_force_n, s.slave_reference_m]
        };
        let detector: Vec<_> = signals.iter().map(&mut detector_sees).collect();
        Self {
            plants: signals.iter().map(&mut side).collect(),
            tissue: signals.iter().map(|s| (s.tick, s.slave_position_m, s.slave_velocity_m_per_s)).collect(),
            sensor: signals.iter().map(|s| s.tissue_force_n).collect(),
            estimator: detector.iter().map(|e| [e.force_n, e.depth_m, e.velocity_m_per_s]).collect(),
            supervisor: signals.iter().map(situation).collect(),
            detector,
            observer: signals,
        }
    }
}
