//! Stability from measured frequency responses: tables that are computed from the model give the model's limits, and
//! the command says what a table leaves open.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::support;
use crate::support::test_folder::TestFolder;
use nalgebra::DMatrix;
use trocar::lti::{Complex64, Continuous, StateSpace};
use trocar::plant::{ControlTiming, master_system, slave_system};
use trocar::scenario::{Scenario, Source};
use trocar::stability::{
    ClosedLoop, FrequencyResponse, LinearLoop, MeasuredLoop, MeasuredSides, MeasuredVerdict, Parameter, Search,
    largest_stable,
};

const BASE: [&str; 5] = [
    "augmentation.enabled=false",
    "passivity.scheme=none",
    "channel.forward_delay_s=0.02",
    "channel.backward_delay_s=0.03",
    "tissue.stiffness_n_per_m=600",
];

fn settings(further: &[&str]) -> LinearLoop {
    let all: Vec<String> = BASE.iter().chain(further).map(|setting| (*setting).to_owned()).collect();
    support::linear_loop(&Scenario::load(&Source::parse("builtin:passivity/late-wall.toml"), &all).expect("loads"))
}

/// Responses from the equations in continuous time: position of the master in the direction of the force per N, and of
/// the slave per metre of the reference, each with the hold of its command.
fn responses(settings: &LinearLoop, hertz: f64) -> [Complex64; 2] {
    let s = Complex64::new(0.0, TAU * hertz);
    let hold = (Complex64::new(1.0, 0.0) - (-s * settings.tick_s).exp()) / (s * settings.tick_s);
    let master = master_system(&settings.master, &settings.arm, ControlTiming::Continuous).expect("a master");
    let states = master.states();
    let position = DMatrix::from_fn(1, states, |_, j| f64::from(u8::from(j == 0)));
    let none = DMatrix::zeros(1, master.inputs());
    let master: StateSpace<Continuous> =
        StateSpace::continuous(master.a().clone(), master.b().clone(), position, none).expect("a system");
    let slave = slave_system(&settings.slave, ControlTiming::Continuous).expect("a slave");
    let of_master = master.evaluate(s).expect("a response")[(0, 2)];
    [-of_master * hold, slave.evaluate(s).expect("a response")[(0, 0)] * hold]
}

fn tables(settings: &LinearLoop, (low, high): (f64, f64), rows: usize) -> [FrequencyResponse; 2] {
    [0, 1].map(|side| {
        let row = |k: usize| {
            let hertz = low * (high / low).powf(k as f64 / (rows - 1) as f64);
            let response = responses(settings, hertz)[side];
            [hertz, response.norm(), response.arg()]
        };
        FrequencyResponse::new((0..rows).map(row)).expect("a response")
    })
}

fn limit_of_model(settings: &LinearLoop) -> f64 {
    let limit = largest_stable(settings, Parameter::ForceScale, Search::of(Parameter::ForceScale)).expect("found");
    limit.largest().expect("stable")
}

#[test]
fn oracle_tables_of_either_side_give_the_limits_of_the_model() {
    for further in [&[][..], &["tissue.stiffness_n_per_m=200", "scaling.position=0.5"], &["arm.grip=firm"]] {
        let settings = settings(further);
        let expected = limit_of_model(&settings);
        let [master, slave] = tables(&settings, (0.1, 400.0), 400);
        for sides in [
            MeasuredSides { master: Some(master.clone()), slave: None },
            MeasuredSides { master: None, slave: Some(slave.clone()) },
            MeasuredSides { master: Some(master), slave: Some(slave) },
        ] {
            let measured = MeasuredLoop::of(&settings, &sides).expect("a loop");
            let (factor, hertz) = measured.limit.expect("a limit");
            let found = factor * settings.get(Parameter::ForceScale);
            assert!((found / expected - 1.0).abs() < 2e-3, "{further:?}: {found} {expected}");
            let margins = ClosedLoop::new(&settings).expect("a loop").margins().expect("margins");
            assert_eq!(measured.verdict == MeasuredVerdict::Stable, expected > settings.get(Parameter::ForceScale));
            if let Some(expected_hz) = margins.gain_frequency_hz.filter(|_| measured.verdict == MeasuredVerdict::Stable)
            {
                assert!((hertz / expected_hz - 1.0).abs() < 2e-3, "{further:?}: {hertz} {expected_hz}");
                let (phase, ..) = measured.phase.unwrap_or((f64::NAN, 0.0, 0.0));
                let same = margins
                    .phase_rad
                    .filter(|phase| phase.is_finite())
                    .is_none_or(|expected| (phase - expected).abs() < 5e-3);
                assert!(same, "{further:?}: {phase} {margins:?}");
            }
        }
    }
}

#[test]
fn a_scale_beyond_the_limit_is_unstable_and_a_short_table_is_open() {
    let base = settings(&[]);
    let limit = limit_of_model(&base);
    let verdict = |factor: f64, range: (f64, f64)| {
        let settings = base.with(Parameter::ForceScale, factor * limit);
        let [_, slave] = tables(&base, range, 300);
        let measured = MeasuredLoop::of(&settings, &MeasuredSides { master: None, slave: Some(slave) });
        measured.expect("a loop").verdict
    };
    assert_eq!(verdict(0.95, (0.1, 400.0)), MeasuredVerdict::Stable);
    assert_eq!(verdict(1.05, (0.1, 400.0)), MeasuredVerdict::Unstable);
    // Below the frequency of the limit the loop gain is still above 1.
    assert_eq!(verdict(1.05, (0.1, 1.0)), MeasuredVerdict::Open);
}

#[test]
fn what_cannot_be_analysed_is_refused_with_its_reason() {
    let base = settings(&[]);
    let [master, _] = tables(&base, (0.1, 100.0), 50);
    let refused = |settings: &LinearLoop, sides: MeasuredSides| {
        MeasuredLoop::of(settings, &sides).expect_err("refused").to_string()
    };
    assert!(refused(&base, MeasuredSides::default()).contains("no table"));
    let coupled = settings(&["controller.kind=position-position"]);
    let sides = MeasuredSides { master: Some(master.clone()), slave: None };
    assert!(refused(&coupled, sides).contains("position-force"));
    let [_, above] = tables(&base, (200.0, 400.0), 50);
    let sides = MeasuredSides { master: Some(master), slave: Some(above) };
    assert!(refused(&base, sides).contains("no common range"));
}

#[test]
fn the_command_prints_margins_limits_and_what_the_table_leaves_open() {
    let folder = TestFolder::new();
    let base = settings(&[]);
    let mut table = String::from("frequency_hz,magnitude_db,phase_deg\n");
    for k in 0..200 {
        let hertz = 0.1 * 2000.0_f64.powf(f64::from(k) / 199.0);
        let [_, slave] = responses(&base, hertz);
        writeln!(table, "{hertz},{},{}", 20.0 * slave.norm().log10(), slave.arg().to_degrees()).expect("a string");
    }
    folder.file("slave.csv", &table);
    let mut arguments = vec!["stability", "passivity/late-wall", "--x", "scaling.force=0.1:10:20"];
    arguments.extend(["--y", "tissue.stiffness_n_per_m=10:2000:20", "--slave-response", "slave.csv"]);
    arguments.extend(BASE.iter().flat_map(|setting| ["--set", *setting]));
    let printed = folder.said(&arguments);
    for phrase in
        ["With the measured responses, known from 0.1000 to 200.0 Hz", "limit of the force scale is", "Left open"]
    {
        assert!(printed.contains(phrase), "{phrase}: {printed}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&folder.text("out/late-wall/stability.json")).expect("a document");
    let found = json["measured"]["largest_force_scale"].as_f64().expect("a limit");
    assert!((found / limit_of_model(&base) - 1.0).abs() < 2e-3, "{found}");
    assert!(folder.path("out/late-wall/measured_loop_gain.csv").exists());

    folder.file("bad.csv", "frequency_hz,magnitude,phase_deg\n1,1,0\n0.5,1,0\n2,1,0\n");
    folder.refused(
        &["stability", "--slave-response", "bad.csv"],
        &["bad.csv line 3, column 'frequency_hz': 0.5 Hz after 1 Hz", "sort the rows"],
    );
    folder.refused(&["stability", "--slave-response", "missing.csv"], &["missing.csv"]);
}
