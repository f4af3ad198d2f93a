//! Varying delays: a loop proved stable decays on the engine in every tried order of delays, and a loop that
//! oscillates is not called stable.

use crate::support;
use std::fmt::Write as _;

use crate::support::test_folder::{TestFolder, words};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value as Json;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar::stability::{Analysis, VaryingDelays};

/// A needle that is pushed into a spring and then held.
const BASE: [&str; 8] = [
    "operator.kind=ramp",
    "operator.end_m=0.02",
    "operator.speed_m_per_s=0.05",
    "tissue.kind=kelvin-voigt",
    "tissue.damping_n_s_per_m=1",
    "simulation.duration_s=10",
    "augmentation.enabled=false",
    "passivity.scheme=none",
];

/// Loops with their minimum delay each way, in ticks.
const LOOPS: [(&[&str], u64); 5] = [
    (&["tissue.stiffness_n_per_m=1000"], 10),
    (&["tissue.stiffness_n_per_m=600"], 20),
    (&["tissue.stiffness_n_per_m=1500", "simulation.control=sampled"], 0),
    (&["tissue.stiffness_n_per_m=300", "controller.kind=position-position"], 5),
    (&["tissue.stiffness_n_per_m=300", "controller.kind=local-force"], 3),
];

fn load(settings: &[String]) -> Scenario {
    let all: Vec<String> = BASE.iter().map(|&setting| setting.to_owned()).chain(settings.iter().cloned()).collect();
    Scenario::load(&Source::parse("passivity/late-wall"), &all).expect("loads")
}

fn with_delay(settings: &[&str], least: u64, more: &[String]) -> Vec<String> {
    let delay = format!("channel.delay_s={}", 1e-3 * least as f64);
    settings.iter().map(|&setting| setting.to_owned()).chain([delay]).chain(more.iter().cloned()).collect()
}

/// Writes a file with a row per tick, from the delay of each way in ticks.
fn delays_file(folder: &TestFolder, name: &str, mut delays: impl FnMut(u64) -> [u64; 2]) -> Vec<String> {
    let mut text = "time_s,forward_delay_s,backward_delay_s\n".to_owned();
    for tick in 0..10_000 {
        let [forward, backward] = delays(tick).map(|ticks| 1e-3 * ticks as f64);
        let _ = writeln!(text, "{},{forward},{backward}", 1e-3 * tick as f64);
    }
    folder.file(name, text);
    vec!["channel.delay_s=0".to_owned(), format!("channel.delays_file={}", folder.path(name).display())]
}

/// Returns the slave's peak-to-peak motion in the last second, in m; infinite if the run diverges.
fn last_swing_m(scenario: Scenario) -> f64 {
    let ticks = scenario.grid.ticks() as usize;
    let column = run(scenario).expect("runs").trace.slave_position_m;
    let last = column[column.len().saturating_sub(1000)..].iter();
    let (low, high) = last.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    if column.len() < ticks { f64::INFINITY } else { high - low }
}

/// Returns the proved properties of a scenario.
fn proved(scenario: &Scenario) -> VaryingDelays {
    VaryingDelays::of(scenario, &support::linear_loop(scenario)).expect("computed").expect("delays vary")
}

#[test]
fn a_loop_proved_stable_decays_with_random_and_bang_bang_delays() {
    let folder = TestFolder::new();
    let mut random = ChaCha8Rng::seed_from_u64(24);
    for (settings, least) in LOOPS {
        let constant = support::linear_loop(&load(&with_delay(settings, least, &[])));
        let jitter = Analysis::of(&constant).expect("analysed").jitter_margin_ticks.expect("a margin");
        assert!(jitter >= 4, "{settings:?}: {jitter}");
        let on_top = with_delay(settings, least, &[format!("channel.jitter_s={}", 1e-3 * jitter as f64)]);
        let of_jitter = proved(&load(&on_top));
        assert!(of_jitter.is_proved && !of_jitter.can_be_outage, "{settings:?}");
        assert!(last_swing_m(load(&on_top)) < 1e-7, "{settings:?}: jitter");
        for period in [0, 2 * jitter, 80, 160, 300] {
            let phase = random.random_range(0..=period / 2);
            let late = |tick: u64| if tick % period.max(1) < period / 2 { least + jitter } else { least };
            let mut drawn = || random.random_range(least..=least + jitter);
            let file = delays_file(&folder, "delays.csv", |tick| match period {
                0 => [drawn(), drawn()],
                _ => [late(tick), late(tick + phase)],
            });
            let scenario = load(&settings.iter().map(|&setting| setting.to_owned()).chain(file).collect::<Vec<_>>());
            let of_file = proved(&scenario);
            assert!(of_file.is_proved, "{settings:?} {period}");
            let (range, of_jitter) = (of_file.forward, of_jitter.forward);
            assert!(of_jitter.min_ticks <= range.min_ticks && range.max_ticks <= of_jitter.max_ticks, "{range:?}");
            let swing_m = last_swing_m(scenario);
            assert!(swing_m < 1e-7, "{settings:?} with a period of {period}: {swing_m}");
        }
    }
}

#[test]
fn the_ages_belong_to_the_samples_that_the_receiver_holds() {
    let folder = TestFolder::new();
    folder.file("d.csv", "time_s,forward_delay_s,backward_delay_s\n0,0.005,0.003\n1,,0.003\n1.002,0.006,0.003\n");
    let file = format!("channel.delays_file={}", folder.path("d.csv").display());
    let delays = proved(&load(&["channel.delay_s=0".to_owned(), file, "channel.jitter_s=0.004".to_owned()]));
    let ticks = |way: trocar::stability::DelayRange| (way.min_ticks, way.max_ticks);
    // Two samples are lost and one takes 6 ticks, so the sample before them is held until it is 8 ticks old.
    assert_eq!((ticks(delays.forward), ticks(delays.backward)), ((5, 8 + 4), (3, 3 + 4)));
}

fn stability(folder: &TestFolder, scenario: &str, settings: &[String]) -> (Json, String) {
    let axes = ["--json", "--x", "scaling.force=0.5:2:2", "--y", "scaling.position=0.5:2:2"];
    let set = settings.iter().flat_map(|setting| ["--set", setting]);
    let all: Vec<&str> = ["stability", scenario].into_iter().chain(axes).chain(set).collect();
    let outcome = folder.trocar(&all);
    assert_eq!(outcome.code, 0, "{}", outcome.err);
    (serde_json::from_str(&outcome.out).expect("JSON"), outcome.err)
}

#[test]
fn the_verdict_states_which_delays_it_covers_or_why_it_is_unknown() {
    let folder = TestFolder::new();
    let settings = |more: &[&str]| -> Vec<String> {
        let base = BASE.iter().chain(&["tissue.stiffness_n_per_m=600", "channel.delay_s=0.02"]).chain(more);
        base.map(|&setting| setting.to_owned()).collect()
    };
    let (json, said) = stability(&folder, "passivity/late-wall", &settings(&["channel.jitter_s=0.01"]));
    assert_eq!((&json["is_stable"], said.as_str()), (&Json::Bool(true), ""));
    let of_delays = &json["varying_delays"];
    assert_eq!((&of_delays["is_proved_stable"], &of_delays["can_be_outage"]), (&Json::Bool(true), &Json::Bool(false)));
    assert_eq!(of_delays["forward_ticks"], serde_json::json!([20, 30]));
    let margin = json["margins"]["jitter_ticks"].as_u64().expect("a margin");
    assert!((10..60).contains(&margin), "{margin}");
    let jitter = settings(&["channel.jitter_s=0.01"]);
    let axes = ["--x", "scaling.force=0.5:2:2", "--y", "scaling.position=0.5:2:2"];
    let set: Vec<&str> = jitter.iter().flat_map(|setting| ["--set", setting]).collect();
    let text = folder.said(&[&["stability", "passivity/late-wall"], &axes[..], &set].concat());
    assert!(text.contains("for every order of delays of 20 to 30 ticks to the slave"), "{text}");
    for (more, why) in [
        (&["channel.jitter_s=0.08"][..], "without a proof for every order"),
        (&["channel.jitter_s=0.01", "channel.outage_s=0.01"], "which can count as an outage"),
        (&["channel.jitter_s=0.01", "channel.loss=0.1"], "jitter (channel.jitter_s)"),
    ] {
        let (json, said) = stability(&folder, "passivity/late-wall", &settings(more));
        assert_eq!(json["is_stable"], Json::Null, "{more:?}");
        assert!(words(&said).contains(why), "{more:?}: {said}");
    }
    let events = ["channel.jitter_s=0.002".to_owned()];
    // The proof covers teleoperation, and not the events.
    let (json, _) = stability(&folder, "paper/augmented", &events);
    assert_eq!((&json["is_stable"], &json["switching"]["is_certified"]), (&Json::Bool(true), &Json::Null));
    assert_eq!(json["certificate"]["statement"], Json::from("none"));
}

#[test]
fn oscillating_loops_with_varying_delays_are_not_called_stable() {
    let folder = TestFolder::new();
    let settings: Vec<String> =
        ["tissue.stiffness_n_per_m=1000", "tissue.damping_n_s_per_m=0"].map(str::to_owned).to_vec();
    let file = delays_file(&folder, "delays.csv", |tick| {
        let late = |tick: u64| if tick % 120 < 60 { 10 } else { 52 };
        [late(tick), late(tick + 60)]
    });
    let all = [&settings[..], &file].concat();
    assert!(last_swing_m(load(&all)) > 1e-3);
    assert!(!proved(&load(&all)).is_proved);
    let base = BASE.map(str::to_owned);
    assert_eq!(stability(&folder, "passivity/late-wall", &[&base[..], &all].concat()).0["is_stable"], Json::Null);
}
