//! Warnings: which are given, with which place, and when there are none.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value as Json;
use trocar::engine::{Observer, Signals};
use trocar::metrics::{MissReason, Outcome};
use trocar::run::{Run, RunReport, observe, run};
use trocar::scenario::{Scenario, Source, shipped_questions};
use trocar::stability::{left_out, loop_limits};
use trocar::warning::Code;

use crate::support::scenario;
use crate::support::test_folder::TestFolder;

fn codes(run: &Run) -> Vec<Code> {
    RunReport::of(run).warnings().iter().map(|warning| warning.code).collect()
}

fn codes_of(name: &str, settings: &[&str]) -> Vec<Code> {
    codes(&run(scenario(name, settings)).expect("runs"))
}

#[test]
fn an_oscillation_that_does_not_decay_is_an_outcome() {
    let wall = run(scenario("passivity/late-wall", &[])).expect("runs");
    let Outcome::Oscillating { frequency_hz, swing_m } = wall.metrics.outcome else {
        panic!("{:?}", wall.metrics.outcome)
    };
    // Measure the amplitude at the end in the trace.
    let last = &wall.trace.slave_position_m[wall.trace.len() * 9 / 10..];
    let (low, high) = last.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    assert!((swing_m - (high - low)).abs() < 0.1 * (high - low), "{swing_m} {low} {high}");
    assert!((3.0..3.7).contains(&frequency_hz), "{frequency_hz}");
    for scheme in ["time-domain", "waves", "tank"] {
        assert!(codes_of(&format!("passivity/late-wall-{scheme}"), &[]).is_empty(), "{scheme}");
    }
    // Following an oscillating hand is no oscillation of the loop.
    let sine =
        ["operator.kind=sine", "operator.frequency_hz=2", "tissue.kind=kelvin-voigt", "simulation.duration_s=10"];
    assert_eq!(run(scenario("hand/reflex", &sine)).expect("runs").metrics.outcome, Outcome::Completed);
    let trembling = ["operator.tremor_amplitude_m=3e-4", "perception.reflex=none", "tissue.kind=kelvin-voigt"];
    assert_eq!(run(scenario("hand/reflex", &trembling)).expect("runs").metrics.outcome, Outcome::Completed);
}

#[test]
fn an_oscillation_in_noise_is_distinguished_from_the_effect_of_the_noise() {
    let outcome = |settings: &str| {
        let all = format!("simulation.duration_s=60 augmentation.enabled=true {settings}");
        run(scenario("hand/reflex", &all.split(' ').collect::<Vec<_>>())).expect("runs").metrics.outcome
    };
    // The noise and its false alarms synchronise this limit cycle, so a displaced hand is forgotten.
    let late = "simulation.tick_s=0.002 simulation.seed=647 scaling.force=1.9 scaling.position=1.96 \
                channel.forward_delay_s=0.0536 channel.backward_delay_s=0.1617 operator.kind=minimum-jerk \
                operator.end_m=0.0077 operator.movement_s=0.53 perception.reflex=none tissue.kind=kelvin-voigt \
                tissue.stiffness_n_per_m=1337 tissue.damping_n_s_per_m=3.489 detector.threshold=2.5e-2";
    let swing_m = match outcome(late) {
        Outcome::Oscillating { swing_m, .. } => swing_m,
        other => panic!("{other:?}"),
    };
    assert!(swing_m > 0.05, "{swing_m}");
    // Here the same noise moves the needle by two thirds as much without augmentation, and a displaced hand shifts
    // the alarms.
    let noisy = "simulation.seed=540 scaling.force=1.7855 scaling.position=0.4796 channel.forward_delay_s=0.005 \
                 channel.backward_delay_s=0.0015 operator.kind=ramp operator.end_m=0.0078 \
                 operator.speed_m_per_s=0.0402 perception.reflex=withdraw tissue.kind=hunt-crossley \
                 sensor.force_noise_std_n=0.0083 arm.grip=relaxed augmentation.reengage=clutch \
                 detector.threshold=3.3611512958631232e-3";
    assert_eq!(outcome(noisy), Outcome::Completed);
}

/// Returns the outcome of a scenario in a spring and damper, from its text.
fn outcome_of(text: &str) -> Outcome {
    let text = format!("base = \"paper/classical\"\ntissue.kind = \"kelvin-voigt\"\n{text}");
    let source = Source::Text { name: "swing".into(), text: text.clone().into() };
    let scenario = Scenario::load(&source, &[]).unwrap_or_else(|error| panic!("{text}: {error}"));
    run(scenario).expect("runs").metrics.outcome
}

/// Returns the frequency (Hz) and the amplitude (m) of a sustained oscillation.
fn sustained(text: &str) -> (f64, f64) {
    match outcome_of(text) {
        Outcome::Oscillating { frequency_hz, swing_m } => (frequency_hz, swing_m),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn an_oscillation_that_repeats_with_the_ticks_is_sustained() {
    // A displaced copy of these runs returns to the same cycle.
    for scale in [18.0, 18.5] {
        let text = format!(
            "operator = {{ kind = \"minimum-jerk\", end_m = 0.02 }}\nscaling.force = {scale}\nsimulation.duration_s = 6\n"
        );
        let (frequency_hz, swing_m) = sustained(&text);
        assert!((frequency_hz - 20.4).abs() < 0.2 && (0.015..0.02).contains(&swing_m), "{frequency_hz} {swing_m}");
    }
    let lossy = "operator = { kind = \"minimum-jerk\", end_m = 0.01 }
        tissue.stiffness_n_per_m = 2000
        tissue.damping_n_s_per_m = 0
        channel = { delay_s = \"3ms\", loss = 0.5 }
        simulation.duration_s = 10";
    assert!(sustained(lossy).1 > 2e-3);
}

#[test]
fn an_oscillation_that_starts_late_is_slow_saturates_or_alternates_with_the_ticks_is_sustained() {
    // The needle reaches the tissue 0.8 s before the end.
    let late = "operator = { kind = \"ramp\", start_m = -0.054, end_m = 0.02 }
        scaling.force = 20
        simulation.duration_s = 6.2";
    assert!((sustained(late).0 - 20.3).abs() < 0.5);
    // One and a half periods in the whole run.
    let slow = "operator.kind = \"minimum-jerk\"
        tissue.stiffness_n_per_m = 300
        scaling.force = 8
        channel.delay_s = 1
        simulation.duration_s = 6";
    assert!((0.2..0.3).contains(&sustained(slow).0));
    let saturating = "operator = { kind = \"minimum-jerk\", end_m = 0.01 }
        tissue.stiffness_n_per_m = 2000
        scaling.force = 20
        actuator.master_force_limit_n = 8
        simulation = { control = \"sampled\", tick_s = 0.01, duration_s = 4 }";
    assert!(sustained(saturating).1 > 2e-3);
    let alternating = "operator = { kind = \"minimum-jerk\", end_m = 0.01 }
        controller = { kind = \"local-force\", master_force_gain = 60 }
        actuator.master_force_limit_n = 20
        simulation = { control = \"sampled\", tick_s = 0.005, duration_s = 4 }";
    assert!((95.0..=100.0).contains(&sustained(alternating).0), "two samples per swing");
}

#[test]
fn motion_caused_by_hand_noise_and_breathing_is_not_an_oscillation_of_the_loop() {
    // Three quarters of the stable force scale.
    let forced = "operator = { kind = \"sine\", start_m = 0.012, amplitude_m = 0.006, frequency_hz = 6, tremor_amplitude_m = 2e-4 }
        scaling.force = 12
        sensor.force_noise_std_n = 0.1
        tissue.breathing_amplitude_m = 0.003
        tissue.breathing_period_s = 1
        simulation.duration_s = 6";
    assert_eq!(outcome_of(forced), Outcome::Completed);
    // An oscillation that still decays at the end of a short run.
    let ringing = "operator = { kind = \"minimum-jerk\", end_m = 0.02, movement_s = 0.2 }
        scaling.force = 15
        simulation.duration_s = 1";
    assert_eq!(outcome_of(ringing), Outcome::Completed);
}

#[test]
fn an_active_loop_and_a_delay_longer_than_the_run_give_warnings() {
    assert!(codes_of("passivity/late-wall", &[]).contains(&Code::ActiveLoop));
    let late = ["channel.forward_delay_s=30"];
    assert!(codes_of("paper/classical", &late).contains(&Code::DelayBeyondRun));
    assert!(!codes_of("paper/classical", &["channel.forward_delay_s=3"]).contains(&Code::DelayBeyondRun));
}

fn removal(reason: &MissReason, threshold: &mut f64) -> String {
    match reason {
        MissReason::NotInContact { .. } => "estimator.contact_m=-1000".into(),
        MissReason::NotArmed { .. } => "detector.settle_s=0".into(),
        MissReason::NoDrop => "detector.drop_only=false".into(),
        MissReason::WrongMotion { .. } => "detector.motion=any".into(),
        MissReason::TooShallow { .. } => "detector.minimum_depth_m=0".into(),
        MissReason::BelowThreshold { reached } => {
            *threshold *= 0.9 * reached;
            format!("detector.threshold={threshold:e}")
        }
        MissReason::BelowDrift { largest } => format!("detector.drift={:e}", 0.5 * largest),
        MissReason::EventUnderWay { .. } | MissReason::Refractory { .. } | MissReason::EarlierEvent => {
            "augmentation.enabled=false".into()
        }
        MissReason::AfterAlarm { .. } => "detector.threshold=7".into(),
        MissReason::AlarmOfAnother { .. } => "detector.settle_s=0".into(),
        MissReason::NotReady { .. } | MissReason::NoFall => "detector.distance=squared-residual".into(),
    }
}

/// Returns the times of all alarms, accepted or not, and of the ruptures of a run, in s.
fn alarms_s(scenario: &Scenario) -> (Vec<f64>, Vec<f64>) {
    struct Alarms(f64, Vec<f64>);
    impl Observer<f64> for Alarms {
        fn observe(&mut self, s: &Signals<f64>) {
            if s.alarm {
                self.1.push(s.tick as f64 * self.0);
            }
        }
    }
    let mut alarms = Alarms(scenario.grid.tick_s(), vec![]);
    let metrics = observe(scenario, &mut alarms).expect("runs");
    (alarms.1, metrics.ruptures.iter().map(|rupture| rupture.time_s).collect())
}

#[test]
fn every_missed_rupture_has_a_reason_and_removing_it_detects_the_rupture() {
    let settings = |k: u64| -> Vec<String> {
        let mut random = ChaCha8Rng::seed_from_u64(k);
        let drawn: Vec<u64> = (0..16).map(|_| random.random()).collect();
        let draw = |n: usize, m: u64| drawn[n] % m;
        let mut all = vec![
            format!("detector.threshold={:e}", [2e-3, 2e-2, 0.3, 2.0][draw(1, 4) as usize]),
            format!("detector.settle_s={}", [0.05, 0.1, 0.5, 2.0][draw(2, 4) as usize]),
            format!("detector.motion={}", ["inserting", "not-withdrawn", "any"][draw(3, 3) as usize]),
            format!("detector.minimum_depth_m={}", [0.0, 0.0, 0.012][draw(4, 3) as usize]),
            format!("estimator.contact_m={}", [0.0, 0.0, 0.02][draw(5, 3) as usize]),
            format!("sensor.force_noise_std_n={}", [0.0, 0.02, 0.06][draw(6, 3) as usize]),
            format!("augmentation.enabled={}", draw(7, 2) == 0),
            format!("tissue.layer.skin.rupture_force_n={}", 1.5 + draw(8, 8) as f64 * 0.5),
            format!("operator.movement_s={}", [1.0, 3.0, 6.0][draw(9, 3) as usize]),
            format!("simulation.seed={}", k + 1),
        ];
        if draw(10, 5) == 0 {
            all.push("detector.insertion_speed_m_per_s=0.05".into());
            all[2] = "detector.motion=inserting".into();
        }
        all
    };
    let shipped = shipped_questions().map(|(name, _)| (format!("builtin:{name}"), vec![]));
    let random = (0..500).map(|k| ("hand/fast-stab".to_owned(), settings(k)));
    let cases: Vec<(String, Vec<String>)> = shipped.chain(random).collect();
    let of_case = |(name, settings): &(String, Vec<String>)| {
        let scenario = |more: Option<String>| {
            let all: Vec<String> = settings.iter().cloned().chain(more).collect();
            Scenario::load(&Source::parse(name), &all).unwrap_or_else(|error| panic!("{all:?}: {error}"))
        };
        let first = run(scenario(None)).expect("runs");
        let explained = first.metrics.ruptures.iter().filter(|rupture| rupture.miss.is_some()).count() as u64;
        assert_eq!(explained, first.metrics.missed_ruptures, "{name} {settings:?}");
        let threshold = first.scenario.detector.cusum.threshold;
        let mut removed = vec![];
        for (index, rupture) in first.metrics.ruptures.iter().enumerate() {
            let Some(miss) = &rupture.miss else { continue };
            let mut threshold = threshold;
            let changes: Vec<String> = miss.reasons().map(|reason| removal(reason, &mut threshold)).collect();
            // The speed of a changed motion has no effect.
            let acts = |setting: &&String| {
                !setting.contains("insertion_speed") || !changes.contains(&"detector.motion=any".to_owned())
            };
            let all: Vec<String> = settings.iter().filter(acts).cloned().chain(changes.clone()).collect();
            let (alarms_s, ruptures_s) = alarms_s(&Scenario::load(&Source::parse(name), &all).expect("loads"));
            let is_detection =
                |alarm_s: &f64| ruptures_s.get(index).is_some_and(|at| (-1e-9..0.5 + 1e-9).contains(&(alarm_s - at)));
            removed.push((alarms_s.iter().any(is_detection), format!("{name} {settings:?}: {miss:?}")));
        }
        removed
    };
    use rayon::prelude::*;
    let all: Vec<(bool, String)> = cases.par_iter().flat_map(of_case).collect();
    let failed: Vec<&String> = all.iter().filter(|(detected, _)| !detected).map(|(_, what)| what).collect();
    assert!(all.len() > 200, "{}", all.len());
    let share = 1.0 - failed.len() as f64 / all.len() as f64;
    assert!(share >= 0.95, "{share} of {}: {:#?}", all.len(), &failed[..failed.len().min(15)]);
}

#[test]
fn a_key_without_effect_is_an_error_unless_the_kind_was_changed_later() {
    let folder = TestFolder::new();
    folder.file("inert.toml", "base = \"layers/skin-augmented\"\n[tissue]\nstiffness_n_per_m = 900\n");
    folder.refused(&["check", "inert.toml"], &["tissue.stiffness_n_per_m has no effect", "inert.toml:3", "layers"]);
    let given =
        ["run", "hand/reflex", "--set", "tissue.kind=kelvin-voigt", "--set", "tissue.layer.skin.rupture_force_n=2"];
    folder.refused(&given, &["tissue.layer.skin.rupture_force_n has no effect"]);
    // This file is not responsible for the base's layers.
    folder.file("base.toml", "base = \"hand/reflex\"\n[tissue]\nlayer.skin.rupture_force_n = 2\n");
    folder.file("good.toml", "base = \"base.toml\"\n[tissue]\nkind = \"kelvin-voigt\"\n");
    folder.good(&["check", "good.toml"]);
    // A setting for several scenarios may have an effect in only one of them.
    let hold = ["--set", "augmentation.min_hold_s=0.2"];
    folder.refused(
        &[&["check", "paper/classical"], &hold[..]].concat(),
        &["augmentation.min_hold_s has no effect: it acts for augmentation.enabled = true, which is false here"],
    );
    folder.good(&[&["compare", "paper/classical", "paper/augmented"], &hold[..]].concat());
    // A choice that has no effect itself.
    let presliding = "base = \"hand/reflex\"\n[tissue]\nindex = \"depth\"\npresliding_m = 0.001\n";
    folder.file("replay.toml", presliding);
    folder.refused(&["check", "replay.toml"], &["tissue.index has no effect", "tissue.presliding_m has no effect"]);
    folder.file(
        "both.toml",
        "base = \"hand/reflex\"\nmetrics = [\"tissue_energy_j\"]\n[axes]\naugmentation.enabled = [false, true]\n\
         augmentation.catch_up_speed_m_per_s = [0.01, 0.03]\n",
    );
    folder.good(&["check", "both.toml"]);
    folder.file(
        "sweep.toml",
        "base = \"hand/reflex\"\nmetrics = [\"operator_energy_j\"]\n[axes]\ntissue.stiffness_n_per_m = [100.0, 200.0]\n",
    );
    folder.refused(&["sweep", "sweep.toml"], &["axes.tissue.stiffness_n_per_m has no effect", "sweep.toml:4"]);
    let set = |kinds: &str| {
        format!(
            "base = \"hand/reflex\"\nmetrics = [\"operator_energy_j\"]\n[set]\ntissue.stiffness_n_per_m = 300.0\n[axes]\n{kinds}"
        )
    };
    folder.file("set.toml", set("scaling.force = [1.0, 1.1]\n"));
    folder.refused(&["sweep", "set.toml"], &["tissue.stiffness_n_per_m has no effect", "set.toml:4"]);
    let given = ["sweep", "sweep.toml", "--set", "tissue.stiffness_n_per_m=300"];
    folder.file(
        "sweep.toml",
        "base = \"hand/reflex\"\nmetrics = [\"operator_energy_j\"]\n[axes]\nscaling.force = [1.0, 1.1]\n",
    );
    folder.refused(&given, &["tissue.stiffness_n_per_m has no effect"]);
    folder.file("kinds.toml", set("tissue.kind = [\"layers\", \"kelvin-voigt\"]\n"));
    folder.good(&["sweep", "kinds.toml"]);
}

/// Returns the results of `stability` for a scenario: the loop, the events, and the warnings.
fn verdict(folder: &TestFolder, scenario: &str, settings: &[&str]) -> (Json, Json, String) {
    let mut arguments = vec!["stability", scenario, "--json", "--x", "scaling.force=0.5:2:2"];
    arguments.extend(["--y", "scaling.position=0.5:2:2"]);
    arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    let outcome = folder.trocar(&arguments);
    assert_eq!(outcome.code, 0, "{}", outcome.err);
    let json: Json = serde_json::from_str(&outcome.out).expect("JSON");
    (json["is_stable"].clone(), json["switching"]["is_certified"].clone(), outcome.err)
}

#[test]
fn a_verdict_is_unknown_if_a_part_is_left_out() {
    let folder = TestFolder::new();
    for left_out in [
        "channel.loss=0.3",
        "channel.jitter_s=0.1",
        "sensor.position_resolution_m=1e-5",
        "passivity.scheme=energy-tank",
    ] {
        let (stable, certified, said) = verdict(&folder, "paper/augmented", &[left_out]);
        assert_eq!((&stable, &certified), (&Json::Null, &Json::Null), "{left_out}");
        let key = left_out.split('=').next().expect("a key");
        assert!(said.contains("warning[unmodelled]") && said.contains(key), "{left_out}: {said}");
    }
}

#[test]
fn a_verdict_covers_delays_limits_and_tissue_or_is_unknown() {
    let folder = TestFolder::new();
    folder.file("delays.csv", "time_s,forward_delay_s,backward_delay_s\n0,0.15,0.15\n1,0.15,0.15\n2,0.15,0.15\n");
    folder.file("varying.csv", "time_s,forward_delay_s,backward_delay_s\n0,0.15,0.15\n1,0.05,0.15\n2,0.15,0.15\n");
    let of = |scenario: &str, settings: &[&str]| verdict(&folder, scenario, settings);
    let wall = "passivity/late-wall";
    let constant = of(wall, &["channel.forward_delay_s=0.15", "channel.backward_delay_s=0.15"]).0;
    assert_eq!(constant, Json::Bool(false));
    let none = ["channel.forward_delay_s=0", "channel.backward_delay_s=0"];
    let with = |file| [&none[..], &[file]].concat();
    assert_eq!(of(wall, &with("channel.delays_file=delays.csv")).0, constant, "a constant delay is a delay");
    assert_eq!(of(wall, &with("channel.delays_file=varying.csv")).0, Json::Null);
    let limited = ["simulation.control=sampled", "actuator.slave_command_rate_limit_per_s=50"];
    assert_eq!(of("paper/augmented", &limited).0, Json::Null);
    // Ruptures, friction and relaxation are an additional force, and so is a force recorded over time.
    for scenario in ["layers/skin-augmented", "paper/augmented"] {
        assert_eq!(of(scenario, &[]), (Json::Bool(true), Json::Bool(true), String::new()), "{scenario}");
    }
    // A range that leaves out the stiffest layer does not cover the tissue.
    let narrow = ["stability", "layers/skin-augmented", "--tissue", "0:500", "--x", "scaling.force=0.5:2:2"];
    let narrow = folder.trocar(&[&narrow[..], &["--y", "scaling.position=0.5:2:2", "--json"]].concat());
    let json: Json = serde_json::from_str(&narrow.out).expect("JSON");
    let found = (&json["certificate"]["statement"], &json["switching"]["is_certified"]);
    assert_eq!(found, (&Json::from("none"), &Json::Null));
    assert!(narrow.err.contains("warning[tissue-not-covered]"), "{}", narrow.err);
    let spring = ["tissue.kind=kelvin-voigt", "tissue.stiffness_n_per_m=300", "operator.kind=minimum-jerk"];
    assert_eq!(of("paper/augmented", &spring), (Json::Bool(true), Json::Bool(true), String::new()));
}

#[test]
fn a_limit_that_the_loop_never_reaches_is_not_reported_as_left_out() {
    let spring = ["tissue.kind=kelvin-voigt", "tissue.stiffness_n_per_m=300", "simulation.control=sampled"];
    let insertion = ["operator.kind=minimum-jerk", "simulation.duration_s=4"];
    let limits = [
        "actuator.master_force_limit_n",
        "actuator.master_force_rate_limit_n_per_s",
        "actuator.slave_command_limit",
        "actuator.slave_command_rate_limit_per_s",
        "sensor.force_range_n",
    ];
    let with = |factor: f64, bounds: &[f64], more: &[&str]| {
        let given: Vec<String> =
            limits.iter().zip(bounds).map(|(key, bound)| format!("{key}={:?}", factor * bound)).collect();
        let all = spring.into_iter().chain(insertion).chain(given.iter().map(String::as_str));
        scenario("paper/classical", &all.chain(more.iter().copied()).collect::<Vec<_>>())
    };
    let bounds = |more: &[&str]| -> Vec<f64> {
        let of = loop_limits(&with(1.0, &[1.0; 5], more));
        of.iter().map(|limit| limit.part.bound.unwrap_or_else(|| panic!("{more:?}"))).collect()
    };
    for more in
        [&[][..], &["channel.forward_delay_s=0.01", "channel.backward_delay_s=0.01"], &["master.force_integral_gain=2"]]
    {
        let largest = bounds(more);
        assert_eq!(left_out(&with(1.001, &largest, more), None), vec![], "above the bounds");
        assert_eq!(left_out(&with(0.999, &largest, more), None).len(), 5, "below them");
        // A limit above the bound changes nothing, whatever the hand does. A limit at a third of the bound has an
        // effect for some hand.
        let hands = ["operator.kind=ramp", "operator.kind=insertion-extraction", "operator.kind=minimum-jerk"];
        let mut acts = false;
        for hand in hands {
            let more = [more, &[hand]].concat();
            let of_hand = bounds(&more);
            let trace = |scenario: Scenario| run(scenario).expect("a run").trace.slave_position_m;
            let free = trace(with(1e6, &of_hand, &more));
            assert!(trace(with(1.001, &of_hand, &more)) == free, "{more:?}");
            acts |= trace(with(0.3, &of_hand, &more)) != free;
        }
        assert!(acts, "{more:?}");
    }
    // A loop that is not stable has no bound.
    assert!(loop_limits(&with(1.0, &[1e6; 5], &["scaling.force=100"])).iter().all(|limit| limit.part.bound.is_none()));
    // Noise has no bound; events, jitter and reflexes do not belong to a linear loop.
    let others = ["augmentation.enabled=true", "channel.jitter_s=0.002", "perception.reflex=stop"];
    for more in ["sensor.force_noise_std_n=0.01"].into_iter().chain(others) {
        assert!(loop_limits(&with(1.0, &[1e6; 5], &[more])).iter().all(|limit| limit.part.bound.is_none()), "{more}");
    }
}

#[test]
fn warnings_are_in_every_answer_and_can_be_errors() {
    let folder = TestFolder::new();
    let outcome = folder.trocar(&["run", "sensing/wrong-detector-settings", "--json"]);
    let json: Json = serde_json::from_str(&outcome.out).expect("JSON");
    assert_eq!(json["warnings"][0]["code"], "missed-rupture");
    assert_eq!(json["warnings"][0]["place"], "detector.drift");
    assert_eq!(json["metrics"]["ruptures"][0]["miss"]["reason"], "below-drift");
    assert!(outcome.err.starts_with("warning[missed-rupture]: wrong-detector-settings: rupture 1 at 5.520 s"));
    let denied = folder.trocar(&["run", "sensing/wrong-detector-settings", "--deny-warnings"]);
    assert!(denied.code == 1 && denied.err.contains("--deny-warnings"), "{}", denied.err);
    assert_eq!(folder.trocar(&["run", "paper/classical", "--deny-warnings"]).code, 0);
    let two = folder.trocar(&["run", "paper/classical", "paper/augmented", "--json"]).out;
    let two: Json = serde_json::from_str(&two).expect("one JSON document");
    assert_eq!(two.as_array().map(Vec::len), Some(2));
    for code in Code::ALL {
        let explained = folder.trocar(&["explain", code.word()]).out;
        assert!(explained.contains(code.word()) && explained.lines().count() > 3, "{explained}");
    }
    let explain = |word: &str| folder.trocar(&["explain", word]);
    assert!(explain("detector.threshold").out.contains("Threshold"));
    assert!(explain("rupture_2_detection_delay_s").out.contains("rupture 1: detection delay"));
    let unknown = explain("missed-ruptur");
    assert!(unknown.code == 2 && unknown.err.contains("did you mean missed-rupture?"), "{}", unknown.err);
}

#[test]
fn seeds_without_noise_give_a_warning() {
    let folder = TestFolder::new();
    let said = |arguments: &[&str]| folder.warned(arguments);
    assert!(said(&["compare", "--seeds", "3"]).contains("warning[seeds-without-effect]"));
    let noisy = said(&["compare", "--seeds", "3", "--set", "sensor.force_noise_std_n=0.02"]);
    assert!(!noisy.contains("seeds-without-effect"), "{noisy}");
    let sweep = |noise: &str| {
        format!(
            "base = \"paper/classical\"\nseeds = 3\nmetrics = [\"false_alarms\"]\n[set]\nsensor.force_noise_std_n = {noise}\n[axes]\nscaling.force = [1.0, 1.1]\n"
        )
    };
    folder.file("quiet.toml", sweep("0.0")).file("noisy.toml", sweep("0.02"));
    let quiet = said(&["sweep", "quiet.toml"]);
    assert!(quiet.contains("warning[unchanged-metrics]"), "{quiet}");
    assert!(quiet.contains("warning[seeds-without-effect]") && quiet.contains("6 cases"), "{quiet}");
    let summary = folder.text("out/quiet/summary.json");
    assert!(summary.contains("\"seeds-without-effect\""), "{summary}");
    assert!(!said(&["sweep", "noisy.toml"]).contains("seeds-without-effect"));
    folder.file("quiet.toml", sweep("0.01"));
    folder.refused(&["sweep", "quiet.toml"], &["force_noise_std_n"]);
    said(&["sweep", "quiet.toml", "--overwrite"]);
}

#[test]
fn metrics_that_no_case_changes_give_a_warning() {
    let folder = TestFolder::new();
    let sweep = "base = \"paper/classical\"\nmetrics = [\"false_alarms\", \"operator_energy_j\"]\n[axes]\n\"scaling.force\" = [1.0, 1.1]\n";
    let output = folder.file("two.toml", sweep).said(&["sweep", "two.toml", "--deny-warnings"]);
    assert!(output.contains("The same in every case: false alarms. "), "{output}");
    folder.file("none.toml", sweep.replace(", \"operator_energy_j\"", ""));
    let outcome = folder.trocar(&["sweep", "none.toml", "--json", "--deny-warnings"]);
    let answer: serde_json::Value = serde_json::from_str(&outcome.out).expect("JSON");
    assert_eq!((outcome.code, answer["warnings"][0]["code"].as_str()), (1, Some("unchanged-metrics")));
}

#[test]
fn a_common_delay_sets_the_delays_of_both_directions() {
    let of = |settings: &[&str]| {
        let scenario = scenario("link/long-delay", settings);
        (scenario.forward, scenario.backward)
    };
    let two = of(&["channel.forward_delay_s=0.02", "channel.backward_delay_s=0.02"]);
    assert_eq!(of(&["channel.delay_s=0.02"]), two, "it replaces those of the file");
    let uneven = of(&["channel.delay_s=0.02", "channel.forward_delay_s=0.03"]);
    assert_eq!(uneven, of(&["channel.forward_delay_s=0.03", "channel.backward_delay_s=0.02"]));
    let folder = TestFolder::new();
    folder.file(
        "s.toml",
        "base = \"link/long-delay\"\nmetrics = [\"operator_energy_j\"]\n[axes]\nchannel.delay_s = [0.0, 0.02]\n",
    );
    let case = |number| folder.trocar(&["sweep", "s.toml", "--case", number]).out;
    let echoed = folder.file("case.toml", case("1")).path("case.toml");
    let echoed = scenario(&echoed.to_string_lossy(), &[]);
    assert_eq!((echoed.forward, echoed.backward), two);
    let outcome = folder.trocar(&["sweep", "s.toml"]);
    assert!(outcome.code == 0 && !outcome.out.contains("same in every case"), "{}{}", outcome.out, outcome.err);
}
