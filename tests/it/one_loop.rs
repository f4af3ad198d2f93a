//! `trocar stability`, a sweep and the page report the same results for the linear loop of a scenario.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use crate::explore::ServedPage;
use crate::support::server::explore;
use crate::support::test_folder::TestFolder;
use trocar::scenario::{Scenario, Source, shipped_questions};
use trocar::stability::{ClosedLoop, Margins, Parameter, TissueRange, TissueSource};
use trocar::stability_check::LoopVerdict;
use trocar::tissue::Springs;

/// The force scales at which the outputs are compared, relative to the scenario's force scale.
const FACTORS: [f64; 3] = [0.7, 1.0, 3.5];

fn scenario(name: &str, settings: &[String]) -> Scenario {
    Scenario::load(&Source::parse(&format!("builtin:{name}.toml")), settings).expect("loads")
}

fn names() -> Vec<String> {
    shipped_questions().map(|(name, _)| name.trim_end_matches(".toml").to_owned()).collect()
}

/// The results of an output: verdict, worst stiffness, spectral radius and margins.
#[derive(Debug, PartialEq)]
struct Said {
    is_stable: Option<bool>,
    numbers: [Option<f64>; 5],
}

impl Said {
    fn of(verdict: &LoopVerdict) -> Self {
        let Margins { gain, phase_rad, delay_s, .. } = verdict.margins;
        let radius = verdict.mode.spectral_radius;
        let stiffness = verdict.settings.stiffness_n_per_m;
        Self { is_stable: verdict.is_stable(), numbers: [Some(stiffness), Some(radius), gain, phase_rad, delay_s] }
    }

    fn of_json(json: &Json) -> Self {
        let margin = |name: &str, flag: &str| {
            let is_unlimited = json["margins"][flag].as_bool().expect("a flag");
            if is_unlimited { Some(f64::INFINITY) } else { json["margins"][name].as_f64() }
        };
        let radius = json["mode"]["spectral_radius"].as_f64();
        Self {
            is_stable: json["is_stable"].as_bool(),
            numbers: [
                json["stiffness_n_per_m"].as_f64(),
                radius,
                margin("gain", "is_gain_unlimited"),
                margin("phase_rad", "is_phase_unlimited"),
                margin("delay_s", "is_delay_unlimited"),
            ],
        }
    }

    fn of_row(row: &BTreeMap<String, String>) -> Self {
        let number = |name: &str| row[&format!("stability_{name}")].parse::<f64>().ok();
        Self {
            is_stable: number("is_stable").map(|value| value == 1.0),
            numbers: ["stiffness_n_per_m", "spectral_radius", "gain_margin", "phase_margin_rad", "delay_margin_s"]
                .map(number),
        }
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn sweep_and_page_agree_with_stability_on_every_shipped_scenario() {
    let folder = TestFolder::new();
    let (_server, address) = explore(&[]);
    let mut page = ServedPage::open(address);
    let (mut unstable, mut unknown) = (0, 0);
    for (index, name) in names().iter().enumerate() {
        let scale = scenario(name, &[]).link.machines.force_scale;
        let scales = FACTORS.map(|factor| factor * scale);
        let text = format!(
            "base = \"builtin:{name}.toml\"\nmetrics = [\"stability_is_stable\", \"stability_stiffness_n_per_m\", \
             \"stability_spectral_radius\", \"stability_gain_margin\", \"stability_phase_margin_rad\", \
             \"stability_delay_margin_s\"]\n[axes]\nscaling.force = {scales:?}\n"
        );
        folder.file("loops.toml", text);
        folder.good(&["sweep", "loops.toml", "--overwrite", "--quiet", "--set", "simulation.duration_s=0.1"]);
        let rows = crate::sweep::rows(&folder, "out/loops/cases.csv");
        for (scale, row) in scales.iter().zip(&rows) {
            // The depth that the needle reaches in this time limits the tissue.
            let settings = [format!("scaling.force={scale:?}"), "simulation.duration_s=0.1".to_owned()];
            let said = Said::of(&LoopVerdict::of(&scenario(name, &settings)).expect("analysed"));
            assert_eq!(Said::of_row(row), said, "{name} at {scale}");
            unstable += usize::from(said.is_stable == Some(false));
            unknown += usize::from(said.is_stable.is_none());
        }
        // The page computes a whole map, so one of the three scales is enough.
        let scale = scales[index % 3];
        let state = json!({ "scenario": format!("builtin:{name}.toml"), "set": { "scaling.force": scale } });
        let request = json!({
            "type": "map", "state": state, "x": "scaling.force", "y": "tissue.stiffness_n_per_m",
        });
        let said =
            Said::of(&LoopVerdict::of(&scenario(name, &[format!("scaling.force={scale:?}")])).expect("analysed"));
        assert_eq!(Said::of_json(&page.request(request, "mapped")), said, "{name} at {scale} on the page");
    }
    assert!(unstable >= 2 && unknown > 20, "{unstable} {unknown}");
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_command_stability_prints_and_writes_the_verdict_of_the_loop() {
    let folder = TestFolder::new();
    for name in ["layers/skin-augmented", "paper/classical"] {
        let settings = ["scaling.force=3.0".to_owned()];
        let verdict = LoopVerdict::of(&scenario(name, &settings)).expect("analysed");
        let command = ["stability", name, "--set", &settings[0], "--tissue", "0:0", "--x", "scaling.force=1:3:3"];
        let json = folder.json(&[&command[..], &["--y", "tissue.stiffness_n_per_m=100:900:3", "--json"]].concat());
        assert_eq!(Said::of_json(&json), Said::of(&verdict), "{name}");
        assert_eq!(
            json["tissue"]["stiffness_n_per_m"][1].as_f64(),
            Some(verdict.settings.tissue.springs.stiffness_n_per_m.1)
        );
    }
}

/// Skin with a rupture force of 5.3 N has a slope of 874 N/m just before it ruptures. Cut at 1.5 N, its slope is 482
/// N/m plus the 400 N/m of the sticking shaft.
#[test]
fn oracle_layers_are_as_stiff_as_their_stiffest_slope_between_ruptures() {
    let verdict = LoopVerdict::of(&scenario("layers/skin-augmented", &[])).expect("analysed");
    let slope = |force: f64| (150.0_f64.powi(2) + 4.0 * 35_000.0 * force).sqrt();
    let stiffest = slope(5.3).max(slope(1.5) + 400.0);
    let tissue = verdict.settings.tissue;
    assert_eq!(tissue.source, TissueSource::Layers);
    assert!((tissue.springs.stiffness_n_per_m.1 - stiffest).abs() < 1e-9 * stiffest, "{tissue:?}");
    assert_eq!(verdict.settings.stiffness_n_per_m, tissue.springs.stiffness_n_per_m.1);
    // Without damping the gain is proportional to the stiffness, and the limit is 2517.674 N/m.
    let gain = verdict.margins.gain.expect("stable");
    assert!((gain * stiffest / 2_517.674_458 - 1.0).abs() < 1e-6, "{gain}");
}

/// The slopes of a run while the needle advances, without the time after ruptures, are within the range of the
/// parameters. The damping of the layers adds 6 % in the fastest stab.
#[test]
fn the_tissue_in_a_run_is_never_stiffer_than_its_parameters_state() {
    use trocar::engine::{Observer, Signals};
    struct Steepest {
        surface_m: f64,
        from: Option<(f64, f64)>,
        until: u64,
        n_per_m: f64,
    }
    impl Observer<f64> for Steepest {
        fn observe(&mut self, s: &Signals<f64>) {
            let (depth_m, force_n) = (s.slave_position_m - self.surface_m, s.tissue_force_n);
            if s.ruptured {
                self.until = s.tick + 100;
            }
            if s.slave_velocity_m_per_s <= 0.0 || depth_m <= 0.0 || s.tick < self.until {
                self.from = None;
                return;
            }
            let (from_m, from_n) = *self.from.get_or_insert((depth_m, force_n));
            if depth_m - from_m >= 5e-4 {
                self.n_per_m = self.n_per_m.max((force_n - from_n) / (depth_m - from_m));
                self.from = Some((depth_m, force_n));
            }
        }
    }
    let mut compared = 0;
    for name in names() {
        let quiet = ["sensor.force_noise_std_n=0.0".to_owned(), "operator.tremor_amplitude_m=0.0".to_owned()];
        let scenario = scenario(&name, &quiet);
        let (Some(range), Some(settings)) = (TissueRange::of_parameters(&scenario), scenario.tissue.settings()) else {
            continue;
        };
        if range.source != TissueSource::Layers {
            continue;
        }
        let mut steepest =
            Steepest { surface_m: settings.surface_m().expect("a model"), from: None, until: 0, n_per_m: 0.0 };
        trocar::run::observe(&scenario, &mut steepest).expect("runs");
        let (_, high) = range.springs.stiffness_n_per_m;
        assert!(steepest.n_per_m < 1.1 * high, "{name}: {} of {high}", steepest.n_per_m);
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn a_force_recorded_over_time_closes_no_loop_unless_a_tissue_is_stated() {
    let of =
        |settings: &[&str]| LoopVerdict::of(&crate::support::scenario("paper/classical", settings)).expect("analysed");
    let free = of(&["scaling.force=1000"]);
    assert_eq!((free.settings.stiffness_n_per_m, free.settings.damping_n_s_per_m), (0.0, 0.0));
    assert_eq!((free.is_stable(), free.margins.gain), (Some(true), Some(f64::INFINITY)));
    // Only master and slave remain: the slowest pole is that of the arm and the master's controller.
    assert!((free.mode.spectral_radius - (-12.624_623_69e-3_f64).exp()).abs() < 1e-9, "{:?}", free.mode);
    let stated = of(&["tissue.stiffness_n_per_m=1000", "tissue.damping_n_s_per_m=0"]);
    assert_eq!(stated.settings.tissue.source, TissueSource::Stated);
    assert!((stated.margins.gain.expect("stable") - 2.517_674_458).abs() < 1e-8, "{:?}", stated.margins);
}

/// The second of three resonances is the worst stiffness: softer and stiffer tissues have larger margins.
#[test]
fn verdict_and_margins_use_the_worst_stiffness_in_the_range() {
    let scenario = scenario("passivity/late-wall", &["scaling.force=0.5".to_owned()]);
    let range = TissueRange { source: TissueSource::Model, springs: Springs::between((0.0, 1500.0), (0.0, 0.0)) };
    let worst = trocar::stability::LinearLoop::of(&scenario, range).expect("analysed");
    let room = |stiffness: f64| {
        let at = worst.with(Parameter::Stiffness, stiffness);
        ClosedLoop::new(&at).expect("built").margins().expect("followed").gain.expect("stable")
    };
    let least = (1..=1500).map(|k| room(f64::from(k))).fold(f64::INFINITY, f64::min);
    assert!(room(worst.stiffness_n_per_m) <= least * (1.0 + 1e-9), "{} {least}", worst.stiffness_n_per_m);
    assert!(worst.in_range().expect("analysed").is_stable);
    let beyond = TissueRange { source: TissueSource::Model, springs: Springs::between((0.0, 2500.0), (0.0, 0.0)) };
    let beyond = trocar::stability::LinearLoop::of(&scenario, beyond).expect("analysed");
    assert!(!beyond.in_range().expect("analysed").is_stable);
    assert_eq!(beyond.stiffness_n_per_m, 2500.0);
}
