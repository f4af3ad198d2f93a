//! The metrics of the intended motion agree with their definitions, applied to whole traces.

use crate::support::scenario;
use trocar::metrics::{HORIZON_S, Metrics};
use trocar::run::{Run, run};

fn ran(name: &str, settings: &[&str]) -> Run {
    run(scenario(name, settings)).expect("a run")
}

/// Computes the excess, the advance and the unintended cut after each rupture from a trace. Without tremor the
/// desired position is the intended one.
fn by_definition(run: &Run) -> Vec<Option<[f64; 3]>> {
    let (trace, scale) = (&run.trace, run.scenario.position_scale());
    let ticks: Vec<usize> =
        run.metrics.ruptures.iter().map(|rupture| (rupture.time_s * 1e3).round() as usize).collect();
    let of = |index: usize| {
        let from = ticks[index];
        let horizon = from + (HORIZON_S * 1e3) as usize;
        let to = ticks.get(index + 1).copied().unwrap_or(horizon).min(horizon);
        let needle = |tick: usize| trace.slave_position_m[tick] - trace.slave_position_m[from];
        let meant = |tick: usize| scale * (trace.desired_position_m[tick] - trace.desired_position_m[from]);
        let max = |of: &dyn Fn(usize) -> f64| (from..=to).map(of).fold(f64::NEG_INFINITY, f64::max);
        (to < trace.len()).then(|| {
            let cut_m = (max(&needle) - max(&meant)).max(0.0);
            [max(&|tick| needle(tick) - meant(tick)).max(0.0), needle(to), cut_m]
        })
    };
    (0..ticks.len()).map(of).collect()
}

#[test]
fn excess_advance_and_cut_agree_with_their_definitions() {
    for name in ["layers/through-the-skin", "layers/skin-augmented", "strategies/clutch", "hand/reflex-augmented"] {
        let run = ran(name, &[]);
        assert!(!run.metrics.ruptures.is_empty(), "{name}");
        for (rupture, expected) in run.metrics.ruptures.iter().zip(by_definition(&run)) {
            let metrics = [rupture.excess_advance_m, rupture.horizon_advance_m, rupture.unintended_cut_m];
            for (metric, expected) in metrics.into_iter().zip(expected.map_or([None; 3], |all| all.map(Some))) {
                match (metric, expected) {
                    (Some(metric), Some(expected)) => assert!((metric - expected).abs() < 1e-12, "{name}: {rupture:?}"),
                    (metric, expected) => assert_eq!(metric, expected, "{name}: {rupture:?}"),
                }
            }
        }
        let (trace, scale) = (&run.trace, run.scenario.position_scale());
        let deepest = trace.desired_position_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let last = trace.desired_position_m.iter().rposition(|&x| x == deepest).expect("a tick");
        let excess_m = trace.slave_position_m[last] - scale * trace.desired_position_m[last];
        assert!((run.metrics.final_excess_m.expect("known") - excess_m).abs() < 1e-12, "{name}");
    }
}

#[test]
fn the_depth_at_return_is_measured_when_teleoperation_resumes() {
    let run = ran("layers/skin-augmented", &[]);
    let modes = &run.trace.mode;
    for rupture in &run.metrics.ruptures {
        let from = (rupture.time_s * 1e3).round() as usize;
        let begun = (from..modes.len()).find(|&tick| modes[tick] != 0).expect("an event");
        let back = (begun..modes.len()).find(|&tick| modes[tick] == 0).expect("a return");
        let depth_m = run.trace.slave_position_m[back] - run.trace.slave_position_m[from];
        assert_eq!(rupture.depth_at_return_m, Some(depth_m));
    }
    let classical = ran("layers/through-the-skin", &[]);
    assert!(classical.metrics.ruptures.iter().all(|rupture| rupture.depth_at_return_m.is_none()));
}

#[test]
fn a_recorded_hand_has_no_known_intention() {
    let run = ran("paper/augmented", &[]);
    assert_eq!(run.metrics.ruptures.len(), 2);
    for rupture in &run.metrics.ruptures {
        assert_eq!((rupture.excess_advance_m, rupture.unintended_cut_m, rupture.noticed), (None, None, None));
        assert!(rupture.horizon_advance_m.is_some() && rupture.depth_at_return_m.is_some());
    }
    assert_eq!((run.metrics.final_excess_m, run.metrics.false_notices), (None, None));
}

#[test]
fn a_false_alarm_costs_time_force_and_depth() {
    let read = |metrics: &Metrics, key: &str| trocar::metrics::RunMetric::named(key).expect("a metric").read(metrics);
    let keys = ["false_alarm_event_s", "false_alarm_force_n", "false_alarm_excess_m"];
    let without = ran("layers/skin-augmented", &[]).metrics;
    assert!(keys.iter().all(|key| read(&without, key).is_none()));
    let with = ran("layers/skin-augmented", &["augmentation.events_s=[1.0]"]);
    let event = &with.metrics.events[0];
    assert_eq!((event.start_s, event.is_false, with.metrics.events[1].is_false), (1.0, 1, 0));
    let delay_s = event.augmented_s.expect("released") + event.reengaging_s.expect("returned");
    assert_eq!(read(&with.metrics, keys[0]), Some(delay_s));
    let force = &with.trace.feedback_force_n[1000..1000 + (delay_s * 1e3).round() as usize];
    let change_n = force.iter().map(|force_n| (force_n - force[0]).abs()).fold(0.0, f64::max);
    assert_eq!(read(&with.metrics, keys[1]), Some(change_n));
    assert!(change_n > 1.0 && read(&with.metrics, keys[2]).is_some());
}
