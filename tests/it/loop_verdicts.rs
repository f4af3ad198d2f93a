//! The verdict on the linear loop beside runs of the engine: what swings is not stable, and the reason is named.

use crate::support::scenario;
use crate::support::test_folder::TestFolder;
use trocar::metrics::Outcome;
use trocar::run::run;
use trocar::scenario::{Scenario, shipped_questions};
use trocar::stability::{Parameter, Search, largest_stable};
use trocar::stability_check::LoopVerdict;

fn verdict(scenario: &Scenario) -> LoopVerdict {
    LoopVerdict::of(scenario).expect("analysed")
}

/// A recording over depth, drawn back by 1.5 mm and held, as text.
fn drawn_back() -> String {
    let smooth = |u: f64| 10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5);
    let way = |from: f64, to: f64, seconds: u32| {
        let ticks = 1000 * seconds;
        (0..ticks).map(move |k| from + (to - from) * smooth(f64::from(k) / f64::from(ticks)))
    };
    let ways = way(-0.005, 0.034, 6).chain(way(0.034, 0.0325, 1));
    let all = ways.chain(way(0.0325, 0.0325, 8)).chain(way(0.0325, -0.005, 3));
    let rows = all.enumerate().map(|(tick, x)| {
        let force_n = if x <= 0.0 {
            0.0
        } else if tick < 6000 {
            f64::min(200.0 * x, 6.0)
        } else {
            -2.0 * x / 0.034
        };
        format!("{},{x},{force_n}\n", tick as f64 * 1e-3)
    });
    std::iter::once("time_s,position_m,force_n\n".to_owned()).chain(rows).collect()
}

#[test]
fn a_loop_that_swings_when_drawn_back_is_not_stable() {
    let folder = TestFolder::new();
    folder.file("own.csv", drawn_back());
    folder.file(
        "own.toml",
        "name = \"own\"\nbase = \"paper/depth-augmented\"\nsimulation.duration_s = 18.0\nrecording.file = \"own.csv\"\n\
         recording.columns.velocity_m_per_s = \"\"\n\
         recording.ruptures_s = []\noperator.kind = \"recording\"\ntissue.presliding_m = 0.002\n",
    );
    let own = folder.path("own.toml").display().to_string();
    for (name, settings) in [(own.as_str(), vec![]), ("paper/depth-swing", vec![])] {
        let scenario = scenario(name, &settings);
        let verdict = verdict(&scenario);
        assert_eq!(verdict.is_stable(), Some(false), "{name}");
        let range = verdict.range;
        assert!(range.is_stable_advancing && (range.stable_up_to_n_per_m.expect("a stiffness") - 2517.7).abs() < 0.1);
        let sentence = verdict.sentence();
        assert!(sentence.starts_with("stable while the needle advances, 0 to "), "{sentence}");
        assert!(sentence.ends_with("the loop bears 2518 N/m"), "{sentence}");
    }
    // The hand is at rest from 7 s to 15 s.
    let trace = run(scenario(&own, &[])).expect("a run").trace;
    let held = &trace.slave_position_m[12_000..15_000];
    let swing_m = held.iter().copied().fold(f64::MIN, f64::max) - held.iter().copied().fold(f64::MAX, f64::min);
    assert!(swing_m > 3e-3, "{swing_m}");
    let stable = verdict(&scenario("paper/depth-augmented", &[]));
    assert_eq!(stable.is_stable(), Some(true), "{}", stable.sentence());
}

#[test]
fn the_damping_of_a_layer_can_make_the_loop_unstable() {
    let damped = scenario("layers/through-the-skin", &["tissue.layer.skin.damping_s_per_m=100"]);
    let verdict = verdict(&damped);
    assert_eq!(verdict.is_stable(), Some(false));
    assert!(verdict.range.is_stable_with_least_damping);
    assert!(
        verdict.sentence().starts_with("not stable with the damping of the tissue, up to 5"),
        "{}",
        verdict.sentence()
    );
    // The withdrawal is three times slower than this.
    let trace = run(damped).expect("a run").trace;
    assert!(trace.slave_velocity_m_per_s.iter().any(|speed| *speed < -0.2), "the needle is thrown back");
    assert_eq!(crate::loop_verdicts::verdict(&scenario("layers/through-the-skin", &[])).is_stable(), Some(true));
}

#[test]
fn a_limit_of_the_position_scale_computes_the_tissue_anew() {
    let settings = ["tissue.kind=hunt-crossley", "tissue.mu=30000", "augmentation.enabled=false"];
    let base = scenario("layers/through-the-skin", &settings);
    let of_base = verdict(&base);
    let parameter = Parameter::PositionScale;
    let limit = largest_stable(&of_base.settings, parameter, Search::of(parameter)).expect("a limit");
    let largest = limit.largest().expect("a stable scale");
    for (factor, is_stable) in [(0.98, true), (1.02, false)] {
        let scale = format!("scaling.position={}", factor * largest);
        let at = verdict(&scenario("layers/through-the-skin", &[&settings[..], &[&scale]].concat()));
        assert_eq!(at.is_stable(), Some(is_stable), "{scale} of {largest}: {}", at.sentence());
    }
}

#[test]
fn every_shipped_scenario_runs_to_its_end_as_its_verdict_says() {
    let mut unknown = 0;
    for (name, _) in shipped_questions() {
        let name = name.trim_end_matches(".toml");
        let scenario = scenario(name, &[]);
        let verdict = verdict(&scenario);
        unknown += u32::from(verdict.is_stable().is_none());
        let run = run(scenario).expect("a run");
        let outcome = run.metrics.outcome;
        assert_eq!(run.metrics.ticks, run.scenario.grid.ticks(), "{name}: {outcome:?}");
        let swings = matches!(outcome, Outcome::Oscillating { .. });
        assert_eq!(swings, name == "passivity/late-wall", "{name}: {outcome:?}");
        if verdict.is_stable() == Some(true) {
            assert_eq!(outcome, Outcome::Completed, "{name}: {}", verdict.sentence());
        }
    }
    assert!(unknown <= 14, "{unknown}");
}

#[test]
fn a_slave_with_all_states_has_a_verdict() {
    let lags_per_s: [f64; 6] = std::array::from_fn(|k| 400.0 + 50.0 * k as f64);
    let (mut a, mut b) = ([[0.0; 8]; 8], [[0.0; 2]; 8]);
    (a[0][1], a[1][1], a[1][2]) = (1.0, -8.0, 6.3);
    for (k, rate) in lags_per_s.into_iter().enumerate() {
        a[k + 2][k + 2] = -rate;
        if k < 5 {
            a[k + 2][k + 3] = rate;
        }
    }
    (b[7][0], b[1][1]) = (lags_per_s[5], 6.3);
    let settings = [
        "simulation.control=sampled",
        "slave.model=state-space",
        &format!("slave.a={:?}", a.as_flattened()),
        &format!("slave.b={:?}", b.as_flattened()),
        "slave.c=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
        "slave.controller=pid",
        "slave.integral_gain=1",
        "slave.derivative_gain=1",
        "sensor.force_bandwidth_hz=50",
        "tissue.kind=tearing",
    ];
    let verdict = verdict(&scenario("augmented", &settings));
    assert!(verdict.is_stable().is_some(), "{}", verdict.sentence());
}
