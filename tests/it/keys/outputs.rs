//! The outputs of a scenario's values: a run, a detection in the recording, a study of detectors, an analysis of
//! stability.

use crate::support;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use trocar::detect::{DetectionReport, detect};
use trocar::detector::DistanceKind;
use trocar::engine::{ColumnValues, Trace};
use trocar::population::Draw;
use trocar::roc::{Signal, Study};
use trocar::run::observe;
use trocar::scenario::{DetectionSpec, Scenario, Value, Values};
use trocar::stability::{ClosedLoop, LinearLoop};

const RECORDING: [&str; 4] = ["recording", "recording.columns", "recording.scale", "recording.offset"];

/// The outputs of a scenario, computed on demand.
pub struct Outputs {
    values: Values,
    scenario: Scenario,
    run: OnceLock<u64>,
    linear_loop: OnceLock<LinearLoop>,
    stability: OnceLock<u64>,
    detection: OnceLock<u64>,
    roc: OnceLock<u64>,
}

impl Outputs {
    /// Returns `None` if the scenario is refused.
    pub fn of(values: Values) -> Option<Self> {
        let scenario = Scenario::resolve(values.clone()).ok()?;
        let [run, stability, detection, roc] = [const { OnceLock::new() }; 4];
        Some(Self { values, scenario, run, linear_loop: OnceLock::new(), stability, detection, roc })
    }

    /// Returns true if any output differs, bit for bit.
    pub fn differ(&self, other: &Self) -> bool {
        let settings_differ = !are_equal(&self.scenario, &other.scenario);
        if settings_differ && self.run() != other.run() {
            return true;
        }
        let recording = |values: &Values| RECORDING.map(|section| values.section_json(section));
        let detection_differs = settings_differ || recording(&self.values) != recording(&other.values);
        (self.linear_loop() != other.linear_loop() && self.stability() != other.stability())
            || population(&self.scenario) != population(&other.scenario)
            || self.scenario.layers_to_rupture() != other.scenario.layers_to_rupture()
            || (detection_differs && self.detection() != other.detection())
            || (settings_differ && self.roc() != other.roc())
    }

    /// Returns the value of a key, also if it is derived.
    pub fn value(&self, path: &str) -> Option<&Value> {
        self.scenario.values().get(path)
    }

    fn run(&self) -> u64 {
        *self.run.get_or_init(|| run(&self.scenario))
    }

    fn linear_loop(&self) -> &LinearLoop {
        self.linear_loop.get_or_init(|| support::linear_loop(&self.scenario))
    }

    fn stability(&self) -> u64 {
        *self.stability.get_or_init(|| stability(self.linear_loop()))
    }

    fn detection(&self) -> u64 {
        *self.detection.get_or_init(|| detection(&self.values))
    }

    fn roc(&self) -> u64 {
        *self.roc.get_or_init(|| roc(&self.scenario))
    }
}

/// Returns true if all public fields are equal, from which an engine is built.
fn are_equal(one: &Scenario, other: &Scenario) -> bool {
    let run = |s: &Scenario| (s.name.clone(), s.grid, s.engine, s.timing, s.seed, s.forward, s.backward);
    let machines = |s: &Scenario| (s.master, s.arm, s.slave.clone(), s.actuators, s.link, s.irregularity, s.safety);
    let schedules = |s: &Scenario| (s.forward_schedule.clone(), s.backward_schedule.clone(), s.events.clone());
    let ends = |s: &Scenario| (s.operator.clone(), s.tremor, s.reflex, s.perception, s.tissue.clone(), s.organ_motion);
    let arm = |s: &Scenario| (s.stretch, s.stiffening);
    let master = |s: &Scenario| (s.master_model.clone(), s.encoder, s.clutch.clone());
    let detection = |s: &Scenario| (s.sensor, s.estimator, s.contact_m, s.detector, s.augmentation);
    run(one) == run(other)
        && machines(one) == machines(other)
        && schedules(one) == schedules(other)
        && ends(one) == ends(other)
        && arm(one) == arm(other)
        && master(one) == master(other)
        && detection(one) == detection(other)
}

fn hash(write: impl FnOnce(&mut DefaultHasher)) -> u64 {
    let mut hasher = DefaultHasher::new();
    write(&mut hasher);
    hasher.finish()
}

/// Hashes numbers by a rotation and a multiplication each, because the hasher takes ten times as long.
fn numbers(column: &[f64], hasher: &mut DefaultHasher) {
    let mix = |sum: u64, value: &f64| (sum.rotate_left(5) ^ value.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    column.iter().fold(column.len() as u64, mix).hash(hasher);
}

/// Hashes the name, metrics and trace of the run; 0 if it fails.
fn run(scenario: &Scenario) -> u64 {
    let mut trace = Trace::new(scenario.grid).with_extra_parameter(scenario.estimator.extra_parameter_column());
    let Ok(metrics) = observe(scenario, &mut trace.recorder()) else { return 0 };
    hash(|hasher| {
        scenario.name.hash(hasher);
        format!("{metrics:?}").hash(hasher);
        for column in trace.columns() {
            match column {
                ColumnValues::Numbers(column) => numbers(column, hasher),
                ColumnValues::Codes(codes) => codes.hash(hasher),
            }
        }
        trace.extra_parameter.iter().for_each(|(_, column)| numbers(column, hasher));
    })
}

/// Hashes the detection in the recording; 0 if it is refused.
fn detection(values: &Values) -> u64 {
    let Ok(spec) = DetectionSpec::resolve(&mut values.clone()) else { return 0 };
    let Ok(detection) = detect(&spec) else { return 0 };
    let report = DetectionReport::of(&detection, &spec.recording.ruptures_s);
    hash(|hasher| {
        [&detection.velocity_m_per_s, &detection.residual_n, &detection.stiffness_n_per_m, &detection.decision]
            .iter()
            .for_each(|column| numbers(column, hasher));
        format!("{report:?}").hash(hasher);
    })
}

/// Hashes the counts of `roc` for all distances in the closed loop; 0 if it is refused.
fn roc(scenario: &Scenario) -> u64 {
    // The study needs exact positions.
    let mut scenario = scenario.clone();
    scenario.sensor.position_resolution_m = 0.0;
    let Ok(signal) = Signal::closed_loop(scenario, &DistanceKind::ALL) else { return 0 };
    let study = Study { signals: vec![signal], noise_std_n: vec![0.0], seeds: 1, thresholds: 8, within_s: 0.05 };
    let Ok(counts) = study.run(&AtomicBool::new(false), &|| ()) else { return 0 };
    hash(|hasher| format!("{counts:?}").hash(hasher))
}

/// Returns the members of the population, which determine its limits.
fn population(scenario: &Scenario) -> Vec<Draw> {
    let population = &scenario.population;
    if !population.varies() {
        return vec![];
    }
    (0..population.size).map(|index| population.drawn(scenario.seed, index)).collect()
}

/// Hashes the gain of the linear loop at some frequencies; 0 if the loop cannot be analysed.
fn stability(settings: &LinearLoop) -> u64 {
    let Ok(closed) = ClosedLoop::new(settings) else { return 0 };
    hash(|hasher| {
        for angle_rad in [0.01, 0.1, 1.0] {
            let gain = closed.loop_gain(1.0, angle_rad);
            numbers(&[gain.re, gain.im], hasher);
        }
    })
}
