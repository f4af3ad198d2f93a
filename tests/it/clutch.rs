//! The clutch of the master, its encoder, and a slave that starts elsewhere, in whole runs.

use trocar::engine::Trace;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};

/// A ramp of 20 mm in 1 s, in air.
const BASE: [&str; 8] = [
    "operator.kind=ramp",
    "operator.start_m=0",
    "operator.end_m=0.02",
    "operator.speed_m_per_s=0.02",
    "tissue.contact_m=0.5",
    "augmentation.enabled=false",
    "simulation.duration_s=2",
    "passivity.scheme=none",
];

fn load(settings: &[&str]) -> Result<Scenario, String> {
    let all: Vec<String> = BASE.iter().chain(settings).map(|setting| (*setting).to_owned()).collect();
    Scenario::load(&Source::parse("builtin:passivity/late-wall.toml"), &all).map_err(|error| error.to_string())
}

fn trace(settings: &[&str]) -> Trace {
    run(load(settings).expect("loads")).expect("runs").trace
}

fn last(column: &[f64]) -> f64 {
    *column.last().expect("samples")
}

#[test]
fn the_slave_does_not_follow_while_the_clutch_is_open() {
    let open = trace(&["operator.clutch_s=[0.4, 0.6]"]);
    let at = |tick: usize| (open.master_position_m[tick], open.slave_reference_m[tick]);
    let (before, after) = (at(399), at(600));
    assert!((after.0 - before.0 - 0.004).abs() < 2e-4, "the hand moves on: {before:?} {after:?}");
    // The delay of the link is 50 ms each way.
    let references = &open.slave_reference_m[460..640];
    assert!(references.iter().all(|m| *m == references[0]), "the reference stays");
    let offset = open.master_position_m[599] - open.master_position_m[399];
    assert!((last(&open.master_position_m) - last(&open.slave_position_m) - offset).abs() < 1e-6);
    assert!(offset > 3e-3);
}

#[test]
fn an_open_clutch_leaves_the_master_free() {
    let spring = ["tissue.contact_m=0", "tissue.stiffness_n_per_m=300", "operator.clutch_s=[0.6, 0.9]"];
    let open = trace(&spring);
    let felt = |from: usize, to: usize| open.feedback_force_n[from..to].iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    assert!(felt(500, 600) > 1.0);
    assert_eq!(felt(600, 900), 0.0);
    assert!(felt(900, 1000) > 1.0);
}

#[test]
fn the_reference_moves_in_steps_of_the_masters_encoder() {
    let stepped = trace(&["master.encoder_resolution_m=1e-3"]);
    let steps = stepped.slave_reference_m.iter().all(|m| (m / 1e-3 - (m / 1e-3).round()).abs() < 1e-9);
    assert!(steps && last(&stepped.slave_reference_m) > 0.015);
}

#[test]
fn a_slave_that_starts_elsewhere_moves_to_the_masters_reference() {
    for extra in [&[][..], &["slave.model=mass-damper"], &["simulation.engine=dop853"], &["simulation.control=sampled"]]
    {
        let away = trace(&[&["slave.start_m=-0.005"], extra].concat());
        let usual = trace(extra);
        assert!((away.slave_position_m[0] + 0.005).abs() < 1e-12, "{extra:?}");
        assert!(away.slave_position_m[1] > -0.005, "{extra:?}");
        assert!((away.slave_position_m[1900] - usual.slave_position_m[1900]).abs() < 1e-6, "{extra:?}");
    }
}

#[test]
fn what_a_passivity_scheme_cannot_observe_is_refused_beside_it() {
    for key in ["operator.clutch_s=[0.4, 0.6]", "slave.start_m=0.01"] {
        let message = load(&[key, "passivity.scheme=time-domain"]).expect_err("refused");
        assert!(message.contains("passivity.scheme"), "{message}");
    }
    let message = load(&["operator.clutch_s=[0.4]"]).expect_err("refused");
    assert!(message.contains("has no end"), "{message}");
}
