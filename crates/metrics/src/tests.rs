//! Tests of the metrics of a run by its timeline.

use super::fixtures::{Insertion, TICK_S, assert_close};
use super::*;
use trocar_core::augmentation::{Mode, Modes};
use trocar_core::time::TickGrid;

/// Returns a run of 2 s with a rupture at 1 s.
fn rupture() -> Insertion {
    rupture_in(2000)
}

fn rupture_in(ticks: u64) -> Insertion {
    Insertion::of_ticks(ticks).rupture_at(1000)
}

/// Returns a run with a rupture at 1 s and an event from 1.01 s, released at 1.4 s and ended at 1.6 s.
fn event() -> Insertion {
    event_in(2000)
}

fn event_in(ticks: u64) -> Insertion {
    rupture_in(ticks).event([1010, 1400, 1600])
}

#[test]
fn an_alarm_detects_the_latest_open_rupture_if_it_has_effect_and_comes_within_a_tenth_of_a_second() {
    let two = || rupture().rupture_at(1050);
    // The force stays at 2 N up to 1.05 s: the rupture is labelled too early, or takes time.
    let falls_late = || {
        let loaded = Insertion::of_ticks(2000).with(|s| s.tissue_force_n = if s.tick <= 1050 { 2.0 } else { 0.5 });
        loaded.at(1000, |s| s.ruptured = true)
    };
    // The timeline; missed and undecided ruptures, false and ignored alarms; and the delays of two ruptures.
    let cases = [
        (rupture(), [1, 0, 0, 0], [None, None]),
        (rupture().alarm_at(999), [1, 0, 1, 0], [None, None]),
        (rupture().alarm_at(1000), [0, 0, 0, 0], [Some(0.0), None]),
        (rupture().alarm_at(1007), [0, 0, 0, 0], [Some(0.007), None]),
        (rupture().alarm_at(1100), [0, 0, 0, 0], [Some(0.1), None]),
        (rupture().alarm_at(1101), [1, 0, 1, 0], [None, None]),
        (rupture().alarm_at(1010).alarm_at(1200), [0, 0, 1, 0], [Some(0.01), None]),
        (rupture().ignored_alarm_at(300).ignored_alarm_at(1007), [1, 0, 0, 2], [None, None]),
        (two().alarm_at(1060), [1, 0, 0, 0], [None, Some(0.01)]),
        (two().alarm_at(1060).alarm_at(1070), [0, 0, 0, 0], [Some(0.07), Some(0.01)]),
        (falls_late().alarm_at(1040), [1, 0, 1, 0], [None, None]),
        (falls_late().alarm_at(1055), [0, 0, 0, 0], [Some(0.055), None]),
        (rupture_in(1100), [0, 1, 0, 0], [None, None]),
        (rupture_in(1101), [1, 0, 0, 0], [None, None]),
    ];
    for (case, (insertion, counts, delays_s)) in cases.into_iter().enumerate() {
        let metrics = insertion.metrics();
        let found = [metrics.missed_ruptures, metrics.undecided_ruptures, metrics.false_alarms, metrics.ignored_alarms];
        assert_eq!(found, counts, "case {case}");
        for (index, delay_s) in delays_s.into_iter().enumerate() {
            let found = metrics.ruptures.get(index).and_then(|rupture| rupture.detection_delay_s);
            assert_close(found, delay_s, &format!("case {case}, rupture {}", index + 1));
        }
    }
    let alarms = [Alarm { time_s: 1.01, matched: true }, Alarm { time_s: 1.2, matched: false }];
    assert_eq!(rupture().alarm_at(1010).alarm_at(1200).metrics().alarms, alarms);
}

#[test]
fn the_motion_after_a_rupture_is_relative_to_the_position_at_its_tick() {
    let moved = || {
        rupture()
            .at(1000, |s| (s.master_position_m, s.master_velocity_m_per_s) = (0.01, -0.04))
            .from(1000, |s| s.slave_position_m = 0.01)
            .at(1100, |s| s.slave_position_m = 0.017)
            .at(1200, |s| s.master_position_m = 0.019)
            .at(1299, |s| s.slave_position_m = 0.014)
            .at(1300, |s| s.slave_position_m = 0.0135)
            .at(1301, |s| s.slave_position_m = 0.0141)
            .from(1501, |s| (s.slave_position_m, s.master_position_m) = (0.03, 0.05))
    };
    moved().expect([
        ("rupture_1_time_s", Some(1.0)),
        ("rupture_1_master_position_m", Some(0.01)),
        ("rupture_1_master_velocity_m_per_s", Some(-0.04)),
        ("rupture_1_slave_overshoot_m", Some(0.007)),
        ("rupture_1_slave_travel_m", Some(0.0035)),
        ("rupture_1_master_travel_m", Some(0.009)),
    ]);
    moved().at(1500, |s| s.slave_position_m = 0.02).expect([("rupture_1_slave_overshoot_m", Some(0.01))]);
    // A needle that moves back has no overshoot and a negative travel.
    let back = rupture_in(4000).from(1000, |s| s.slave_position_m = 0.02 - 1e-5 * s.tick as f64);
    back.expect([
        ("rupture_1_slave_overshoot_m", Some(0.0)),
        ("rupture_1_slave_travel_m", Some(-0.003)),
        ("rupture_1_deepest_advance_m", Some(0.0)),
    ]);
}

#[test]
fn the_deepest_point_covers_two_seconds_or_the_time_to_the_next_rupture() {
    let one = || {
        rupture_in(4000)
            .from(1000, |s| s.slave_position_m = 0.01)
            .at(2900, |s| s.slave_position_m = 0.019)
            .at(3001, |s| s.slave_position_m = 0.03)
    };
    one().expect([("rupture_1_deepest_advance_m", Some(0.009))]);
    one().at(3000, |s| s.slave_position_m = 0.025).expect([("rupture_1_deepest_advance_m", Some(0.015))]);
    let two = rupture_in(4000)
        .rupture_at(1500)
        .from(1000, |s| s.slave_position_m = 0.01)
        .at(1400, |s| s.slave_position_m = 0.012)
        .at(1600, |s| s.slave_position_m = 0.016);
    two.expect([("rupture_1_deepest_advance_m", Some(0.002)), ("rupture_2_deepest_advance_m", Some(0.006))]);
}

#[test]
fn a_force_has_fallen_once_it_is_down_to_a_twentieth_of_its_positive_value_at_the_rupture() {
    let insertion = rupture()
        .at(1000, |s| (s.feedback_force_n, s.operator_force_n) = (4.0, 3.0))
        .from(1040, |s| s.feedback_force_n = 0.21)
        .from(1050, |s| s.feedback_force_n = 0.2)
        .from(1060, |s| s.operator_force_n = 0.15)
        .from(1070, |s| s.operator_force_n = 0.0)
        .from(1200, |s| (s.feedback_force_n, s.operator_force_n) = (4.0, 3.0));
    insertion.expect([("rupture_1_feedback_fall_s", Some(0.05)), ("rupture_1_felt_fall_s", Some(0.06))]);
    let drops_at = |tick| rupture().from(tick, |s| (s.feedback_force_n, s.operator_force_n) = (0.0, 0.0));
    drops_at(1500).expect([("rupture_1_felt_fall_s", Some(0.5))]);
    drops_at(1501).expect([("rupture_1_feedback_fall_s", None), ("rupture_1_felt_fall_s", None)]);
    let pulled = |tick| {
        move |insertion: Insertion| insertion.from(tick, |s| (s.feedback_force_n, s.operator_force_n) = (-1.0, -1.0))
    };
    for without in [pulled(0)(rupture()), pulled(1100)(drops_at(1000))] {
        without.expect([
            ("rupture_1_feedback_fall_s", None),
            ("rupture_1_felt_fall_s", None),
            ("rupture_1_felt_contrast", None),
        ]);
    }
}

#[test]
fn the_felt_force_has_a_largest_rate_and_a_largest_drop() {
    let steps = rupture()
        .from(1050, |s| s.operator_force_n = 1.5)
        .from(1060, |s| s.operator_force_n = 1.9)
        .from(1501, |s| s.operator_force_n = -9.0);
    steps.expect([("rupture_1_peak_force_rate_n_per_s", Some(500.0))]);
    // The contrast is the drop within 300 ms relative to the force at the rupture.
    let dropped = rupture().at(1300, |s| s.operator_force_n = 0.5).at(1301, |s| s.operator_force_n = 0.1);
    dropped.expect([("rupture_1_felt_contrast", Some(0.75))]);
    rupture().at(1100, |s| s.operator_force_n = -1.0).expect([("rupture_1_felt_contrast", Some(1.5))]);
    // The drop is from an earlier peak, and both are within 300 ms.
    let insertion = rupture()
        .from(1000, |s| s.operator_force_n = 3.0)
        .from(1020, |s| s.operator_force_n = 3.5)
        .at(1100, |s| s.operator_force_n = 0.5)
        .from(1101, |s| s.operator_force_n = 1.0)
        .from(1301, |s| s.operator_force_n = 9.0)
        .from(1302, |s| s.operator_force_n = -9.0);
    insertion.expect([("rupture_1_felt_peak_n", Some(3.5)), ("rupture_1_felt_drop_n", Some(3.0))]);
    rupture().from(1010, |s| s.operator_force_n = 4.0).expect([("rupture_1_felt_drop_n", Some(0.0))]);
    let first = rupture().from(1010, |s| s.operator_force_n = 0.5).from(1200, |s| s.operator_force_n = 7.0);
    first.expect([("rupture_1_felt_drop_n", Some(1.5))]);
}

#[test]
fn a_metric_over_a_window_is_undefined_if_the_run_ends_before() {
    for (key, window_ticks) in [
        ("rupture_1_slave_travel_m", 300),
        ("rupture_1_unintended_travel_m", 300),
        ("rupture_1_felt_contrast", 300),
        ("rupture_1_felt_peak_n", 300),
        ("rupture_1_felt_drop_n", 300),
        ("rupture_1_slave_overshoot_m", 500),
        ("rupture_1_master_travel_m", 500),
        ("rupture_1_peak_force_rate_n_per_s", 500),
        ("rupture_1_excess_advance_m", 2000),
        ("rupture_1_horizon_advance_m", 2000),
        ("rupture_1_noticed", 2000),
    ] {
        let is_defined = [0, 1].map(|more| {
            let metrics = rupture_in(1000 + window_ticks + more).by(Some(1.0), true).metrics();
            RunMetric::named(key).expect(key).read(&metrics).is_some()
        });
        assert_eq!(is_defined, [false, true], "{key}");
    }
}

#[test]
fn an_event_runs_from_its_alarm_over_the_release_to_the_return() {
    event().expect([
        ("events", Some(1.0)),
        ("event_1_start_s", Some(1.01)),
        ("event_1_is_false", Some(0.0)),
        ("event_1_augmented_s", Some(0.39)),
        ("event_1_reengaging_s", Some(0.2)),
        ("event_1_master_start_m", Some(0.0101)),
        ("event_1_master_end_m", Some(0.014)),
        ("mode_switches", Some(3.0)),
        ("augmented_s", Some(0.39)),
        ("reengaging_s", Some(0.2)),
        ("teleoperation_s", Some(2.0 - 0.59)),
    ]);
    // An event that is open at the end of the run has no duration and the last master position.
    event_in(1300).expect([
        ("event_1_augmented_s", None),
        ("event_1_reengaging_s", None),
        ("event_1_peak_reengaging_speed_m_per_s", None),
        ("event_1_exit_step_n", None),
        ("event_1_exit_step_allowed_n", None),
        ("event_1_master_end_m", Some(0.01299)),
    ]);
    event_in(1500).expect([("event_1_augmented_s", Some(0.39)), ("event_1_reengaging_s", None)]);
    // A change of mode without an alarm is an event too.
    let without_alarm = Insertion::of_ticks(1000).with(|s| {
        if (300..400).contains(&s.tick) {
            s.mode = Modes::splat(Mode::Augmented);
        }
    });
    without_alarm.expect([
        ("events", Some(1.0)),
        ("false_alarms", Some(0.0)),
        ("mode_switches", Some(2.0)),
        ("augmented_s", Some(0.1)),
        ("teleoperation_s", Some(0.9)),
    ]);
}

#[test]
fn an_event_has_extremes_of_motion_speed_and_force() {
    // The motion is the largest distance from the position at the freeze.
    let held = |tick, place_m| {
        let held = event().from(1010, |s| s.slave_position_m = 0.0101).from(1400, |s| s.slave_position_m = 0.02);
        held.at(tick, move |s| s.slave_position_m = place_m)
    };
    held(1200, 0.0103).at(1100, |s| s.slave_position_m = 0.01).expect([("event_1_frozen_motion_m", Some(2e-4))]);
    held(1100, 0.0095).expect([("event_1_frozen_motion_m", Some(6e-4))]);
    let insertion = event()
        .at(1350, |s| s.slave_velocity_m_per_s = 0.9)
        .at(1450, |s| s.slave_velocity_m_per_s = -0.06)
        .at(1600, |s| s.slave_velocity_m_per_s = 0.9)
        .at(1010, |s| s.feedback_force_n = 1.5)
        .at(1200, |s| s.feedback_force_n = 0.25)
        .at(1500, |s| s.feedback_force_n = 2.5)
        .at(1600, |s| s.feedback_force_n = 9.0);
    insertion.expect([
        ("event_1_peak_reengaging_speed_m_per_s", Some(0.06)),
        ("peak_reengaging_speed_m_per_s", Some(0.06)),
        ("event_1_force_change_n", Some(1.25)),
    ]);
    rupture().expect([("peak_reengaging_speed_m_per_s", None)]);
}

#[test]
fn the_force_steps_of_an_event_are_those_of_the_command_and_the_excess_is_beyond_what_its_law_allows() {
    let insertion = event()
        .from(1010, |s| s.commanded_force_n = 1.25)
        .from(1400, |s| s.commanded_force_n = 1.5)
        .at(1010, |s| s.allowed_force_step_n = 1.0)
        .at(1400, |s| s.allowed_force_step_n = 0.125);
    insertion.expect([
        ("event_1_entry_step_n", Some(0.75)),
        ("event_1_entry_step_allowed_n", Some(1.0)),
        ("event_1_exit_step_n", Some(0.25)),
        ("event_1_exit_step_allowed_n", Some(0.125)),
    ]);
    // The tick of a step of 1 N, what is allowed at tick 1100, and the excess; 900 and 1601 are outside of the event.
    for (tick, allowed_n, excess_n) in
        [(5000, 0.0, 0.0), (1100, 0.25, 0.75), (1010, 0.0, 1.0), (1600, 0.0, 1.0), (900, 0.0, 0.0), (1601, 0.0, 0.0)]
    {
        let jump = event().from(tick, |s| s.commanded_force_n += 1.0);
        let jump = jump.at(1100, move |s| s.allowed_force_step_n = allowed_n);
        jump.expect([("feedback_step_excess_n", Some(excess_n))]);
    }
}

#[test]
fn a_false_event_is_one_whose_alarm_has_no_rupture() {
    let insertion = Insertion::of_ticks(3000)
        .event([500, 600, 700])
        .event([1000, 1200, 1300])
        .rupture_at(2000)
        .event([2010, 2100, 2200])
        .at(550, |s| s.feedback_force_n = 0.5)
        .at(1100, |s| s.feedback_force_n = 1.25)
        .at(2050, |s| s.feedback_force_n = 0.0);
    insertion.expect([
        ("event_1_is_false", Some(1.0)),
        ("event_2_is_false", Some(1.0)),
        ("event_3_is_false", Some(0.0)),
        ("false_alarms", Some(2.0)),
        ("false_alarm_event_s", Some(0.5)),
        ("false_alarm_force_n", Some(1.5)),
        ("events", Some(3.0)),
        ("max_frozen_motion_m", Some(0.00199)),
    ]);
}

#[test]
fn the_return_of_a_rupture_is_that_of_its_event() {
    let insertion = event()
        .from(1010, |s| s.slave_position_m = 0.0101)
        .from(1400, |s| s.slave_position_m = 0.0103)
        .from(1500, |s| s.slave_position_m = 0.0113)
        .from(1600, |s| s.slave_position_m = 0.0143);
    insertion.expect([
        ("rupture_1_return_after_s", Some(0.6)),
        ("rupture_1_return_jump_m", Some(0.004)),
        ("rupture_1_depth_at_return_m", Some(0.0043)),
    ]);
    event_in(1550).expect([("rupture_1_return_jump_m", None)]);
    // The same freeze also holds the needle of a second rupture within the event.
    event().rupture_at(1200).expect([("rupture_2_depth_at_return_m", Some(0.004))]);
    // An event of a false alarm does not count for an earlier rupture.
    for without in [rupture().alarm_at(1010), rupture_in(3000).alarm_at(1010).event([2000, 2100, 2200])] {
        without.expect([
            ("rupture_1_return_after_s", None),
            ("rupture_1_return_jump_m", None),
            ("rupture_1_depth_at_return_m", None),
        ]);
    }
}

#[test]
fn the_mean_residual_and_the_extremes_of_the_tissue_force_are_over_the_run() {
    for ticks in [1, 3, 31, 32, 33, 100, 257] {
        let insertion = Insertion::of_ticks(ticks)
            .with(|s| s.residual_n = if s.tick % 2 == 0 { -0.25 } else { 0.5 })
            .with(|s| s.tissue_force_n = (s.tick as f64 - 50.0) * 0.1);
        let sum: f64 = (0..ticks).map(|tick| if tick % 2 == 0 { 0.25 } else { 0.5 }).sum();
        insertion.expect([
            ("mean_absolute_residual_n", Some(sum / ticks as f64)),
            ("min_tissue_force_n", Some(-5.0)),
            ("max_tissue_force_n", Some((ticks as f64 - 51.0) * 0.1)),
        ]);
    }
}

#[test]
fn the_tracking_error_is_the_root_mean_square_in_teleoperation() {
    let insertion = event().with(|s| {
        // The slave is 0.3 mm behind in a quarter of the ticks. In the event the reference is far away.
        let gap_m = if s.tick % 4 == 0 { 3e-4 } else { 0.0 };
        s.slave_reference_m =
            s.slave_position_m + if s.mode == Modes::splat(Mode::Teleoperation) { gap_m } else { 0.1 };
    });
    let following = (0..2000).filter(|tick| !(1010..1600).contains(tick));
    let squares: f64 = following.clone().map(|tick| if tick % 4 == 0 { 9e-8 } else { 0.0 }).sum();
    insertion.expect([("tracking_rmse_m", Some((squares / following.count() as f64).sqrt()))]);
}

#[test]
fn energies_are_trapezoidal_integrals_of_the_power() {
    let insertion = Insertion::of_ticks(101).with(|s| {
        let t = TICK_S * s.tick as f64;
        (s.operator_force_n, s.master_velocity_m_per_s) = (3.0 * t, 2.0);
        (s.tissue_force_n, s.slave_velocity_m_per_s) = (5.0, 4.0 * t);
    });
    // Linear powers over 0.1 s: ∫ 6 t dt, ∫ 20 t dt.
    insertion.expect([("operator_energy_j", Some(0.03)), ("tissue_energy_j", Some(0.1))]);
}

#[test]
fn the_final_position_and_the_final_error_are_read_at_the_last_tick() {
    for ticks in [1500, 1512, 2000] {
        // Inside an event, after an event, and after quiet ticks.
        let insertion = Insertion::of_ticks(ticks).event([1010, 1400, 1505]);
        let last = 1e-5 * (ticks - 1) as f64;
        insertion
            .with(|s| s.slave_reference_m = 1.25 * s.slave_position_m)
            .expect([("final_slave_position_m", Some(last)), ("final_tracking_error", Some(0.2))]);
    }
    // The error is relative to the reference.
    Insertion::of_ticks(10).with(|s| s.slave_reference_m = 0.0).expect([("final_tracking_error", None)]);
}

#[test]
fn a_run_diverges_when_a_position_or_a_force_leaves_its_bound() {
    let diverges = |edit: fn(&mut trocar_engine::engine::Signals<f64>)| {
        let metrics = Insertion::of_ticks(1000).from(400, edit).metrics();
        (metrics.outcome, metrics.ticks)
    };
    let diverged = (Outcome::Diverged { time_s: 0.4 }, 400);
    assert_eq!(diverges(|s| s.slave_position_m = 1.01), diverged);
    assert_eq!(diverges(|s| s.slave_position_m = -1.01), diverged);
    assert_eq!(diverges(|s| s.master_position_m = f64::NAN), diverged);
    assert_eq!(diverges(|s| s.master_position_m = -1.01), diverged);
    assert_eq!(diverges(|s| s.measured_force_n = 1.1e9), diverged);
    assert_eq!(diverges(|s| s.measured_force_n = f64::NAN), diverged);
    let completed = (Outcome::Completed, 1000);
    assert_eq!(diverges(|s| s.slave_position_m = 1.0), completed);
    assert_eq!(diverges(|s| (s.slave_position_m, s.master_position_m) = (0.9, -0.9)), completed);
    assert_eq!(diverges(|s| s.measured_force_n = -1e9), completed);
}

#[test]
fn a_diverged_run_has_the_metrics_of_the_ticks_before_the_divergence() {
    let until = event_in(1200).by(None, true);
    let diverged = event().by(None, true);
    let diverged = diverged.from(1200, |s| (s.slave_position_m, s.residual_n, s.tissue_force_n) = (7.0, 9.0, 99.0));
    let (until, diverged) = (until.metrics(), diverged.metrics());
    let outcome = Outcome::Diverged { time_s: 1.2 };
    assert_eq!(diverged, Metrics { outcome, ..until });
}

#[test]
fn a_run_without_a_tick_has_no_metrics() {
    let grid = TickGrid::new(1e-3, 1.0).expect("a grid");
    let metrics = MetricsObserver::<f64>::new(grid, 0).metrics(0);
    assert_eq!((metrics.ticks, metrics.outcome), (0, Outcome::Completed));
    let undefined = [
        metrics.mean_absolute_residual_n,
        metrics.min_tissue_force_n,
        metrics.max_tissue_force_n,
        metrics.tracking_rmse_m,
        metrics.final_slave_position_m,
        metrics.final_tracking_error,
        metrics.operator_energy_j,
        metrics.tissue_energy_j,
    ];
    assert_eq!(undefined, [None; 8]);
}

#[test]
fn the_excess_is_the_largest_growth_of_the_gap_to_the_intended_motion() {
    // From the rupture onwards the hand rests, and the needle advances by 5 mm in 0.5 s and then moves back by 2 mm.
    let advance = |tick: u64| 1e-5 * (tick.min(1500) - 1000) as f64 - 1e-5 * (tick.clamp(1500, 1700) - 1500) as f64;
    let insertion = |scale| {
        rupture_in(3500).by(scale, false).from(1000, move |s| {
            s.intended_position_m = 0.01;
            s.slave_position_m = 0.01 + advance(s.tick);
        })
    };
    insertion(Some(1.0)).expect([
        ("rupture_1_excess_advance_m", Some(0.005)),
        ("rupture_1_horizon_advance_m", Some(0.003)),
        ("rupture_1_unintended_cut_m", Some(0.005)),
        ("final_excess_m", Some(0.003)),
    ]);
    insertion(None).expect([
        ("rupture_1_excess_advance_m", None),
        ("rupture_1_unintended_cut_m", None),
        ("rupture_1_horizon_advance_m", Some(0.003)),
    ]);
    // The slave moves by half of the intended motion, which is no excess. After the rupture it moves a fifth more: 2 mm
    // of 10.
    let scaled = rupture_in(3500).by(Some(0.5), false).with(|s| {
        let moved = 1e-5 * s.tick as f64;
        s.intended_position_m = 2.0 * moved;
        s.slave_position_m = moved + 0.2 * (moved.clamp(0.01, 0.02) - 0.01);
    });
    scaled.expect([("rupture_1_excess_advance_m", Some(0.002))]);
    // The hand advances 3 mm and comes back; the needle advances 4 mm and stays. An unintended cut is a depth beyond
    // the largest intended one.
    let insertion = rupture_in(3500).by(Some(1.0), false).from(1000, |s| {
        let moved = 1e-5 * (s.tick - 1000) as f64;
        s.intended_position_m = 0.01 + if moved < 0.003 { moved } else { 0.0 };
        s.slave_position_m = 0.01 + moved.min(0.004);
    });
    insertion
        .expect([("rupture_1_unintended_cut_m", Some(0.004 - 0.00299)), ("rupture_1_excess_advance_m", Some(0.004))]);
}

#[test]
fn the_next_rupture_ends_the_horizon_of_the_one_before() {
    let two = rupture_in(4000).by(Some(1.0), false).rupture_at(1400).from(1000, |s| s.intended_position_m = 0.01);
    two.expect([
        ("rupture_1_horizon_advance_m", Some(0.004)),
        ("rupture_1_excess_advance_m", Some(0.004)),
        ("rupture_2_horizon_advance_m", Some(0.02)),
        ("rupture_2_excess_advance_m", Some(0.02)),
    ]);
}

#[test]
fn the_excess_at_return_is_the_growth_of_the_gap_over_the_event() {
    let known = || event().by(Some(1.0), false);
    let slow = known().from(1010, |s| s.slave_position_m = 0.0101 + 1e-6 * (s.tick - 1010) as f64);
    slow.expect([("event_1_excess_at_return_m", Some(1e-6 * 590.0 - 1e-5 * 590.0))]);
    event().expect([("event_1_excess_at_return_m", None)]);
    let false_event = Insertion::of_ticks(2000).by(Some(1.0), false).event([1010, 1400, 1600]);
    let false_event = false_event.from(1010, |s| s.slave_position_m += 0.001);
    false_event.at(1010, |s| s.slave_position_m -= 0.001).expect([("false_alarm_excess_m", Some(0.001))]);
    // The needle leads the intended motion by 2 mm before and during the event, which is no excess, and by 0.5 mm more
    // at its end.
    let ahead = || known().with(|s| s.slave_position_m += 2e-3);
    ahead().expect([("event_1_excess_at_return_m", Some(0.0))]);
    ahead().from(1600, |s| s.slave_position_m += 5e-4).expect([("event_1_excess_at_return_m", Some(5e-4))]);
}

#[test]
fn the_final_excess_is_the_gap_when_the_intended_position_was_deepest_for_the_last_time() {
    let insertion = Insertion::of_ticks(1000).by(Some(1.0), false).with(|s| {
        s.intended_position_m = 0.01 * [0.2, 1.0, 1.0, 0.6][(s.tick / 250) as usize];
        s.slave_position_m = 1e-5 * s.tick as f64;
    });
    insertion.expect([("final_excess_m", Some(1e-5 * 749.0 - 0.01))]);
    Insertion::of_ticks(100).expect([("final_excess_m", None)]);
}

#[test]
fn a_notice_belongs_to_the_rupture_and_the_event_within_2_s() {
    // The tick of the notice; whether the rupture was noticed, and when; the event; and false notices.
    for (tick, rupture, after_s, event, false_notices) in [
        (900, 0.0, None, 0.0, 1.0),
        (1200, 1.0, Some(0.2), 0.0, 0.0),
        (3000, 1.0, Some(2.0), 1.0, 0.0),
        (3001, 0.0, None, 1.0, 0.0),
        (3500, 0.0, None, 1.0, 0.0),
        (3501, 0.0, None, 0.0, 1.0),
    ] {
        rupture_in(6000).by(None, true).event([1500, 1600, 1700]).noticed_at(tick).expect([
            ("rupture_1_noticed", Some(rupture)),
            ("rupture_1_noticed_after_s", after_s),
            ("event_1_noticed", Some(event)),
            ("false_notices", Some(false_notices)),
        ]);
    }
    // The first of several notices counts.
    let twice = rupture_in(4000).by(None, true).noticed_at(1300).noticed_at(1400);
    twice.expect([("rupture_1_noticed_after_s", Some(0.3)), ("noticed_ruptures", Some(1.0))]);
    // A notice of an operator who withdraws is not false.
    let withdraws =
        Insertion::of_ticks(1000).by(Some(1.0), true).with(|s| s.intended_position_m = -1e-5 * s.tick as f64);
    withdraws.noticed_at(500).expect([("false_notices", Some(0.0))]);
    // An operator who notices nothing has no count of notices.
    event_in(4000).expect([("rupture_1_noticed", None), ("event_1_noticed", None), ("false_notices", None)]);
}

#[test]
fn the_undisturbed_time_excludes_withdrawal_and_2_s_after_ruptures_and_alarms() {
    let run = || Insertion::of_ticks(5000).by(Some(1.0), false);
    // Excluded are the 2 s from the tick after the rupture.
    for (insertion, expected_s) in [
        (run(), 5.0),
        (run().rupture_at(1000), 3.0),
        (run().alarm_at(1000), 3.0),
        (run().rupture_at(1000).alarm_at(2000), 2.0),
        (run().ignored_alarm_at(1000), 5.0),
        (run().from(4000, |s| s.intended_position_m = 0.04 - 1e-5 * s.tick as f64), 4.0),
    ] {
        insertion.expect([("undisturbed_s", Some(expected_s))]);
    }
    Insertion::of_ticks(5000).expect([("undisturbed_s", None)]);
}

#[test]
fn the_unintended_travel_is_the_growth_of_the_gap_in_300_ms() {
    // The slave is at 10 mm at the rupture and at 18 mm 0.3 s later. The intended position advances by 3 mm times its
    // scale.
    for (scale, expected_m) in [(Some(1.0), Some(0.005)), (Some(0.5), Some(0.0065)), (None, None)] {
        let insertion = rupture().by(scale, false).with(|s| s.intended_position_m = 1e-5 * s.tick as f64);
        insertion
            .from(1001, |s| s.slave_position_m = 0.02)
            .at(1300, |s| s.slave_position_m = 0.018)
            .expect([("rupture_1_unintended_travel_m", expected_m)]);
    }
}

/// Several ruptures, alarms and notices, whose maxima belong to different ruptures.
#[test]
fn the_metrics_of_a_run_are_the_extremes_and_sums_of_its_ruptures() {
    let insertion = Insertion::of_ticks(9000)
        .by(Some(1.0), true)
        .rupture_at(1000)
        .alarm_at(1030)
        .rupture_at(4000)
        .alarm_at(4010)
        .noticed_at(4100)
        .with(|s| s.intended_position_m = s.slave_position_m)
        .from(1000, |s| s.slave_position_m += 0.001)
        .at(1000, |s| s.slave_position_m -= 0.001)
        .from(4000, |s| s.slave_position_m += 0.002)
        .at(4000, |s| s.slave_position_m -= 0.002)
        .at(1100, |s| s.operator_force_n = 0.5)
        .at(4100, |s| s.operator_force_n = 1.0);
    insertion.expect([
        ("ruptures", Some(2.0)),
        ("detected_ruptures", Some(2.0)),
        ("max_detection_delay_s", Some(0.03)),
        ("min_felt_contrast", Some(0.5)),
        ("max_slave_overshoot_m", Some(0.007)),
        ("max_slave_travel_m", Some(0.005)),
        ("max_excess_advance_m", Some(0.002)),
        ("unintended_cut_m", Some(0.003)),
        ("noticed_ruptures", Some(1.0)),
        ("rupture_2_time_s", Some(4.0)),
        ("rupture_1_detection_delay_s", Some(0.03)),
        ("teleoperation_s", Some(9.0)),
        ("rupture_3_time_s", None),
        ("event_1_start_s", None),
        ("diverged_s", None),
    ]);
    Insertion::of_ticks(100).from(50, |s| s.slave_position_m = 2.0).expect([("diverged_s", Some(0.05))]);
}

#[test]
fn every_metric_reads_the_field_of_its_name() {
    let mut metrics = event().by(Some(1.0), true).noticed_at(1100).metrics();
    let report = trocar_engine::teleoperation::LinkReport {
        outages: 1,
        longest_outage_ticks: 20.0,
        given_up_tick: Some(30.0),
        master_port_j: 4.0,
        slave_port_j: 5.0,
        generated_j: 6.0,
        promised_j: Some(7.0),
        left_behind_m: 8.0,
        master_dissipated_j: 9.0,
        slave_refused_j: 10.0,
    };
    let grid = TickGrid::new(1e-3, 1.0).expect("a grid");
    metrics.link = Some(LinkMetrics::new(&report, &grid));
    let read = |key: &str| RunMetric::named(key).unwrap_or_else(|| panic!("{key}")).read(&metrics);
    for (key, value) in [
        ("link_outages", 1.0),
        ("link_longest_outage_s", 0.02),
        ("link_given_up_s", 0.03),
        ("link_master_port_energy_j", 4.0),
        ("link_slave_port_energy_j", 5.0),
        ("link_generated_energy_j", 6.0),
        ("link_promised_energy_j", 7.0),
        ("link_left_behind_m", 8.0),
        ("link_master_dissipated_j", 9.0),
        ("link_slave_refused_j", 10.0),
    ] {
        assert_close(read(key), Some(value), key);
    }
    // JSON has the fields by their names.
    let json = serde_json::to_value(&metrics).expect("numbers");
    let mut compared = 0;
    for metric in RunMetric::all() {
        let (name, number) = (metric.declaration().name, metric.number() - 1);
        let owner = match metric.declaration().scope {
            Scope::Run => &json,
            Scope::Rupture => &json["ruptures"][number],
            Scope::Event => &json["events"][number],
            Scope::Link => &json["link"],
            Scope::Port | Scope::Loop | Scope::Noise => continue,
        };
        if let Some(value) = owner.get(name).and_then(serde_json::Value::as_f64) {
            assert_close(metric.read(&metrics), Some(value), name);
            compared += 1;
        }
    }
    assert!(compared > 45, "{compared}");
}

/// Eight runs, each with a unique feature: overlapping ruptures and events, more open ruptures than slots, falling
/// forces, notices, false alarms, and divergences at several times.
#[cfg(target_arch = "x86_64")]
fn eight_insertions() -> [Insertion; 8] {
    let varied = |number: u64| {
        Insertion::of_ticks(6000).with(move |s| {
            let t = TICK_S * s.tick as f64;
            let swing = (t * (7.0 + number as f64)).sin();
            s.slave_position_m = 0.01 * t + 1e-3 * swing;
            s.slave_reference_m = 0.01 * t + 2e-4;
            s.slave_velocity_m_per_s = 0.01 + 7e-3 * (t * 5.0).cos();
            s.master_velocity_m_per_s = 0.01 * (t * 3.0).cos();
            s.residual_n = 0.02 * swing;
            (s.tissue_force_n, s.operator_force_n) = (2.0 + swing, 1.5 + 0.5 * (t * 11.0).sin());
            (s.feedback_force_n, s.commanded_force_n) = (1.0 + 0.2 * swing, 1.0 + 0.3 * swing);
            s.allowed_force_step_n = 1e-3;
        })
    };
    [
        varied(0),
        varied(1).rupture_at(1000).event([1010, 1400, 1600]).by(Some(1.0), true).noticed_at(1100),
        varied(2).rupture_at(1000).rupture_at(1005).rupture_at(1010).rupture_at(1015).rupture_at(1020).rupture_at(1300),
        varied(3).event([500, 900, 1000]).rupture_at(700).rupture_at(2500).alarm_at(2510).by(Some(0.5), false),
        varied(4)
            .rupture_at(1000)
            .event([1010, 1400, 1600])
            .from(1200, |s| s.slave_position_m = 3.0)
            .by(Some(1.0), true),
        varied(5)
            .rupture_at(2000)
            .alarm_at(2100)
            .at(2000, |s| (s.feedback_force_n, s.operator_force_n) = (4.0, 3.0))
            .from(2070, |s| (s.feedback_force_n, s.operator_force_n) = (0.21, 0.16))
            .from(2080, |s| s.feedback_force_n = 0.19)
            .from(2090, |s| s.operator_force_n = 0.14)
            .from(4000, |s| s.measured_force_n = f64::NAN),
        varied(6).by(Some(1.2), true).event([100, 200, 300]).event([3000, 3300, 3301]).noticed_at(50).noticed_at(3100),
        varied(7).ignored_alarm_at(10).rupture_at(5800).event([5900, 7000, 8000]).by(None, true).alarm_at(3),
    ]
}

#[cfg(target_arch = "x86_64")]
fn metrics_side_by_side<L: trocar_core::lane::Lane>(all: &[Insertion; 8]) -> [Metrics; 8] {
    use trocar_engine::engine::Observer as _;
    let ticks = all[0].ticks();
    let grid = TickGrid::new(TICK_S, TICK_S * ticks as f64).expect("a grid");
    let mut observer = MetricsObserver::<L>::new(grid, 4).of_operators(|lane| all[lane].operator());
    for tick in 0..ticks {
        let signals = std::array::from_fn(|lane| all[lane].signals(tick));
        observer.observe(&super::fixtures::side_by_side::<L>(&signals));
        assert!(!observer.is_done(), "some still run");
    }
    std::array::from_fn(|lane| observer.metrics(lane))
}

#[cfg(target_arch = "x86_64")]
#[test]
fn eight_runs_over_lanes_have_the_metrics_of_single_runs() {
    use trocar_engine::engine::InstructionSet;
    use trocar_engine::wide_lanes::{Avx2, Avx512};
    let all = eight_insertions();
    let alone: Vec<Metrics> = all.iter().map(Insertion::metrics).collect();
    // The comparison is meaningful only if the lanes differ.
    assert_eq!(alone.iter().map(|metrics| metrics.ruptures.len()).collect::<Vec<_>>(), [0, 1, 6, 2, 1, 1, 0, 1]);
    assert_eq!(alone.iter().map(|metrics| metrics.events.len()).collect::<Vec<_>>(), [0, 1, 0, 1, 1, 0, 2, 1]);
    assert!(alone[4].outcome != Outcome::Completed && alone[5].outcome != Outcome::Completed);
    if InstructionSet::Avx2.is_available() {
        assert_eq!(metrics_side_by_side::<Avx2>(&all).to_vec(), alone);
    }
    if InstructionSet::Avx512.is_available() {
        assert_eq!(metrics_side_by_side::<Avx512>(&all).to_vec(), alone);
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn eight_runs_end_once_all_have_diverged() {
    use trocar_engine::engine::{InstructionSet, Observer as _};
    use trocar_engine::wide_lanes::Avx2;
    if !InstructionSet::Avx2.is_available() {
        return;
    }
    let all: [Insertion; 8] =
        std::array::from_fn(|lane| Insertion::of_ticks(100).from(10 + lane as u64, |s| s.slave_position_m = 9.0));
    let grid = TickGrid::new(TICK_S, 0.1).expect("a grid");
    let mut observer = MetricsObserver::<Avx2>::new(grid, 0);
    for tick in 0..=17 {
        assert!(!observer.is_done(), "{tick}");
        observer.observe(&super::fixtures::side_by_side(&std::array::from_fn(|lane| all[lane].signals(tick))));
    }
    assert!(observer.is_done());
    let ticks: [u64; 8] = std::array::from_fn(|lane| observer.metrics(lane).ticks);
    assert_eq!(ticks, [10, 11, 12, 13, 14, 15, 16, 17]);
}

#[test]
fn the_key_of_a_metric_ends_with_its_unit() {
    for metric in RunMetric::all() {
        let name = metric.declaration().name;
        let suffix = match metric.declaration().unit {
            Unit::Metre => "_m",
            Unit::MetrePerSecond => "_m_per_s",
            Unit::Second => "_s",
            Unit::Newton => "_n",
            Unit::NewtonPerSecond => "_n_per_s",
            Unit::NewtonPerMetre => "_n_per_m",
            Unit::Joule => "_j",
            Unit::Share | Unit::Number | Unit::Count => "",
        };
        assert!(name.ends_with(suffix), "{name}");
        let has_unit = ["_m", "_s", "_n", "_j"].iter().any(|unit| name.ends_with(unit));
        assert_eq!(has_unit, !suffix.is_empty(), "{name}");
    }
}
