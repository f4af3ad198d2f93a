use std::sync::atomic::AtomicBool;

use super::{Check, StabilityStudy, Unconfirmed, Verdict, check, linear_loop};
use trocar_base::warning::Code;
use trocar_document::Study as _;
use trocar_scenario::{Scenario, Source, keys_outside_loop};
use trocar_stability::{Axis, assumed_passive, inputs, left_out, map};

fn owned(settings: &[&str]) -> Vec<String> {
    settings.iter().map(|&setting| setting.to_owned()).collect()
}

fn scenario(name: &str, settings: &[&str]) -> Scenario {
    Scenario::load(&Source::parse(name), &owned(settings)).expect("loads")
}

fn axes(x: &str, y: &str) -> (Axis, Axis) {
    (Axis::parse(x).expect("an axis"), Axis::parse(y).expect("an axis"))
}

fn study(name: &str, settings: &[&str]) -> StabilityStudy {
    let axes = axes("scaling.force=0.1:10:2", "tissue.stiffness_n_per_m=10:2000:2");
    StabilityStudy::of(&scenario(name, settings), axes, None).expect("analysed")
}

/// Five kinds of machine, the last with Coulomb friction.
const MACHINES: [(&str, &[&str]); 5] = [
    ("passivity/late-wall", &["slave.compliance_m_per_n=0.0002"]),
    ("passivity/late-wall", &["simulation.control=sampled", "actuator.slave_lag_s=0.002"]),
    (
        "passivity/late-wall",
        &[
            "slave.model=state-space",
            "slave.a=[0.0, 1.0, 0.0, 0.0, -5.0, 2.5, 0.0, 0.0, -400.0]",
            "slave.b=[0.0, 0.0, 0.0, 2.5, 400.0, 0.0]",
            "slave.c=[1.0, 0.0, 0.0]",
            "slave.constant_force_n=-2",
            "slave.start_m=0.001",
        ],
    ),
    (
        "passivity/late-wall",
        &["master.model=mass-damper", "master.coulomb_friction_n=0.2", "master.encoder_resolution_m=1e-5"],
    ),
    ("rig/teleop-1dof-f", &[]),
];

#[test]
fn the_simulation_agrees_with_the_map_for_every_kind_of_machine() {
    let (x, y) = axes("scaling.force=0.1:10:7:log", "tissue.stiffness_n_per_m=10:2000:6");
    for (name, settings) in MACHINES {
        let scenario = scenario(name, settings);
        let of_loop = linear_loop(&scenario).expect("analysed");
        let map = map(&of_loop, x, y).expect("mapped");
        let share = map.stable_share();
        assert!(share > 0.1 && share < 0.95, "{settings:?}: {share}");
        let check = check((&scenario, &of_loop), &map, &AtomicBool::new(false), || {}).expect("ran");
        let apart = [&check.disagreements, &check.undecided];
        assert_eq!((check.counts(), check.agreement()), ([check.judged, 0, 0], Some(1.0)), "{settings:?}: {apart:?}");
    }
}

#[test]
fn the_comparison_counts_undecided_points_apart_and_names_the_parts_left_out() {
    let mut study = study("rig/teleop-1dof-f", &[]);
    let unconfirmed =
        |simulated| Unconfirmed { x: 1.0, y: 2.0, analytic_stable: true, simulated, is_near_boundary: false };
    study.check = Some(Check {
        simulated: vec![Some(Verdict::Decays), Some(Verdict::Grows), Some(Verdict::Undecided), None],
        judged: 3,
        disagreements: vec![unconfirmed(Verdict::Grows)],
        undecided: vec![unconfirmed(Verdict::Undecided)],
    });
    let document = study.document();
    let of_runs = &document.json["simulated"];
    assert_eq!((&of_runs["judged"], &of_runs["agreement"]), (&3.into(), &0.5.into()));
    assert_eq!(of_runs["disagreements"][0]["simulated"], "grows");
    assert_eq!(of_runs["undecided"][0]["simulated"], "undecided");
    let text = format!("{:?}", document.sections[0]);
    for phrase in [
        "Simulation, without the slave's Coulomb friction (slave.coulomb_friction_n): of 3 points more than 0.5 % from \
         the boundary, 1 agree, 1 disagree and 1 are undecided.",
        "Text(\"undecided\")",
    ] {
        assert!(text.contains(phrase), "no {phrase:?} in {text}");
    }
}

#[test]
fn a_margin_without_a_limit_differs_from_that_of_an_unstable_loop() {
    let text_of = |study: &StabilityStudy| {
        let of_loop = study.document().sections.into_iter().find(|section| section.id == "metrics").expect("a section");
        format!("{of_loop:?}")
    };
    let cases: [(&str, &[&str], bool); 2] =
        [("paper/classical", &[], true), ("layers/through-the-skin", &["scaling.force=100"], false)];
    for (name, settings, is_unlimited) in cases {
        let study = study(name, settings);
        assert_eq!(study.analysis.is_stable(), is_unlimited, "{name}");
        let json = &study.document().json["margins"];
        for margin in ["gain", "phase", "delay", "jitter"] {
            assert_eq!(json[format!("is_{margin}_unlimited")], is_unlimited, "{name} {margin}");
        }
        for value in ["gain", "phase_rad", "delay_s", "jitter_s"] {
            assert!(json[value].is_null(), "{name} {value}");
        }
        assert_eq!(text_of(&study).contains("unlimited"), is_unlimited, "{name}");
    }
}

#[test]
fn no_part_that_the_analysis_leaves_out_is_called_without_effect() {
    let parts = [
        "master.model=mass-damper master.coulomb_friction_n=0.1",
        "slave.model=mass-damper slave.coulomb_friction_n=0.1",
        "passivity.scheme=time-domain",
        "channel.jitter_s=0.01",
        "channel.outages_s=[0.1,0.2]",
        "tissue.breathing_amplitude_m=0.001",
        "tissue.heartbeat_amplitude_m=0.001",
        "perception.reflex=stop",
        "operator.stretch_short_gain_n_s_per_m=1",
        "operator.stiffening_per_n=0.1",
        "operator.clutch_s=[0.1,0.2]",
        "master.encoder_resolution_m=1e-5",
        "sensor.position_resolution_m=1e-5",
        "sensor.force_resolution_n=0.01",
        "simulation.control=sampled actuator.master_force_limit_n=0.1",
        "simulation.control=sampled actuator.master_force_rate_limit_n_per_s=0.1",
        "simulation.control=sampled actuator.slave_command_limit=0.1",
        "simulation.control=sampled actuator.slave_command_rate_limit_per_s=0.1",
        "sensor.force_range_n=0.1",
    ];
    for part in parts {
        // The bounds of limits take long, and are not computed with lost samples.
        let settings: Vec<&str> = std::iter::once("channel.loss=0.1").chain(part.split(' ')).collect();
        let (key, _) = settings[settings.len() - 1].split_once('=').expect("a key");
        let scenario = scenario("passivity/late-wall", &settings);
        let found = [left_out(&scenario, None), assumed_passive(&scenario), inputs(&scenario)].concat();
        assert!(found.iter().any(|left_out| left_out.key == key), "{part}: {found:?}");
        assert_eq!(keys_outside_loop(&scenario, &owned(&settings)), [], "{part}");
    }
}

#[test]
fn a_rounded_delay_is_a_warning_of_the_document() {
    let study = study("passivity/late-wall", &["simulation.control=sampled", "channel.delay_s=0.0105"]);
    let found: Vec<_> = study.warnings().into_iter().filter(|warning| warning.code == Code::DelayRounded).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    let document = study.document();
    assert!(document.warnings.contains(&found[0]));
    let codes = document.json["warnings"].as_array().expect("an array").iter().map(|warning| warning["code"].clone());
    assert_eq!(codes.filter(|code| code == "delay-rounded").count(), 1);
}
