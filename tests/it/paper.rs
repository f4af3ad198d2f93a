//! The paper's statements, the readings of its appendix, and the agreement of the two engines, on the shipped
//! scenarios.

use crate::support;
use crate::support::{difference, scenario};
use trocar::compare::{Comparison, check_in_noise, paper_facts};
use trocar::engine::COLUMNS;
use trocar::metrics::{Metrics, Outcome};
use trocar::run::run;
use trocar::scenario::{Scenario, Source};

fn metrics(name: &str, settings: &[&str]) -> Metrics {
    run(scenario(name, settings)).expect("runs").metrics
}

#[test]
fn paper_every_fact_holds() {
    let comparison = Comparison::of(vec![scenario("classical", &[]), scenario("augmented", &[])]).expect("runs");
    let facts = paper_facts(&comparison).expect("the paper's pair");
    assert_eq!(facts.len(), 14);
    for fact in facts {
        assert!(fact.holds, "{fact:?}");
    }
}

#[test]
fn paper_the_classical_insertion_has_the_stated_properties() {
    let m = metrics("classical", &[]);
    let first = &m.ruptures[0];
    assert!((first.slave_travel_m.expect("ran on") - 9.0e-3).abs() <= 0.5e-3);
    assert!((first.master_position_m - 19.0e-3).abs() <= 0.7e-3);
    for (rupture, label) in m.ruptures.iter().zip([5.52, 8.85]) {
        assert_eq!(rupture.time_s, label);
        assert!(rupture.detection_delay_s.expect("detected") <= 0.010);
    }
    assert_eq!((m.missed_ruptures, m.false_alarms, m.alarms.len()), (0, 0, 2));
    assert!(m.mean_absolute_residual_n.expect("ran") < 0.05);
}

#[test]
fn paper_the_augmented_insertion_has_the_stated_properties() {
    let (c, a) = (metrics("classical", &[]), metrics("augmented", &[]));
    let event = &a.events[0];
    assert!((event.master_start_m - 19.0e-3).abs() <= 0.7e-3 && (event.master_end_m - 28.0e-3).abs() <= 0.7e-3);
    assert!((event.augmented_s.expect("ended") - 0.5).abs() <= 0.05);
    assert!(a.events.iter().all(|event| event.frozen_motion_m <= 1e-4));
    assert!(a.ruptures[0].feedback_fall_s.expect("falls") < c.ruptures[0].feedback_fall_s.expect("falls"));
    assert!(a.feedback_step_excess_n <= 1e-12, "{}", a.feedback_step_excess_n);
    assert_eq!((a.missed_ruptures, a.false_alarms, a.events.len()), (0, 0, 2));
    assert!(a.ruptures[0].slave_overshoot_m.expect("seen") < 0.05 * c.ruptures[0].slave_overshoot_m.expect("seen"));
}

#[test]
fn paper_every_law_and_policy_keeps_its_bounds() {
    for law in ["augmentation.force_law=decay", "augmentation.force_law=amplify"] {
        for reengage in ["ramp", "fade", "when-still", "clutch", "snap"] {
            let reengage = format!("augmentation.reengage={reengage}");
            for freeze in ["augmentation.freeze=measured", "augmentation.freeze=reference"] {
                let m = metrics("augmented", &[law, &reengage, freeze]);
                assert!(m.feedback_step_excess_n <= 1e-12, "{law} {reengage} {freeze}: {}", m.feedback_step_excess_n);
                assert!(m.events.iter().all(|event| event.frozen_motion_m <= 1e-4), "{law} {reengage} {freeze}");
                assert_eq!((m.missed_ruptures, m.outcome), (0, Outcome::Completed), "{law} {reengage} {freeze}");
            }
        }
    }
    let speed = |reengage: &str| {
        let m = metrics("augmented", &[&format!("augmentation.reengage={reengage}")]);
        m.peak_reengaging_speed_m_per_s.expect("re-engaged")
    };
    assert!(speed("snap") > 5.0 * speed("ramp"), "snap moves the needle fast");
}

#[test]
fn paper_the_feedback_force_recomputed_from_the_trace_keeps_its_bound() {
    let (tick_s, time_constant_s, gain, blend_ticks) = (1e-3_f64, 0.03, 2.0, 100.0);
    for (law, is_decay) in [("decay", true), ("amplify", false)] {
        let trace = run(scenario("augmented", &[&format!("augmentation.force_law={law}")])).expect("runs").trace;
        let (fed, measured, mode) = (&trace.feedback_force_n, &trace.measured_force_n, &trace.mode);
        let (mut released, mut augmented_ticks, mut blended_ticks) = (0, 0, 0);
        for k in 1..trace.len() {
            let (step, moved) = ((fed[k] - fed[k - 1]).abs(), (measured[k] - measured[k - 1]).abs());
            let bound = match mode[k] {
                1 => {
                    augmented_ticks += 1;
                    if is_decay { fed[k - 1].abs() * (1.0 - (-tick_s / time_constant_s).exp()) } else { gain * moved }
                }
                2 => {
                    blended_ticks += 1;
                    if mode[k - 1] == 1 {
                        released = k;
                    }
                    let weight = |ticks: f64| {
                        let u = (ticks / blend_ticks).clamp(0.0, 1.0);
                        u * u * (3.0 - 2.0 * u)
                    };
                    let (now, before) = (weight((k - released + 1) as f64), weight((k - released) as f64));
                    now * moved + (now - before) * (measured[k - 1] - fed[released - 1]).abs()
                }
                _ => moved,
            };
            assert!(step <= bound + 1e-12, "{law}, tick {k}, mode {}: {step} beyond {bound}", mode[k]);
        }
        assert!(augmented_ticks >= 1000 && blended_ticks >= 200, "{law}: {augmented_ticks} {blended_ticks}");
    }
}

#[test]
fn paper_detection_works_in_noise_in_which_the_derivative_fails() {
    let seeds = 20;
    let mut separable = 0;
    for seed in 0..seeds {
        for name in ["classical", "augmented"] {
            let check = check_in_noise(&scenario(name, &[&format!("simulation.seed={seed}")])).expect("runs");
            assert_eq!((check.ruptures, check.missed_ruptures, check.false_alarms), (2, 0, 0), "{name}, seed {seed}");
            assert!(check.derivative_missed_ruptures + check.derivative_false_alarms > 0, "{name}, seed {seed}");
            separable += u32::from(check.derivative_exceedances == Some(0));
        }
    }
    // Even the best threshold separates ruptures from noise in at most a quarter of the runs.
    assert!(separable <= 2 * seeds as u32 / 4, "{separable} of {}", 2 * seeds);
}

#[test]
fn paper_master_as_printed_diverges_and_reports_when() {
    let run = run(scenario("classical", &["master.coupling=as-printed"])).expect("a result");
    let Outcome::Diverged { time_s } = run.metrics.outcome else { panic!("{:?}", run.metrics.outcome) };
    assert!(time_s > 0.0 && time_s < 17.0);
    assert_eq!(run.trace.len() as u64, run.metrics.ticks);
    assert!(run.trace.numbers().iter().all(|column| column.iter().all(|value| value.is_finite())));
    // The growth rate equals the pole at +41.961.
    let speeds = &run.trace.master_velocity_m_per_s;
    let (late, last) = (speeds[speeds.len() - 51].abs(), speeds[speeds.len() - 1].abs());
    let rate = (last / late).ln() / 0.05;
    assert!((rate - 41.961).abs() < 0.5, "{rate}");
}

#[test]
fn paper_slave_as_printed_has_its_static_error() {
    let m = metrics("classical", &["slave.damping=as-printed"]);
    assert_eq!(m.outcome, Outcome::Completed);
    // With a constant reference the error is 1 - 1300/1315.
    let still = [
        "slave.damping=as-printed",
        "operator.kind=ramp",
        "operator.end_m=0.01",
        "tissue.kind=kelvin-voigt",
        "tissue.stiffness_n_per_m=0",
        "tissue.damping_n_s_per_m=0",
        "simulation.duration_s=6",
    ];
    let error = metrics("classical", &still).final_tracking_error.expect("a reference");
    assert!((error - 15.0 / 1315.0).abs() < 1e-5, "{error}");
}

#[test]
fn oracle_dop853_agrees_on_the_shipped_scenarios() {
    for name in ["classical", "augmented"] {
        for control in ["continuous", "sampled"] {
            let control = format!("simulation.control={control}");
            let exact = run(scenario(name, &[&control])).expect("runs");
            let integrated = run(scenario(name, &[&control, "simulation.engine=dop853"])).expect("runs");
            assert_eq!(exact.trace.mode, integrated.trace.mode);
            for (column, (a, b)) in COLUMNS.iter().zip(exact.trace.numbers().iter().zip(integrated.trace.numbers())) {
                // The branches of the estimator make its signals sensitive, so only the physical signals are
                // compared.
                if ["stiffness_n_per_m", "damping_n_s_per_m", "residual_n", "distance", "decision"].contains(column) {
                    continue;
                }
                let error = difference(a, b, 1);
                assert!(error < 1e-8, "{name} {control} {column}: {error:e}");
            }
        }
    }
}

#[test]
fn oracle_the_stability_limits_agree_with_the_reference() {
    let table = support::table("tests/reference/stability_limits.csv");
    let columns = ["delay_ticks_each_way", "tissue_damping_n_s_per_m", "largest_stable_stiffness_n_per_m"];
    let [delays, dampings, limits] = columns.map(|name| table[name].iter());
    for ((ticks, damping), limit) in delays.zip(dampings).zip(limits) {
        let delay_s = ticks * 1e-3;
        let growth = |stiffness: f64| {
            let settings = [
                // Use a slow ramp into the tissue and a rest, with little oscillation, so that contact is permanent.
                "operator.kind=ramp".to_owned(),
                "operator.speed_m_per_s=0.005".to_owned(),
                "simulation.duration_s=9".to_owned(),
                "tissue.kind=kelvin-voigt".to_owned(),
                format!("tissue.stiffness_n_per_m={stiffness}"),
                format!("tissue.damping_n_s_per_m={damping}"),
                format!("channel.forward_delay_s={delay_s}"),
                format!("channel.backward_delay_s={delay_s}"),
            ];
            let source = Source::parse("paper/classical");
            let trace = run(Scenario::load(&source, &settings).expect("good")).expect("runs").trace;
            let speed = &trace.master_velocity_m_per_s;
            let power = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>() / part.len() as f64;
            power(&speed[8000..]) / power(&speed[5000..6000])
        };
        assert!(growth(0.99 * limit) < 1.0, "{ticks} ticks, {damping} N·s/m: {} N/m grows", 0.99 * limit);
        assert!(growth(1.01 * limit) > 1.0, "{ticks} ticks, {damping} N·s/m: {} N/m decays", 1.01 * limit);
    }
}

#[test]
fn oracle_hunt_crossley_with_power_one_is_a_spring() {
    let contact = ["operator.kind=minimum-jerk", "operator.movement_s=0.8", "simulation.duration_s=2"];
    let with = |tissue: &[&str]| {
        let settings: Vec<&str> = contact.iter().chain(tissue).copied().collect();
        run(scenario("classical", &settings)).expect("runs").trace
    };
    let spring = with(&["tissue.kind=kelvin-voigt", "tissue.stiffness_n_per_m=300", "tissue.damping_n_s_per_m=0"]);
    let power_one = with(&[
        "tissue.kind=hunt-crossley",
        "tissue.mu=300",
        "tissue.lambda=0",
        "tissue.power=1",
        "tissue.contact_m=0",
    ]);
    assert_eq!(spring, power_one);
    let stiffening = with(&["tissue.kind=hunt-crossley", "tissue.mu=30000", "tissue.lambda=0", "tissue.power=2"]);
    let (depth, force) = (&stiffening.slave_position_m, &stiffening.tissue_force_n);
    let last = depth.len() - 1;
    assert!((force[last] - 3e4 * depth[last] * depth[last]).abs() < 1e-9 && force[last] > 1.0, "{}", force[last]);
}

#[test]
fn a_replay_by_depth_closes_the_loop() {
    let classical = metrics("paper/depth-classical", &[]);
    let augmented = metrics("paper/depth-augmented", &[]);
    for m in [&classical, &augmented] {
        assert_eq!((m.outcome, m.ruptures.len()), (Outcome::Completed, 2));
        assert!(m.ruptures[0].detection_delay_s.expect("announced") <= 0.010);
    }
    let overshoot = |m: &Metrics| m.ruptures[0].slave_overshoot_m.expect("seen");
    assert!(overshoot(&augmented) < 0.05 * overshoot(&classical));
    // The remaining numbers that the book states.
    assert_eq!((classical.missed_ruptures, augmented.missed_ruptures), (0, 1));
    // A frozen needle has a constant tissue force, except while it settles between rupture and alarm.
    let trace = run(scenario("paper/depth-augmented", &[])).expect("runs").trace;
    let frozen: Vec<usize> = (0..trace.len()).filter(|&k| trace.mode[k] == 1).collect();
    let (first, last) = (frozen[100], frozen[450]);
    assert!((trace.tissue_force_n[first] - trace.tissue_force_n[last]).abs() < 0.02, "held");
    assert!(trace.tissue_force_n[first] > 1.0, "in the middle of the drop");
}
