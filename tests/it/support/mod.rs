//! Common code of the tests: reads tables, compares columns, builds an insertion by hand.

pub mod closed_forms;
pub mod passive_cases;
pub mod server;
pub mod test_folder;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use trocar::augmentation::{AugmentationSettings, Supervisor};
use trocar::chain::Chain;
use trocar::channel::Delay;
use trocar::detector::{CusumDetector, DetectorSettings};
use trocar::engine::{Any, Engine, Parts, Plants, ScheduledAlarms, TissueForce};
use trocar::estimation::{AnyEstimator, RlsSettings};
use trocar::operator::{HumanOperator, Motion, Ramp};
use trocar::plant::{ControlTiming, SlaveParameters, SlaveStep};
use trocar::scenario::{Scenario, Source};
use trocar::sensor::{AnySensor, SensorSettings};
use trocar::stability::{LinearLoop, SwitchingSettings};
use trocar::teleoperation::{
    ControllerSettings, Lines, Link, LinkSettings, Machines, PAYLOAD, PassivitySettings, RecoverySettings,
};
use trocar::time::TickGrid;
use trocar::tissue::{AnyTissue, KelvinVoigt, KelvinVoigtSettings};

/// Compares a text with a file of the repository; `BLESS=1` writes the file.
pub fn assert_file(name: &str, text: &str) {
    let (path, text) = (file(name), format!("{}\n", text.trim_end()));
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &text).expect("written");
    }
    assert!(std::fs::read_to_string(&path).expect("there") == text, "{name} is out of date; BLESS=1 renews it");
}

/// Loads a scenario that must be good.
pub fn scenario(name: &str, settings: &[&str]) -> Scenario {
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Scenario::load(&Source::parse(name), &settings).unwrap_or_else(|error| panic!("{name} {settings:?}: {error}"))
}

pub fn linear_loop(scenario: &Scenario) -> LinearLoop {
    trocar::stability_check::linear_loop(scenario).expect("analysed")
}

pub fn switching(scenario: &Scenario, tissue: (f64, f64)) -> Result<SwitchingSettings, String> {
    SwitchingSettings::of(scenario, linear_loop(scenario), tissue)
}

pub fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

pub fn files_with(extension: &str, folder: &Path) -> Vec<PathBuf> {
    let mut files = test_folder::files_below(folder);
    files.retain(|path| path.extension().is_some_and(|its| its == extension));
    files
}

/// Returns the columns of a CSV file of numbers, by name.
pub fn table(path: &str) -> HashMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(file(path)).expect("the file is there");
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let mut columns: HashMap<String, Vec<f64>> = names.iter().map(|n| (n.clone(), vec![])).collect();
    for record in reader.records() {
        for (name, field) in names.iter().zip(&record.expect("a row")) {
            columns.get_mut(name).expect("known").push(field.parse().expect("a number"));
        }
    }
    columns
}

/// Returns the maximum difference between a computed column, decimated by `every`, and the expected column, relative
/// to its peak.
pub fn difference(computed: &[f64], expected: &[f64], every: usize) -> f64 {
    let thinned: Vec<f64> = computed.iter().step_by(every).copied().collect();
    assert!(thinned.len() >= expected.len(), "{} rows computed, {} expected", thinned.len(), expected.len());
    assert!(thinned.iter().all(|value| value.is_finite()), "not every value is a number");
    let peak = expected.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    expected.iter().zip(&thinned).map(|(e, c)| (e - c).abs()).fold(0.0, f64::max) / peak
}

/// Returns `x_h, v_h, F_h, x_e, v_e` of plants with given inputs `(x_d, F_ed, x_ref)`.
pub fn drive(mut plants: impl Plants<f64>, ticks: usize, input: impl Fn(usize) -> (f64, f64, f64)) -> [Vec<f64>; 5] {
    let mut columns: [Vec<f64>; 5] = Default::default();
    for k in 0..ticks {
        let (master, slave) = (plants.master(), plants.slave());
        let row =
            [master.position_m, master.velocity_m_per_s, master.hand_force_n, slave.position_m, slave.velocity_m_per_s];
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
        let (desired, feedback, reference) = input(k);
        plants.step(desired, input(k + 1).0, feedback, reference, 0.0, TissueForce::zero()).expect("steps");
    }
    columns
}

/// A classical insertion into a Kelvin-Voigt tissue: 10 mm/s to 20 mm at 1 kHz for 3 s.
pub struct ClosedLoop {
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
    pub force_scale: f64,
    pub position_scale: f64,
    pub delay_ticks: u64,
}

impl ClosedLoop {
    fn link(&self, tick_s: f64) -> Link<f64> {
        let settings = LinkSettings {
            controller: ControllerSettings::DEFAULT,
            machines: Machines {
                master_mass_kg: 0.245,
                master_damping_n_s_per_m: 4.1,
                proportional_gain: 1300.0,
                velocity_gain: 15.0,
                slave_drag: 0.0,
                slave_inertia: 0.0,
                compliance_m_per_n: 0.0,
                position_scale: self.position_scale,
                force_scale: self.force_scale,
            },
            recovery: RecoverySettings::DEFAULT,
            passivity: PassivitySettings::DEFAULT,
        };
        let lines = Lines {
            forward: Delay::new(self.delay_ticks, [0.0; 4]),
            backward: Delay::new(self.delay_ticks, [0.0; 5]),
            forward_payload: Delay::new(self.delay_ticks, [0.0; PAYLOAD]),
            backward_payload: Delay::new(self.delay_ticks, [0.0; PAYLOAD]),
        };
        let slave = SlaveStep::new(&SlaveParameters::default(), ControlTiming::Continuous, tick_s).expect("valid");
        Link::new(&settings, lines, &slave, tick_s, 0.0).expect("valid")
    }

    pub fn engine<P: Plants<f64>>(&self, plants: P) -> Engine<P, Any<f64>> {
        let tick_s = 1e-3;
        let settings = AugmentationSettings { enabled: false, ..AugmentationSettings::default() };
        let (stiffness_n_per_m, damping_n_s_per_m) = (self.stiffness_n_per_m, self.damping_n_s_per_m);
        let tissue = KelvinVoigtSettings { stiffness_n_per_m, damping_n_s_per_m, ..KelvinVoigtSettings::DEFAULT };
        let tissue = KelvinVoigt::new(&tissue).expect("valid");
        let detector = CusumDetector::new(&DetectorSettings::default(), tick_s);
        Engine {
            grid: TickGrid::new(tick_s, 3.0).expect("valid"),
            plants,
            parts: Parts {
                operator: HumanOperator::new(Motion::Ramp(Ramp::new(0.0, 0.02, 0.01, tick_s).expect("valid"))),
                tissue: AnyTissue::from(tissue),
                sensor: AnySensor::new(&SensorSettings::default(), tick_s, (0, 0)).expect("valid"),
                chain: Chain {
                    contact_m: 0.0,
                    estimator: AnyEstimator::new(&RlsSettings::default()),
                    detector: ScheduledAlarms::new(detector, std::sync::Arc::default()),
                },
                supervisor: Supervisor::new(&settings, 1.98e-2, tick_s, 0.0),
                link: self.link(tick_s),
                safety: None,
                master_reading: None,
            },
        }
    }
}
