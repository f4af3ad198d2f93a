//! The limits over a population agree with the eigenvalues of its members' matrices.

use crate::support;
use std::f64::consts::SQRT_2;

use crate::support::test_folder::TestFolder;
use trocar::lti::eigenvalues;
use trocar::population::{Draw, PopulationSettings};
use trocar::scenario::{Scenario, Source};
use trocar::stability::{Axis, ClosedLoop, LIMITED, LinearLoop, Parameter, Population, Spacing};

const EVERYTHING: [&str; 4] =
    ["population.size=24", "population.arm=people", "population.tissue=log-normal", "population.delay=uniform"];

fn scenario(settings: &[&str]) -> Scenario {
    support::scenario("passivity/late-wall", settings)
}

fn axes() -> (Axis, Axis) {
    let axis = |parameter, low, high| Axis { parameter, low, high, count: 9, spacing: Spacing::Logarithmic };
    (axis(Parameter::ForceScale, 0.2, 5.0), axis(Parameter::Stiffness, 100.0, 4000.0))
}

/// Returns the loop of a member, by the keys of its scenario.
fn of_member(settings: &LinearLoop, draw: &Draw) -> LinearLoop {
    let arm = [Parameter::ArmKa, Parameter::ArmBa, Parameter::ArmKh, Parameter::ArmBh, Parameter::ArmMass];
    let tissue = [(Parameter::Stiffness, draw.stiffness), (Parameter::Damping, draw.damping)];
    let factors = arm.into_iter().zip(draw.arm).chain(tissue);
    let changed = factors.fold(settings.clone(), |settings, (parameter, factor)| {
        settings.with(parameter, factor * settings.get(parameter))
    });
    draw.delay_s.map_or(changed.clone(), |delay_s| changed.with(Parameter::Delay, delay_s))
}

fn spectral_radius(settings: &LinearLoop) -> f64 {
    let (matrix, ..) = ClosedLoop::new(settings).expect("built").matrix().expect("not too long");
    eigenvalues(&matrix).expect("computed").iter().fold(0.0, |max: f64, value| max.max(value.norm()))
}

#[test]
fn oracle_at_the_limits_of_members_an_eigenvalue_leaves_the_unit_circle() {
    let scenario = scenario(&EVERYTHING);
    let settings = support::linear_loop(&scenario);
    let (x, y) = axes();
    let population = Population::of(&settings, &scenario.population, scenario.seed, (&x, &y)).expect("analysed");
    assert_eq!(population.members.len(), 24);
    let (mut stable, mut without_limit) = (0, 0);
    for (index, member) in population.members.iter().enumerate() {
        assert_eq!(member.draw, scenario.population.drawn(scenario.seed, index as u64));
        let of_member = of_member(&settings, &member.draw);
        assert_eq!(member.is_stable, spectral_radius(&of_member) < 1.0);
        stable += usize::from(member.is_stable);
        for (parameter, limit) in LIMITED.into_iter().zip(member.limits) {
            if parameter == Parameter::Delay && limit.is_infinite() {
                let closed = ClosedLoop::new(&of_member.with(parameter, 0.0)).expect("built");
                let angles = (1..2000).map(|k| std::f64::consts::PI * (f64::from(k) / 2000.0).powi(3));
                let gain = angles.map(|angle| closed.loop_gain(1.0, angle).norm()).fold(0.0, f64::max);
                assert!(gain < 1.0, "a delay would matter: {gain}");
                without_limit += 1;
                continue;
            }
            assert!(limit.is_finite() && limit > 0.0, "{parameter:?} {limit}");
            for (factor, is_stable) in [(1.0 - 1e-5, true), (1.0 + 1e-5, false)] {
                let radius = spectral_radius(&of_member.with(parameter, factor * limit));
                assert_eq!(radius < 1.0, is_stable, "{parameter:?} {limit} {factor} {radius}");
            }
        }
    }
    assert!(without_limit < 12, "{without_limit}");
    assert!(stable > 0 && stable < 24 && population.stable_share.0 == stable as f64 / 24.0);
    let of_stiffness = |limits: [f64; 4]| limits[2];
    let mut limits: Vec<f64> = population.members.iter().map(|member| of_stiffness(member.limits)).collect();
    limits.sort_by(f64::total_cmp);
    assert_eq!(population.limits[2].quantiles[2].value, limits[11], "the median");
    assert!(population.worst.stiffness_n_per_m <= limits[0]);
}

#[test]
fn oracle_the_fraction_at_a_point_agrees_with_the_eigenvalues() {
    let scenario = scenario(&EVERYTHING);
    let settings = support::linear_loop(&scenario);
    let (x, y) = axes();
    let few = PopulationSettings { size: 6, ..scenario.population };
    let population = Population::of(&settings, &few, scenario.seed, (&x, &y)).expect("analysed");
    for (column, row) in (0..9).flat_map(|column| (0..9).map(move |row| (column, row))) {
        let at_point = |member: &LinearLoop| {
            member.with(Parameter::ForceScale, x.value(column)).with(Parameter::Stiffness, y.value(row))
        };
        let loops = population.members.iter().map(|member| at_point(&of_member(&settings, &member.draw)));
        let stable = loops.filter(|settings| spectral_radius(settings) < 1.0).count();
        assert_eq!(population.map.share(column, row).0, stable as f64 / 6.0, "{column} {row}");
    }
}

#[test]
fn people_with_only_a_firm_grip_have_the_firm_arm() {
    // Without spread between people, the only grip is the firm one.
    let firm =
        ["population.arm=people", "population.grip_min=2", "population.grip_max=2", "population.person_spread=1"];
    let scenario = scenario(&firm);
    let draw = scenario.population.drawn(3, 5);
    assert!(draw.arm.iter().zip([2.0, SQRT_2, 2.0, SQRT_2, 1.0]).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{draw:?}");
    assert_eq!((draw.stiffness, draw.damping, draw.delay_s), (1.0, 1.0, None));
}

#[test]
fn a_section_and_the_flag_give_the_same_files() {
    let folder = TestFolder::new();
    folder.file(
        "a.toml",
        "base = \"builtin:passivity/late-wall.toml\"\nname = \"a\"\n[population]\narm = \"people\"\nsize = 12\n",
    );
    folder.file("b.toml", "base = \"builtin:passivity/late-wall.toml\"\nname = \"b\"\n");
    let axes = ["--x", "scaling.force=0.1:10:6", "--y", "tissue.stiffness_n_per_m=10:2000:5"];
    let printed = folder.good(&[&["stability", "a.toml"][..], &axes].concat());
    folder.good(&[&["stability", "b.toml", "--arms", "12"][..], &axes].concat());
    assert!(printed.contains("population of 12 arms: the loop is stable with"), "{printed}");
    let csv = folder.text("out/a/population.csv");
    assert_eq!(csv.lines().count(), 13);
    assert_eq!(csv, folder.text("out/b/population.csv"));
    assert_eq!(folder.text("out/a/population_map.csv").lines().count(), 31);
    assert!(folder.text("out/a/population.svg").contains("Share of the population"));
    let json: serde_json::Value = serde_json::from_str(&folder.text("out/a/stability.json")).expect("JSON");
    let population = &json["population"];
    assert_eq!(population["size"], 12);
    assert_eq!(population["limits"][2]["parameter"], "tissue.stiffness_n_per_m");
    assert!(population["limits"][2]["quantiles"][2]["value"].as_f64().expect("a number") > 100.0);
    folder.good(&[&["stability", "b.toml", "--out", "alone"][..], &axes].concat());
    assert!(!folder.path("alone/b/population.csv").exists());
}

#[test]
fn exchanged_ends_of_a_range_are_an_error() {
    let error = |settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        Scenario::load(&Source::parse("paper/classical"), &settings).expect_err("refused").to_string()
    };
    let exchanged = error(&["population.arm=people", "population.grip_min=3"]);
    assert!(exchanged.contains("population.grip_max is 2, must be at least population.grip_min"), "{exchanged}");
    let inert = error(&["population.grip_min=0.6"]);
    assert!(inert.contains("population.grip_min has no effect"), "{inert}");
}
