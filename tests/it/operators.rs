//! Human operators in the loop: reaction times, tremor and grips in whole runs, with both engines.

use crate::support::scenario;
use trocar::engine::Trace;
use trocar::run::run;

fn trace(name: &str, settings: &[&str]) -> Trace {
    run(scenario(name, settings)).expect("runs").trace
}

/// Returns the first tick from `from` on at which the desired position stops, and the number of ticks of the stop.
fn pause(trace: &Trace, from: usize) -> (usize, usize) {
    let desired = &trace.desired_position_m;
    let stands = |k: &usize| desired[*k + 1] == desired[*k];
    let start = (from..desired.len() - 1).find(stands).expect("a pause");
    (start, (start..desired.len() - 1).take_while(stands).count())
}

#[test]
fn the_operator_stops_150_to_250_ms_after_the_rupture_of_the_skin_for_half_a_second() {
    for seed in 1..=20 {
        let run = run(scenario("hand/reflex", &[&format!("simulation.seed={seed}")])).expect("runs");
        let rupture = (run.metrics.ruptures[0].time_s * 1e3).round() as usize;
        let (start, length) = pause(&run.trace, rupture);
        // The operator detects the drop of the felt force some ticks after the rupture.
        assert!((rupture + 150..=rupture + 275).contains(&start), "seed {seed}: {start} after {rupture}");
        assert_eq!(length, 500, "seed {seed}");
    }
}

#[test]
fn the_reaction_agrees_with_the_integrated_engine() {
    let settings = ["simulation.duration_s=2.5"];
    let exact = trace("hand/reflex", &settings);
    let integrated = trace("hand/reflex", &[settings[0], "simulation.engine=dop853"]);
    let (a, b) = (pause(&exact, 1000), pause(&integrated, 1000));
    assert!(a.0.abs_diff(b.0) <= 1 && a.1 == b.1, "{a:?} {b:?}");
}

#[test]
fn the_desired_position_never_jumps() {
    for name in ["hand/reflex", "hand/trembling-hand"] {
        for reflex in ["perception.reflex=stop", "perception.reflex=withdraw"] {
            let trace = trace(name, &[reflex]);
            let steps = trace.desired_position_m.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            // The maximum speed is 15/8 of the mean speed; tremor and withdrawal add some tens of mm/s.
            assert!(steps.fold(0.0, f64::max) < 2e-4, "{name} {reflex}");
        }
    }
}

#[test]
fn without_a_reflex_there_is_no_reaction_and_without_tremor_no_tremor() {
    let still = trace("layers/through-the-skin", &["simulation.seed=1"]);
    let other = trace("layers/through-the-skin", &["simulation.seed=2"]);
    assert_eq!(still.desired_position_m, other.desired_position_m);
    let trembling = |seed: &str| trace("layers/through-the-skin", &["operator.tremor_amplitude_m=1e-4", seed]);
    let (one, two) = (trembling("simulation.seed=1"), trembling("simulation.seed=2"));
    assert_ne!(one.desired_position_m, two.desired_position_m);
    let difference = one.desired_position_m.iter().zip(&still.desired_position_m).map(|(a, b)| a - b);
    let squares: Vec<f64> = difference.skip(500).map(|d| d * d).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((rms - 1e-4).abs() < 1e-5, "{rms}");
}

#[test]
fn grip_and_reflexes_determine_the_stiffness_of_a_hand_at_rest() {
    let settings = [
        "operator.kind=ramp",
        "operator.speed_m_per_s=0.02",
        "tissue.kind=kelvin-voigt",
        "tissue.stiffness_n_per_m=200",
        "simulation.duration_s=5",
    ];
    let final_m = |setting: &str, engine: &str| {
        let trace = trace("classical", &[&settings[..], &[setting, engine]].concat());
        let tail = &trace.slave_position_m[trace.slave_position_m.len() - 200..];
        assert!(tail.iter().all(|x| (x - tail[0]).abs() < 1e-6), "{setting} has come to rest");
        tail[0]
    };
    // At rest the spring of the hand, k_a k_h / (k_a + k_h), and the tissue are in series. The long-latency reflex adds
    // its gain to the hand's stiffness; the short-latency reflex responds to speed only.
    let hand = 733.0 * 14998.0 / (733.0 + 14998.0);
    let in_series = |hand: f64| 0.02 * hand / (hand + 200.0);
    for engine in ["simulation.engine=exact", "simulation.engine=dop853"] {
        for (setting, hand) in [
            ("arm.grip=relaxed", 0.5 * hand),
            ("arm.grip=paper", hand),
            ("arm.grip=firm", 2.0 * hand),
            ("operator.stretch_long_gain_n_per_m=150", hand + 150.0),
            ("operator.stretch_short_gain_n_s_per_m=15", hand),
        ] {
            let found = final_m(setting, engine);
            assert!((found - in_series(hand)).abs() < 1e-6, "{engine} {setting}: {found}");
        }
        let stiff = final_m("operator.stiffening_per_n=0.1", engine);
        // x = F/200 and F = hand (1 + 0.1 F) (0.02 - x), solved for x.
        let of = |x: f64| 200.0 * x - hand * (1.0 + 0.1 * 200.0 * x) * (0.02 - x);
        assert!(of(stiff - 1e-6) < 0.0 && of(stiff + 1e-6) > 0.0, "{engine}: {stiff}");
    }
}

#[test]
fn reflexes_reduce_the_overshoot_and_act_within_a_tenth_of_a_second() {
    let plain = run(scenario("hand/reflex", &["perception.reflex=none"])).expect("runs");
    let settings = ["perception.reflex=none", "operator.stretch_short_gain_n_s_per_m=20"];
    let tense = run(scenario("hand/reflex", &settings)).expect("runs");
    let lurch_m = |run: &trocar::run::Run| {
        let tick = (run.metrics.ruptures[0].time_s * 1e3).round() as usize;
        run.trace.master_position_m[tick + 100] - run.trace.master_position_m[tick]
    };
    assert!(lurch_m(&tense) < 0.9 * lurch_m(&plain), "{} {}", lurch_m(&tense), lurch_m(&plain));
    let gentle = "operator.stiffening_per_n=0.05";
    let firm = run(scenario("hand/reflex", &["perception.reflex=none", gentle])).expect("runs");
    assert!(firm.metrics.ruptures[0].time_s < plain.metrics.ruptures[0].time_s, "a stiffer arm gets there earlier");
}
