//! The scenarios in which the test changes a key.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::iter::successors;
use std::sync::{Arc, Mutex};

use trocar::scenario::{Key, KeyAt, Scenario, Source, Values, find_key};
use trocar::settings::ActsFor;

use super::Chosen;
use super::outputs::Outputs;
use super::trials::trial_values;
use crate::support::test_folder::TestFolder;

/// The common part of all scenarios: an insertion in which most parts have an effect.
const COMMON: &str = r#"
name = "base"

[simulation]
duration_s = 0.8
tick_s = 0.002

[recording]
file = "insertion.csv"
ruptures_s = [0.3, 0.5]
columns.velocity_m_per_s = "velocity_m_per_s"

[channel]
forward_delay_s = 0.003
backward_delay_s = 0.004
jitter_s = 0.003
loss = 0.1
outages_s = [0.45, 0.5]
outage_s = 0.02

[operator]
kind = "minimum-jerk"
start_m = -0.002
end_m = 0.035
movement_s = 0.5
hold_s = 0.05
withdrawal_s = 0.1
speed_m_per_s = 0.08
amplitude_m = 0.02
frequency_hz = 4.0
tremor_amplitude_m = 2e-5

[perception]
reflex = "withdraw"
reflex_reaction_min_s = 0.01
reflex_reaction_max_s = 0.02
reflex_pause_s = 0.03
reflex_withdraw_m = 0.0002

[tissue]
kind = "layers"
index = "depth"
layer = [
    { name = "skin", thickness_m = 0.001, stiffness_n_per_m = 150.0, stiffening_n_per_m2 = 3.5e4, rupture_force_n = 1.0, cutting_force_n = 0.5, grip_n = 0.3 },
    { name = "fat", thickness_m = 0.002, stiffness_n_per_m = 60.0 },
    { name = "muscle", thickness_m = 0.003, stiffness_n_per_m = 150.0, stiffening_n_per_m2 = 1e4, rupture_force_n = 1.2, cutting_force_n = 0.8, friction_n_per_m = 50.0, grip_n = 0.2 },
    { name = "capsule", thickness_m = 0.001, stiffness_n_per_m = 60.0, stiffening_n_per_m2 = 1e4, rupture_force_n = 1.2, relaxation_s = 0.015, friction_n_per_m = 0.0, grip_n = 0.1 },
    { name = "organ", thickness_m = 0.004, stiffness_n_per_m = 60.0, friction_n_per_m = 8.0 },
]

[sensor]
force_noise_std_n = 0.005
force_bandwidth_hz = 200.0
force_resolution_n = 1e-3
force_range_n = 2.0
position_resolution_m = 1e-6

[detector]
settle_s = 0.01

[augmentation]
min_hold_s = 0.01
max_hold_s = 0.06
blend_s = 0.01
exit_quiet_s = 0.005
refractory_s = 0.02
events_s = [0.2, 0.35]

[population]
size = 3
arm = "people"
tissue = "log-normal"
delay = "uniform"
"#;

/// The changes of each scenario. A key has an effect only if its part is active.
const VARIANTS: &[&str] = &[
    "",
    // Motors at their limits.
    "simulation.control=sampled actuator.master_force_limit_n=1 actuator.slave_command_limit=20 \
     actuator.master_force_rate_limit_n_per_s=200 actuator.slave_command_rate_limit_per_s=2000 \
     actuator.master_lag_s=0.002 actuator.slave_lag_s=0.002",
    // The same motors without the slave's lag, which only the appendix' slave has.
    "simulation.control=sampled actuator.master_force_limit_n=1 actuator.slave_command_limit=20 \
     actuator.master_force_rate_limit_n_per_s=200 actuator.slave_command_rate_limit_per_s=2000 \
     actuator.master_lag_s=0.002",
    // A passivity scheme with little energy.
    "passivity.scheme=time-domain passivity.budget_j=1e-5 channel.forward_delay_s=0.02 channel.backward_delay_s=0.03",
    // Thin layers, so that the needle leaves the last one.
    "tissue.layer.skin.thickness_m=0.0005 tissue.layer.fat.thickness_m=0.001 tissue.layer.muscle.thickness_m=0.001 \
     tissue.layer.capsule.thickness_m=0.0005 tissue.layer.organ.thickness_m=0.001 perception.reflex=stop augmentation.events_s=[0.2]",
    // Alarms at many times.
    "augmentation.events_s=[0.05,0.1,0.15,0.17,0.19,0.21,0.23,0.25,0.27,0.29,0.31,0.33,0.35,0.37,0.39,0.41] \
     augmentation.max_hold_s=0.03 augmentation.refractory_s=0.03",
    // A decision that is quiet soon after an alarm, later, or never.
    "detector.threshold=0.5 detector.drift=0.001 augmentation.events_s=[0.1,0.3] augmentation.max_hold_s=0.2 \
     sensor.force_noise_std_n=0.02 augmentation.refractory_s=0.1",
    "detector.distance=variance-change detector.threshold=40 detector.cap=60 augmentation.max_hold_s=0.3",
    "detector.threshold=0.01 detector.drift=1e-9 sensor.force_noise_std_n=0.05",
    // A supervisor that waits for a longer quiet time than the detector's own after an alarm, while the needle moves
    // on in noise.
    "augmentation.hold=none augmentation.exit_quiet_s=0.1 augmentation.max_hold_s=0.4 augmentation.events_s=[0.3] \
     operator.start_m=-0.1 sensor.force_noise_std_n=0.05",
    // A decision that is quiet at once, and a supervisor that waits for a longer quiet time than possible.
    "augmentation.exit_quiet_s=0.5",
    // No delays except those of a file.
    "channel.forward_delay_s=0 channel.backward_delay_s=0",
    // A recording without velocity.
    "recording.columns.velocity_m_per_s='' tissue.kind=kelvin-voigt",
    // A force recorded over time, which a stated tissue can replace.
    "tissue.kind=recording tissue.index=time",
    // The master as printed, which diverges: fast, to and fro, with a passivity scheme, and slowly.
    "master.coupling=as-printed master.force_integral_gain=1.0 operator.end_m=-0.02 operator.start_m=0.0",
    "master.coupling=as-printed master.force_integral_gain=0.5 operator.kind=sine operator.start_m=0.0",
    "master.coupling=as-printed master.force_integral_gain=0.5 operator.kind=sine operator.start_m=0.0 \
     passivity.scheme=time-domain passivity.budget_j=1e-6 channel.forward_delay_s=0.02 channel.backward_delay_s=0.03",
    "master.coupling=as-printed master.force_integral_gain=0.1 operator.kind=sine operator.start_m=0.0 \
     operator.amplitude_m=-0.003 tissue.layer.skin.rupture_force_n=0.001 tissue.layer.skin.cutting_force_n=0.001 \
     tissue.layer.skin.thickness_m=0.01 tissue.layer.skin.grip_n=0.001 tissue.layer.skin.friction_n_per_m=0.1 \
     tissue.breathing_amplitude_m=1e-6 tissue.heartbeat_amplitude_m=1e-6",
    // In and out of a spring, with noise and outages.
    "operator.kind=sine operator.start_m=0.01 tissue.kind=kelvin-voigt tissue.stiffness_n_per_m=100 \
     sensor.force_noise_std_n=0.1 sensor.force_range_n=10 detector.settle_s=0.002 perception.reflex=none \
     channel.outages_s=[0.1,0.15,0.3,0.35,0.5,0.55] channel.recovery_force_rate_n_per_s=5",
    // A late wall.
    "tissue.kind=kelvin-voigt tissue.stiffness_n_per_m=1000 tissue.damping_n_s_per_m=0 controller.kind=position-position \
     passivity.scheme=time-domain passivity.budget_j=1e-6 channel.forward_delay_s=0.05 channel.backward_delay_s=0.05 \
     channel.jitter_s=0 channel.loss=0 channel.outages_s=[] augmentation.enabled=false perception.reflex=none \
     operator.kind=ramp operator.end_m=0.02 operator.speed_m_per_s=0.04 sensor.force_bandwidth_hz=0 \
     sensor.force_range_n=20 simulation.duration_s=2",
    // An operator who decides at every tick and often misses a change.
    "perception.kind=psychometric perception.criterion=0 perception.interval_s=0.002 perception.weber_fraction=0.01 \
     perception.absolute_force_n=0.01 perception.lapse_rate=0.3",
    // An operator who notices only cues, but those at once.
    "perception.kind=psychometric perception.criterion=5 perception.lapse_rate=0 perception.weber_fraction=0.9 \
     perception.integration_s=0.005 perception.reaction_mean_s=0.01 perception.reaction_min_s=0 perception.reflex=stop \
     augmentation.events_s=[0.1,0.2,0.3,0.4]",
    // A tense operator.
    "operator.stretch_short_gain_n_s_per_m=2 operator.stretch_long_gain_n_per_m=10 operator.stiffening_per_n=0.05",
    "tissue.breathing_amplitude_m=0.002 tissue.breathing_period_s=0.5 tissue.heartbeat_amplitude_m=0.0005",
    // Gains that only one of the slave's controllers has.
    "slave.derivative_gain=5 slave.force_feed_forward=0.5",
    // Commands at the limits of the safety stage.
    "safety.acts=everywhere safety.force_limit_n=0.5 safety.force_rate_n_per_s=50 safety.reference_speed_m_per_s=0.04 \
     safety.lead_m=0.001 channel.dead_s=0.02 channel.dead_decay_s=0.01 channel.outages_s=[0.2,0.35,0.45,0.5]",
    // No random numbers.
    "perception.reflex=none operator.tremor_amplitude_m=0 channel.jitter_s=0 channel.loss=0 \
     sensor.position_resolution_m=0 sensor.force_noise_std_n=0",
];

/// A scenario that the test changes.
pub struct Base {
    source: Source,
    settings: Vec<String>,
    values: Values,
    /// The outputs by further settings.
    known: Mutex<HashMap<Vec<String>, Option<Arc<Outputs>>>>,
}

impl Base {
    fn new(source: Source, settings: &str) -> Self {
        let settings: Vec<String> = settings.split_whitespace().map(str::to_owned).collect();
        let values = Values::load(&source, &settings).expect("good");
        Self { source, settings, values, known: Mutex::default() }
    }

    fn load(&self, settings: &[String]) -> Values {
        let all = [self.settings.as_slice(), settings].concat();
        Values::load(&self.source, &all).unwrap_or_else(|error| panic!("{all:?}: {error}"))
    }

    /// Returns the settings of a kind, and of the kinds for which a key has an effect.
    pub fn settings_for(&self, key: &Key, chosen: Chosen) -> Vec<String> {
        let conditions = |key: &Key| {
            let choice = |acts: &ActsFor| find_key(acts.key).and_then(|choice| choice.acts_for);
            successors(key.acts_for, choice).flat_map(ActsFor::conditions)
        };
        let has_kind = |acts: &ActsFor| {
            let present = self.values.get(acts.key).map(|value| value.to_toml().to_string());
            present.is_some_and(|present| acts.words().contains(&present.trim_matches('"')))
        };
        let needed = conditions(key).filter(|acts| !has_kind(acts));
        let needed = needed.map(|acts| format!("{}={}", acts.key, acts.words()[0]));
        needed.chain([format!("{}={}", chosen.key, chosen.word)]).collect()
    }

    /// Returns the outputs with these settings, without checking that they have an effect; `None` if the scenario is
    /// refused.
    pub fn changed(&self, settings: &[String]) -> Option<Outputs> {
        Outputs::of(self.load(settings))
    }

    /// Returns true if the scenario exists with a kind. Checks that its echo gives the same scenario.
    pub fn is_echoed(&self, chosen: Chosen) -> bool {
        let Ok(scenario) = Scenario::resolve(self.load(&[format!("{}={}", chosen.key, chosen.word)])) else {
            return false;
        };
        let echo = scenario.echo();
        let again = Scenario::load(&Source::Text { name: "echo".into(), text: echo.clone().into() }, &[]);
        assert_eq!(again.unwrap_or_else(|error| panic!("{error}\n{echo}")).echo(), echo);
        true
    }

    /// Returns the same as [`Base::changed`], computed once.
    pub fn outputs(&self, settings: &[String]) -> Option<Arc<Outputs>> {
        once(&self.known, settings, || self.changed(settings).map(Arc::new))
    }
}

/// Computes a value for some settings once. Another thread may compute the same value meanwhile.
fn once<T: Clone>(known: &Mutex<HashMap<Vec<String>, T>>, settings: &[String], compute: impl FnOnce() -> T) -> T {
    let found = known.lock().expect("no panic").get(settings).cloned();
    found.unwrap_or_else(|| {
        let computed = compute();
        known.lock().expect("no panic").insert(settings.to_vec(), computed.clone());
        computed
    })
}

pub struct Scenarios {
    folder: TestFolder,
    defaults: Base,
    /// Values of the defaults by further settings.
    known: Mutex<HashMap<Vec<String>, Arc<Values>>>,
    pub all: Vec<Base>,
}

impl Scenarios {
    pub fn new() -> Self {
        let folder = TestFolder::new();
        folder.file("base.toml", COMMON);
        folder.file("insertion.csv", insertion(1.0)).file("other.csv", insertion(1.1));
        folder.file("delays.csv", "time_s,forward_delay_s,backward_delay_s\n0,0.001,0.002\n0.3,0.004,0.001\n");
        folder.file("machine.toml", "A = [[0, 1], [0, -9]]\nB = [[0], [4]]\nC = [[1, 0]]\n");
        let source = Source::Disk(folder.path("base.toml"));
        let all = VARIANTS.iter().map(|settings| Base::new(source.clone(), settings)).collect();
        let defaults = Base::new(Source::Text { name: "defaults".into(), text: "".into() }, "");
        Self { folder, defaults, known: Mutex::default(), all }
    }

    /// Returns true if a key is declared to have an effect for a kind. Checks that setting it for other kinds is an
    /// error.
    pub fn is_declared(&self, key: &KeyAt, chosen: Chosen) -> bool {
        let mut settings = self.defaults.settings_for(key, chosen);
        let values = once(&self.known, &settings, || Arc::new(self.defaults.load(&settings)));
        if values.is_acting(key) {
            return true;
        }
        let value = trial_values(key, values.get(&key.path), self).into_iter().next().expect("a value");
        settings.push(format!("{}={value}", key.path));
        // A key that states a tissue has an effect as soon as it is written.
        if self.defaults.load(&settings).is_acting(key) {
            return true;
        }
        let error = Scenario::load(&self.defaults.source, &settings).expect_err("without effect");
        assert!(error.to_string().contains(&format!("{} has no effect", key.path)), "{settings:?}: {error}");
        false
    }

    /// Returns the trial values of a key whose declaration gives none.
    pub fn values_of(&self, path: &str) -> Option<Vec<String>> {
        let file = |name: &str| format!("{:?}", self.folder.path(name).display().to_string());
        Some(match path {
            "name" => vec!["other".into()],
            "recording.file" => vec![file("other.csv")],
            "channel.delays_file" => vec![file("delays.csv")],
            "recording.columns.time_s" => vec!["time_2_s".into()],
            "recording.columns.position_m" => vec!["position_2_m".into()],
            "recording.columns.velocity_m_per_s" => vec!["velocity_2_m_per_s".into()],
            "recording.columns.force_n" => vec!["force_2_n".into()],
            "recording.max_bytes" => vec!["100".into()],
            "recording.max_samples" => vec!["10".into()],
            "recording.max_gap_s" => vec!["1e-4".into()],
            "augmentation.events_s" => vec!["[0.15, 0.3]".into()],
            "recording.ruptures_s" => vec!["[0.31, 0.52]".into()],
            "tissue.spared_layer" => vec!["skin".into(), "muscle".into()],
            "slave.start_m" => vec!["-0.01".into()],
            "operator.clutch_s" => vec!["[0.2, 0.3]".into()],
            "master.denominator" => vec!["[0.3, 4.1, 0.0]".into()],
            "master.file" => vec![file("machine.toml")],
            "master.a" => vec!["[0.0, 1.0, 0.0, -10.0]".into()],
            "master.b" => vec!["[0.0, 0.0, 5.0, 5.0]".into()],
            "master.c" => vec!["[1.1, 0.0]".into()],
            "slave.denominator" => vec!["[1.0, 90.0, 0.1, 0.0]".into()],
            "slave.file" => vec![file("machine.toml")],
            "slave.a" => vec!["[0.0, 1.0, 0.0, -5.0]".into()],
            "slave.b" => vec!["[0.0, 0.0, 5.0, 5.0]".into()],
            "slave.c" => vec!["[1.1, 0.0]".into()],
            _ => return None,
        })
    }
}

/// Returns an insertion of 45 mm, with a withdrawal of some millimetres, as a table.
fn insertion(scale: f64) -> String {
    let mut text =
        String::from("time_s,position_m,velocity_m_per_s,force_n,time_2_s,position_2_m,velocity_2_m_per_s,force_2_n\n");
    for k in 0..800 {
        let t = 1e-3 * f64::from(k);
        let position = scale * (-0.002 + 0.045 * (0.5 - 0.5 * (PI * t / 0.55).cos()));
        let velocity = scale * 0.045 * 0.5 * PI / 0.55 * (PI * t / 0.55).sin();
        let load = if t < 0.3 { 100.0 } else { 60.0 };
        let force = (load * position + 2.0 * velocity).max(0.0) + 0.01 * (900.0 * t).sin();
        writeln!(
            text,
            "{t:.3},{position:.7},{velocity:.5},{force:.4},{:.5},{:.7},{:.5},{:.4}",
            1.01 * t,
            1.1 * position,
            1.1 * velocity,
            1.1 * force
        )
        .expect("text");
    }
    text
}
