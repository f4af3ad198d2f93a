//! Tests of the metrics of a run by its timeline.

use super::fixtures::{Insertion, TICK_S, assert_close};
use super::*;
use trocar_core::augmentation::{Mode, Modes};

/// Returns a run of 2 s with a rupture at 1 s.
fn rupture() -> Insertion {
    Insertion::of_ticks(2000).rupture_at(1000)
}

fn of_rupture(insertion: &Insertion) -> RuptureMetrics {
    let metrics = insertion.metrics();
    assert_eq!(metrics.ruptures.len(), 1);
    metrics.ruptures[0].clone()
}

#[test]
fn the_detection_delay_runs_from_the_rupture_to_its_alarm() {
    assert_close(of_rupture(&rupture().alarm_at(1007)).detection_delay_s, 0.007);
    assert_close(of_rupture(&rupture().alarm_at(1000)).detection_delay_s, 0.0);
    assert_eq!(of_rupture(&rupture()).detection_delay_s, None);
    assert_eq!(of_rupture(&rupture().ignored_alarm_at(1007)).detection_delay_s, None, "no one acted on it");
    assert_eq!(
        of_rupture(&rupture().alarm_at(999)).detection_delay_s,
        None,
        "an alarm before the rupture is not its own"
    );
}

#[test]
fn an_alarm_within_a_tenth_of_a_second_is_a_detection_and_a_later_one_is_false() {
    let counts = |alarm| {
        let metrics = rupture().alarm_at(alarm).metrics();
        (metrics.missed_ruptures, metrics.false_alarms, metrics.alarms[0].matched)
    };
    assert_eq!(counts(1100), (0, 0, true));
    assert_eq!(counts(1101), (1, 1, false));
    assert_eq!(counts(500), (1, 1, false));
}

#[test]
fn an_alarm_before_the_force_falls_is_false() {
    // The force stays at 2 N up to 1.05 s: the rupture is labelled too early, or takes time.
    let metrics = |alarm| {
        let loaded = Insertion::of_ticks(2000).with(|s| s.tissue_force_n = if s.tick <= 1050 { 2.0 } else { 0.5 });
        loaded.at(1000, |s| s.ruptured = true).alarm_at(alarm).metrics()
    };
    let early = metrics(1040);
    assert_eq!((early.missed_ruptures, early.false_alarms), (1, 1));
    let late = metrics(1055);
    assert_eq!((late.missed_ruptures, late.false_alarms), (0, 0));
    assert_close(late.ruptures[0].detection_delay_s, 0.055);
}

#[test]
fn a_second_alarm_for_the_same_rupture_is_false() {
    let metrics = rupture().alarm_at(1010).alarm_at(1200).metrics();
    assert_eq!((metrics.false_alarms, metrics.missed_ruptures), (1, 0));
    let alarms = [Alarm { time_s: 1.01, matched: true }, Alarm { time_s: 1.2, matched: false }];
    assert_eq!(metrics.alarms, alarms);
}

#[test]
fn an_alarm_after_two_ruptures_belongs_to_the_latest() {
    let metrics = rupture().rupture_at(1050).alarm_at(1060).metrics();
    assert_eq!(metrics.ruptures[0].detection_delay_s, None);
    assert_close(metrics.ruptures[1].detection_delay_s, 0.01);
    let metrics = rupture().rupture_at(1050).alarm_at(1060).alarm_at(1070).metrics();
    assert_close(metrics.ruptures[0].detection_delay_s, 0.07);
    assert_eq!((metrics.missed_ruptures, metrics.false_alarms), (0, 0));
}

#[test]
fn a_rupture_without_an_alarm_is_missed_after_its_window_and_undecided_before() {
    let counts = |ticks| {
        let metrics = Insertion::of_ticks(ticks).rupture_at(1000).metrics();
        (metrics.missed_ruptures, metrics.undecided_ruptures)
    };
    assert_eq!((counts(1100), counts(1101)), ((0, 1), (1, 0)));
    let metrics = Insertion::of_ticks(1200).rupture_at(1000).alarm_at(1100).metrics();
    assert_eq!((metrics.missed_ruptures, metrics.undecided_ruptures), (0, 0));
}

#[test]
fn an_alarm_without_effect_is_counted_as_ignored() {
    let metrics = rupture().ignored_alarm_at(300).ignored_alarm_at(1300).metrics();
    assert_eq!((metrics.ignored_alarms, metrics.false_alarms, metrics.alarms.len()), (2, 0, 0));
}

#[test]
fn the_master_position_and_velocity_are_read_at_the_tick_of_the_rupture() {
    let insertion = rupture().at(1000, |s| (s.master_position_m, s.master_velocity_m_per_s) = (0.123, -0.04));
    let rupture = of_rupture(&insertion);
    assert_eq!((rupture.time_s, rupture.master_position_m, rupture.master_velocity_m_per_s), (1.0, 0.123, -0.04));
}

#[test]
fn the_overshoot_is_the_largest_advance_in_half_a_second_and_the_travel_the_advance_at_300_ms() {
    let insertion = rupture()
        .from(1000, |s| s.slave_position_m = 0.01)
        .at(1100, |s| s.slave_position_m = 0.017)
        .at(1300, |s| s.slave_position_m = 0.0135)
        .at(1299, |s| s.slave_position_m = 0.014)
        .at(1301, |s| s.slave_position_m = 0.0141)
        .at(1501, |s| s.slave_position_m = 0.03);
    let rupture = of_rupture(&insertion);
    assert_close(rupture.slave_overshoot_m, 0.007);
    assert_close(rupture.slave_travel_m, 0.0035);
    let last = of_rupture(&insertion.at(1500, |s| s.slave_position_m = 0.02));
    assert_close(last.slave_overshoot_m, 0.01);
}

#[test]
fn a_needle_that_moves_back_has_no_overshoot_and_a_negative_travel() {
    let rupture = of_rupture(&rupture().from(1000, |s| s.slave_position_m = 0.02 - 1e-5 * s.tick as f64));
    assert_eq!(rupture.slave_overshoot_m, Some(0.0));
    assert_close(rupture.slave_travel_m, -0.003);
}

#[test]
fn the_travel_of_the_master_is_its_largest_advance() {
    let insertion = rupture()
        .from(1000, |s| s.master_position_m = 0.01)
        .at(1200, |s| s.master_position_m = 0.019)
        .from(1501, |s| s.master_position_m = 0.05);
    assert_close(of_rupture(&insertion).master_travel_m, 0.009);
}

#[test]
fn a_force_has_fallen_once_it_is_down_to_a_twentieth_of_its_value_at_the_rupture() {
    let insertion = rupture()
        .at(1000, |s| (s.feedback_force_n, s.operator_force_n) = (4.0, 3.0))
        .from(1040, |s| s.feedback_force_n = 0.21)
        .from(1050, |s| s.feedback_force_n = 0.2)
        .from(1060, |s| s.operator_force_n = 0.15)
        .from(1070, |s| s.operator_force_n = 0.0)
        .from(1200, |s| (s.feedback_force_n, s.operator_force_n) = (4.0, 3.0));
    let rupture = of_rupture(&insertion);
    assert_close(rupture.feedback_fall_s, 0.05);
    assert_close(rupture.felt_fall_s, 0.06);
}

#[test]
fn the_fall_time_is_undefined_for_a_pulling_force_or_without_a_fall_in_half_a_second() {
    let late = of_rupture(&rupture().from(1501, |s| (s.feedback_force_n, s.operator_force_n) = (0.0, 0.0)));
    assert_eq!((late.feedback_fall_s, late.felt_fall_s), (None, None));
    let last = of_rupture(&rupture().from(1500, |s| (s.feedback_force_n, s.operator_force_n) = (0.0, 0.0)));
    assert_close(last.felt_fall_s, 0.5);
    let pulling = of_rupture(&rupture().with(|s| (s.feedback_force_n, s.operator_force_n) = (-1.0, -1.0)));
    assert_eq!((pulling.feedback_fall_s, pulling.felt_fall_s, pulling.felt_contrast), (None, None, None));
}

#[test]
fn a_force_of_zero_at_the_rupture_has_no_fall_time_and_no_contrast() {
    let insertion = rupture()
        .from(1000, |s| (s.feedback_force_n, s.operator_force_n) = (0.0, 0.0))
        .from(1100, |s| (s.feedback_force_n, s.operator_force_n) = (-1.0, -1.0));
    let rupture = of_rupture(&insertion);
    assert_eq!((rupture.feedback_fall_s, rupture.felt_fall_s, rupture.felt_contrast), (None, None, None));
}

#[test]
fn the_peak_rate_is_the_largest_change_of_the_felt_force_per_tick() {
    let insertion = rupture()
        .from(1050, |s| s.operator_force_n = 1.5)
        .from(1060, |s| s.operator_force_n = 1.9)
        .from(1501, |s| s.operator_force_n = -9.0);
    assert_close(of_rupture(&insertion).peak_force_rate_n_per_s, 500.0);
}

#[test]
fn the_felt_contrast_is_the_largest_drop_within_300_ms_relative_to_the_force_at_the_rupture() {
    let insertion = rupture().at(1300, |s| s.operator_force_n = 0.5).at(1301, |s| s.operator_force_n = 0.1);
    assert_close(of_rupture(&insertion).felt_contrast, 0.75);
    let pulled = of_rupture(&rupture().at(1100, |s| s.operator_force_n = -1.0));
    assert_close(pulled.felt_contrast, 1.5);
}

#[test]
fn a_metric_over_a_window_is_undefined_if_the_run_ends_before() {
    let of = |ticks| of_rupture(&Insertion::of_ticks(ticks).rupture_at(1000));
    let short = of(1300);
    assert_eq!((short.slave_travel_m, short.felt_contrast, short.slave_overshoot_m), (None, None, None));
    let travelled = of(1301);
    assert!(travelled.slave_travel_m.is_some() && travelled.felt_contrast.is_some());
    let windowed = |rupture: RuptureMetrics| {
        [rupture.slave_overshoot_m, rupture.master_travel_m, rupture.peak_force_rate_n_per_s]
            .map(|value| value.is_some())
    };
    assert_eq!((windowed(of(1500)), windowed(of(1501))), ([false; 3], [true; 3]));
}

/// Returns a run with a rupture at 1 s and an event from 1.01 s, released at 1.4 s and ended at 1.6 s.
fn event() -> Insertion {
    rupture().event([1010, 1400, 1600])
}

#[test]
fn an_event_runs_from_its_alarm_over_the_release_to_the_return() {
    let metrics = event().metrics();
    let event = &metrics.events[0];
    assert_eq!((metrics.events.len(), event.start_s, event.is_false), (1, 1.01, 0));
    assert_close(event.augmented_s, 0.39);
    assert_close(event.reengaging_s, 0.2);
    assert_close(Some(event.master_start_m), 0.0101);
    assert_close(Some(event.master_end_m), 0.014);
    assert_eq!(metrics.mode_switches, 3);
    let times = metrics.mode_times;
    assert_close(Some(times.augmented_s), 0.39);
    assert_close(Some(times.reengaging_s), 0.2);
    assert_close(Some(times.teleoperation_s), 2.0 - 0.59);
}

#[test]
fn an_event_open_at_the_end_of_the_run_has_no_duration_and_the_last_master_position() {
    let event = |ticks| Insertion::of_ticks(ticks).event([1010, 1400, 1600]).metrics().events[0].clone();
    let frozen = event(1300);
    assert_eq!((frozen.augmented_s, frozen.reengaging_s, frozen.peak_reengaging_speed_m_per_s), (None, None, None));
    assert_eq!((frozen.exit_step_n, frozen.exit_step_allowed_n), (None, None));
    assert_close(Some(frozen.master_end_m), 0.01299);
    let released = event(1500);
    assert!(released.augmented_s.is_some() && released.reengaging_s.is_none());
}

#[test]
fn a_change_of_mode_without_an_alarm_is_an_event_too() {
    let insertion = Insertion::of_ticks(1000).with(|s| {
        if (300..400).contains(&s.tick) {
            s.mode = Modes::splat(Mode::Augmented);
        }
    });
    let metrics = insertion.metrics();
    assert_eq!((metrics.events.len(), metrics.alarms.len(), metrics.mode_switches), (1, 0, 2));
    assert_close(Some(metrics.mode_times.augmented_s), 0.1);
    assert_close(Some(metrics.mode_times.teleoperation_s), 0.9);
}

#[test]
fn the_frozen_motion_is_the_largest_distance_from_the_position_at_the_freeze() {
    let insertion = event()
        .from(1010, |s| s.slave_position_m = 0.0101)
        .at(1100, |s| s.slave_position_m = 0.01)
        .at(1200, |s| s.slave_position_m = 0.0103)
        .from(1400, |s| s.slave_position_m = 0.02);
    let metrics = insertion.metrics();
    assert_close(Some(metrics.events[0].frozen_motion_m), 2e-4);
    let backwards = event().from(1010, |s| s.slave_position_m = 0.0101).at(1100, |s| s.slave_position_m = 0.0095);
    assert_close(Some(backwards.metrics().events[0].frozen_motion_m), 6e-4);
}

#[test]
fn the_peak_speed_while_re_engaging_covers_both_directions() {
    let insertion = event()
        .at(1350, |s| s.slave_velocity_m_per_s = 0.9)
        .at(1450, |s| s.slave_velocity_m_per_s = -0.06)
        .at(1600, |s| s.slave_velocity_m_per_s = 0.9);
    let metrics = insertion.metrics();
    assert_close(metrics.events[0].peak_reengaging_speed_m_per_s, 0.06);
    assert_close(metrics.peak_reengaging_speed_m_per_s, 0.06);
    assert_eq!(rupture().metrics().peak_reengaging_speed_m_per_s, None);
}

#[test]
fn the_change_of_the_feedback_force_is_measured_from_the_start_of_the_event() {
    let insertion = event()
        .at(1010, |s| s.feedback_force_n = 1.5)
        .at(1200, |s| s.feedback_force_n = 0.25)
        .at(1500, |s| s.feedback_force_n = 2.5)
        .at(1600, |s| s.feedback_force_n = 9.0);
    assert_close(Some(insertion.metrics().events[0].force_change_n), 1.25);
}

#[test]
fn the_force_steps_at_entry_and_exit_are_read_from_the_command() {
    let insertion = event()
        .from(1010, |s| s.commanded_force_n = 1.25)
        .from(1400, |s| s.commanded_force_n = 1.5)
        .at(1010, |s| s.allowed_force_step_n = 1.0)
        .at(1400, |s| s.allowed_force_step_n = 0.125);
    let event = &insertion.metrics().events[0];
    assert_eq!((event.entry_step_n, event.entry_step_allowed_n), (0.75, 1.0));
    assert_eq!((event.exit_step_n, event.exit_step_allowed_n), (Some(0.25), Some(0.125)));
}

#[test]
fn the_step_excess_is_the_largest_change_in_an_event_beyond_what_its_law_allows() {
    let excess = |insertion: Insertion| insertion.metrics().feedback_step_excess_n;
    let jump = |tick| move |insertion: Insertion| insertion.from(tick, |s| s.commanded_force_n += 1.0);
    assert_eq!(excess(event()), 0.0);
    assert_close(Some(excess(jump(1100)(event()).at(1100, |s| s.allowed_force_step_n = 0.25))), 0.75);
    assert_close(Some(excess(jump(1010)(event()))), 1.0);
    assert_close(Some(excess(jump(1600)(event()))), 1.0);
    assert_eq!([excess(jump(900)(event())), excess(jump(1601)(event()))], [0.0; 2], "outside of an event");
}

#[test]
fn a_false_event_is_one_whose_alarm_has_no_rupture() {
    let metrics = Insertion::of_ticks(3000)
        .event([500, 600, 700])
        .event([1000, 1200, 1300])
        .rupture_at(2000)
        .event([2010, 2100, 2200])
        .at(550, |s| s.feedback_force_n = 0.5)
        .at(1100, |s| s.feedback_force_n = 1.25)
        .at(2050, |s| s.feedback_force_n = 0.0)
        .metrics();
    let is_false: Vec<u64> = metrics.events.iter().map(|event| event.is_false).collect();
    assert_eq!((is_false, metrics.false_alarms), (vec![1, 1, 0], 2));
    let read = |key: &str| RunMetric::named(key).expect("a metric").read(&metrics);
    assert_close(read("false_alarm_event_s"), 0.5);
    assert_close(read("false_alarm_force_n"), 1.5);
    assert_close(read("events"), 3.0);
    assert_close(read("max_frozen_motion_m"), 0.00199);
}

#[test]
fn the_depth_at_return_is_the_advance_from_the_rupture_to_the_end_of_its_event() {
    assert_close(of_rupture(&event()).depth_at_return_m, 0.006);
    assert_eq!(of_rupture(&rupture().alarm_at(1010)).depth_at_return_m, None, "without an event");
    // The same freeze also holds the needle of a second rupture within the event.
    let metrics = event().rupture_at(1200).metrics();
    assert_close(metrics.ruptures[1].depth_at_return_m, 0.004);
    // An event of a false alarm does not count for an earlier rupture.
    let metrics = Insertion::of_ticks(3000).rupture_at(1000).alarm_at(1010).event([2000, 2100, 2200]).metrics();
    assert_eq!(metrics.ruptures[0].depth_at_return_m, None);
}

#[test]
fn the_mean_residual_and_the_extremes_of_the_tissue_force_are_over_the_run() {
    for ticks in [1, 3, 31, 32, 33, 100, 257] {
        let metrics = Insertion::of_ticks(ticks)
            .with(|s| s.residual_n = if s.tick % 2 == 0 { -0.25 } else { 0.5 })
            .with(|s| s.tissue_force_n = (s.tick as f64 - 50.0) * 0.1)
            .metrics();
        let sum: f64 = (0..ticks).map(|tick| if tick % 2 == 0 { 0.25 } else { 0.5 }).sum();
        assert_close(metrics.mean_absolute_residual_n, sum / ticks as f64);
        assert_close(metrics.min_tissue_force_n, -5.0);
        assert_close(metrics.max_tissue_force_n, (ticks as f64 - 51.0) * 0.1);
        assert_eq!((metrics.ticks, metrics.outcome), (ticks, Outcome::Completed));
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
    assert_close(insertion.metrics().tracking_rmse_m, (squares / following.count() as f64).sqrt());
}

#[test]
fn energies_are_trapezoidal_integrals_of_the_power() {
    let metrics = Insertion::of_ticks(101)
        .with(|s| {
            let t = TICK_S * s.tick as f64;
            (s.operator_force_n, s.master_velocity_m_per_s) = (3.0 * t, 2.0);
            (s.tissue_force_n, s.slave_velocity_m_per_s) = (5.0, 4.0 * t);
        })
        .metrics();
    // Linear powers over 0.1 s: ∫ 6 t dt, ∫ 20 t dt.
    assert_close(metrics.operator_energy_j, 0.03);
    assert_close(metrics.tissue_energy_j, 0.1);
}

#[test]
fn the_final_position_and_the_final_error_are_read_at_the_last_tick() {
    for ticks in [1500, 1512, 2000] {
        // Inside an event, after an event, and after quiet ticks.
        let last = 1e-5 * (ticks - 1) as f64;
        let metrics = Insertion::of_ticks(ticks)
            .event([1010, 1400, 1505])
            .with(|s| s.slave_reference_m = 1.25 * s.slave_position_m)
            .metrics();
        assert_close(metrics.final_slave_position_m, last);
        assert_close(metrics.final_tracking_error, 0.2);
    }
    let at_zero = Insertion::of_ticks(10).with(|s| s.slave_reference_m = 0.0).metrics();
    assert_eq!(at_zero.final_tracking_error, None, "relative to a reference of 0");
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
fn an_observer_is_done_at_the_tick_of_the_divergence() {
    use trocar_engine::engine::Observer as _;
    let insertion = Insertion::of_ticks(100).from(40, |s| s.slave_position_m = 7.0);
    let grid = trocar_core::time::TickGrid::new(TICK_S, 0.1).expect("a grid");
    let mut observer = MetricsObserver::<f64>::new(grid, 0);
    let done = (0..100).find(|&tick| {
        observer.observe(&insertion.signals(tick));
        observer.is_done()
    });
    assert_eq!(done, Some(40));
}

#[test]
fn a_diverged_run_has_the_metrics_of_the_ticks_before_the_divergence() {
    let until = Insertion::of_ticks(1200).rupture_at(1000).event([1010, 1400, 1600]).by(None, true);
    let diverged = Insertion::of_ticks(2000).rupture_at(1000).event([1010, 1400, 1600]).by(None, true);
    let diverged = diverged.from(1200, |s| (s.slave_position_m, s.residual_n, s.tissue_force_n) = (7.0, 9.0, 99.0));
    let (until, diverged) = (until.metrics(), diverged.metrics());
    let outcome = Outcome::Diverged { time_s: 1.2 };
    assert_eq!(diverged, Metrics { outcome, ..until });
}

#[test]
fn a_run_without_a_tick_has_no_metrics() {
    let grid = trocar_core::time::TickGrid::new(1e-3, 1.0).expect("a grid");
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
    let insertion = |ticks, scale| {
        Insertion::of_ticks(ticks).by(Some(scale), false).rupture_at(1000).from(1000, move |s| {
            s.intended_position_m = 0.01;
            s.slave_position_m = 0.01 + advance(s.tick);
        })
    };
    let metrics = insertion(3500, 1.0).metrics();
    let rupture = &metrics.ruptures[0];
    assert_close(rupture.excess_advance_m, 0.005);
    assert_close(rupture.horizon_advance_m, 0.003);
    assert_close(rupture.unintended_cut_m, 0.005);
    assert_close(metrics.final_excess_m, 0.003);
    assert_eq!(insertion(3000, 1.0).metrics().ruptures[0].excess_advance_m, None, "the horizon has not passed");
    let unknown = of_rupture(&insertion(3500, 1.0).by(None, false));
    assert_eq!((unknown.excess_advance_m, unknown.unintended_cut_m), (None, None));
    assert_close(unknown.horizon_advance_m, 0.003);
}

#[test]
fn the_intended_motion_is_scaled_to_the_slave() {
    // The slave moves by half of the intended motion, which is no excess. After the rupture it moves a fifth more: 2 mm
    // of 10.
    let insertion = Insertion::of_ticks(3500).by(Some(0.5), false).rupture_at(1000).with(|s| {
        let moved = 1e-5 * s.tick as f64;
        s.intended_position_m = 2.0 * moved;
        s.slave_position_m = moved + 0.2 * (moved.clamp(0.01, 0.02) - 0.01);
    });
    assert_close(of_rupture(&insertion).excess_advance_m, 0.002);
}

#[test]
fn an_unintended_cut_is_a_depth_beyond_the_largest_intended_one() {
    // The hand advances 3 mm and comes back; the needle advances 4 mm and stays.
    let insertion = Insertion::of_ticks(3500).by(Some(1.0), false).rupture_at(1000).from(1000, |s| {
        let moved = 1e-5 * (s.tick - 1000) as f64;
        s.intended_position_m = 0.01 + if moved < 0.003 { moved } else { 0.0 };
        s.slave_position_m = 0.01 + moved.min(0.004);
    });
    let rupture = of_rupture(&insertion);
    assert_close(rupture.unintended_cut_m, 0.004 - 0.00299);
    assert_close(rupture.excess_advance_m, 0.004);
}

#[test]
fn the_next_rupture_ends_the_horizon_of_the_one_before() {
    let metrics = Insertion::of_ticks(4000)
        .by(Some(1.0), false)
        .rupture_at(1000)
        .rupture_at(1400)
        .from(1000, |s| s.intended_position_m = 0.01)
        .metrics();
    assert_close(metrics.ruptures[0].horizon_advance_m, 0.004);
    assert_close(metrics.ruptures[0].excess_advance_m, 0.004);
    assert_close(metrics.ruptures[1].horizon_advance_m, 0.02);
    assert_close(metrics.ruptures[1].excess_advance_m, 0.02);
}

#[test]
fn the_excess_at_return_is_the_growth_of_the_gap_over_the_event() {
    let insertion =
        event().by(Some(1.0), false).from(1010, |s| s.slave_position_m = 0.0101 + 1e-6 * (s.tick - 1010) as f64);
    let expected = 1e-6 * 590.0 - 1e-5 * 590.0;
    assert_close(insertion.metrics().events[0].excess_at_return_m, expected);
    assert_eq!(event().metrics().events[0].excess_at_return_m, None);
    let false_event = Insertion::of_ticks(2000).by(Some(1.0), false).event([1010, 1400, 1600]);
    let false_event = false_event.from(1010, |s| s.slave_position_m += 0.001);
    let metrics = false_event.at(1010, |s| s.slave_position_m -= 0.001).metrics();
    assert_close(RunMetric::named("false_alarm_excess_m").expect("a metric").read(&metrics), 0.001);
}

#[test]
fn a_lead_of_the_needle_before_the_event_is_not_an_excess() {
    // The needle leads the intended motion by 2 mm before and during the event, and by 0.5 mm more at its end.
    let ahead = event().by(Some(1.0), false).with(|s| s.slave_position_m += 2e-3);
    assert_close(ahead.metrics().events[0].excess_at_return_m, 0.0);
    let further = event().by(Some(1.0), false).with(|s| s.slave_position_m += 2e-3);
    let further = further.from(1600, |s| s.slave_position_m += 5e-4);
    assert_close(further.metrics().events[0].excess_at_return_m, 5e-4);
}

#[test]
fn the_final_excess_is_the_gap_when_the_intended_position_was_deepest_for_the_last_time() {
    let insertion = Insertion::of_ticks(1000).by(Some(1.0), false).with(|s| {
        s.intended_position_m = 0.01 * [0.2, 1.0, 1.0, 0.6][(s.tick / 250) as usize];
        s.slave_position_m = 1e-5 * s.tick as f64;
    });
    assert_close(insertion.metrics().final_excess_m, 1e-5 * 749.0 - 0.01);
    assert_eq!(Insertion::of_ticks(100).metrics().final_excess_m, None);
}

#[test]
fn a_notice_belongs_to_the_rupture_and_the_event_within_2_s() {
    let noticed = |tick| {
        let metrics = Insertion::of_ticks(6000)
            .by(None, true)
            .rupture_at(1000)
            .event([1500, 1600, 1700])
            .noticed_at(tick)
            .metrics();
        let (rupture, event) = (&metrics.ruptures[0], &metrics.events[0]);
        (rupture.noticed, rupture.noticed_after_s, event.noticed, metrics.false_notices)
    };
    assert_eq!(noticed(900), (Some(0), None, Some(0), Some(1)));
    assert_eq!(noticed(1200), (Some(1), Some(0.2), Some(0), Some(0)));
    assert_eq!(noticed(3000), (Some(1), Some(2.0), Some(1), Some(0)));
    assert_eq!(noticed(3001), (Some(0), None, Some(1), Some(0)));
    assert_eq!(noticed(3500), (Some(0), None, Some(1), Some(0)));
    assert_eq!(noticed(3501), (Some(0), None, Some(0), Some(1)));
}

#[test]
fn the_first_of_several_notices_counts() {
    let metrics = Insertion::of_ticks(4000).by(None, true).rupture_at(1000).noticed_at(1300).noticed_at(1400).metrics();
    assert_close(metrics.ruptures[0].noticed_after_s, 0.3);
    assert_close(RunMetric::named("noticed_ruptures").expect("a metric").read(&metrics), 1.0);
}

#[test]
fn a_notice_of_an_operator_who_withdraws_is_not_false() {
    let metrics = Insertion::of_ticks(1000)
        .by(Some(1.0), true)
        .with(|s| s.intended_position_m = -1e-5 * s.tick as f64)
        .noticed_at(500)
        .metrics();
    assert_eq!(metrics.false_notices, Some(0));
}

#[test]
fn an_operator_who_notices_nothing_has_no_count_of_notices() {
    let metrics = Insertion::of_ticks(4000).rupture_at(1000).event([1010, 1100, 1200]).metrics();
    assert_eq!((metrics.ruptures[0].noticed, metrics.events[0].noticed, metrics.false_notices), (None, None, None));
    let undecided = Insertion::of_ticks(1500).by(None, true).rupture_at(1000).metrics();
    assert_eq!(undecided.ruptures[0].noticed, None, "there is still time to notice it");
}

#[test]
fn the_undisturbed_time_excludes_withdrawal_and_2_s_after_ruptures_and_alarms() {
    let undisturbed = |insertion: Insertion| insertion.by(Some(1.0), false).metrics().undisturbed_s;
    assert_close(undisturbed(Insertion::of_ticks(5000)), 5.0);
    assert_eq!(Insertion::of_ticks(5000).metrics().undisturbed_s, None);
    // Excluded are the 2 s from the tick after the rupture.
    assert_close(undisturbed(Insertion::of_ticks(5000).rupture_at(1000)), 3.0);
    assert_close(undisturbed(Insertion::of_ticks(5000).alarm_at(1000)), 3.0);
    assert_close(undisturbed(Insertion::of_ticks(5000).rupture_at(1000).alarm_at(2000)), 2.0);
    assert_close(undisturbed(Insertion::of_ticks(5000).ignored_alarm_at(1000)), 5.0);
    let withdrawn = Insertion::of_ticks(5000).from(4000, |s| s.intended_position_m = 0.04 - 1e-5 * s.tick as f64);
    assert_close(undisturbed(withdrawn), 4.0);
}

/// Returns a run with several ruptures, alarms and notices, whose maxima belong to different ruptures.
fn several() -> Metrics {
    Insertion::of_ticks(9000)
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
        .at(4100, |s| s.operator_force_n = 1.0)
        .metrics()
}

#[test]
fn the_metrics_of_a_run_are_the_extremes_and_sums_of_its_ruptures() {
    let metrics = several();
    let read = |key: &str| RunMetric::named(key).expect("a metric").read(&metrics);
    assert_close(read("ruptures"), 2.0);
    assert_close(read("detected_ruptures"), 2.0);
    assert_close(read("max_detection_delay_s"), 0.03);
    assert_close(read("min_felt_contrast"), 0.5);
    assert_close(read("max_slave_overshoot_m"), 0.007);
    assert_close(read("max_slave_travel_m"), 0.005);
    assert_close(read("max_excess_advance_m"), 0.002);
    assert_close(read("unintended_cut_m"), 0.003);
    assert_close(read("noticed_ruptures"), 1.0);
    assert_close(read("rupture_2_time_s"), 4.0);
    assert_close(read("rupture_1_detection_delay_s"), 0.03);
    assert_close(read("teleoperation_s"), 9.0);
    assert_eq!(read("rupture_3_time_s"), None);
    assert_eq!(read("event_1_start_s"), None);
    assert_eq!(read("diverged_s"), None);
    let diverged = Insertion::of_ticks(100).from(50, |s| s.slave_position_m = 2.0).metrics();
    assert_close(RunMetric::named("diverged_s").expect("a metric").read(&diverged), 0.05);
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
    let grid = trocar_core::time::TickGrid::new(1e-3, 1.0).expect("a grid");
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
        assert_close(read(key), value);
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
            assert_close(metric.read(&metrics), value);
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
    let grid = trocar_core::time::TickGrid::new(TICK_S, TICK_S * ticks as f64).expect("a grid");
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
    let grid = trocar_core::time::TickGrid::new(TICK_S, 0.1).expect("a grid");
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

#[test]
fn the_unintended_travel_is_the_growth_of_the_gap_in_300_ms() {
    let insertion = |scale| {
        rupture()
            .by(scale, false)
            .with(|s| s.intended_position_m = 1e-5 * s.tick as f64)
            .from(1001, |s| s.slave_position_m = 0.02)
            .at(1300, |s| s.slave_position_m = 0.018)
    };
    // The slave is at 10 mm at the rupture and at 18 mm 0.3 s later. The intended position advances by 3 mm times its
    // scale.
    assert_close(of_rupture(&insertion(Some(1.0))).unintended_travel_m, 0.005);
    assert_close(of_rupture(&insertion(Some(0.5))).unintended_travel_m, 0.0065);
    assert_eq!(of_rupture(&insertion(None)).unintended_travel_m, None);
    let short = Insertion::of_ticks(1300).rupture_at(1000).by(Some(1.0), false);
    assert_eq!(of_rupture(&short).unintended_travel_m, None);
}

#[test]
fn the_deepest_point_covers_two_seconds_or_the_time_to_the_next_rupture() {
    let insertion = Insertion::of_ticks(4000)
        .rupture_at(1000)
        .from(1000, |s| s.slave_position_m = 0.01)
        .at(2900, |s| s.slave_position_m = 0.019)
        .at(3001, |s| s.slave_position_m = 0.03);
    assert_close(of_rupture(&insertion).deepest_advance_m, 0.009);
    assert_close(of_rupture(&insertion.at(3000, |s| s.slave_position_m = 0.025)).deepest_advance_m, 0.015);
    let two = Insertion::of_ticks(4000)
        .rupture_at(1000)
        .rupture_at(1500)
        .from(1000, |s| s.slave_position_m = 0.01)
        .at(1400, |s| s.slave_position_m = 0.012)
        .at(1600, |s| s.slave_position_m = 0.016);
    let metrics = two.metrics();
    assert_close(metrics.ruptures[0].deepest_advance_m, 0.002);
    assert_close(metrics.ruptures[1].deepest_advance_m, 0.006);
    let back = Insertion::of_ticks(4000).rupture_at(1000).from(1001, |s| s.slave_position_m = -0.01);
    assert_close(of_rupture(&back).deepest_advance_m, 0.0);
}

#[test]
fn the_return_has_the_time_of_teleoperation_and_the_advance_since_the_release() {
    let insertion = event()
        .from(1010, |s| s.slave_position_m = 0.0101)
        .from(1400, |s| s.slave_position_m = 0.0103)
        .from(1500, |s| s.slave_position_m = 0.0113)
        .from(1600, |s| s.slave_position_m = 0.0143);
    let of_event = of_rupture(&insertion);
    assert_close(of_event.return_after_s, 0.6);
    assert_close(of_event.return_jump_m, 0.004);
    assert_close(of_event.depth_at_return_m, 0.0043);
    let without = of_rupture(&rupture());
    assert_eq!((without.return_after_s, without.return_jump_m), (None, None));
    let cut_short = Insertion::of_ticks(1550).rupture_at(1000).event([1010, 1400, 1600]);
    assert_eq!(of_rupture(&cut_short).return_jump_m, None);
}

#[test]
fn the_drop_of_the_felt_force_is_from_an_earlier_peak_and_both_within_300_ms() {
    let insertion = rupture()
        .from(1000, |s| s.operator_force_n = 3.0)
        .from(1020, |s| s.operator_force_n = 3.5)
        .at(1100, |s| s.operator_force_n = 0.5)
        .from(1101, |s| s.operator_force_n = 1.0)
        .from(1301, |s| s.operator_force_n = 9.0)
        .from(1302, |s| s.operator_force_n = -9.0);
    let of_both = of_rupture(&insertion);
    assert_close(of_both.felt_peak_n, 3.5);
    assert_close(of_both.felt_drop_n, 3.0);
    // A force that only rises has no drop. A force that falls before it rises drops from its first value.
    let rising = of_rupture(&rupture().from(1010, |s| s.operator_force_n = 4.0));
    assert_close(rising.felt_drop_n, 0.0);
    let first =
        of_rupture(&rupture().from(1010, |s| s.operator_force_n = 0.5).from(1200, |s| s.operator_force_n = 7.0));
    assert_close(first.felt_drop_n, 1.5);
    let short = of_rupture(&Insertion::of_ticks(1300).rupture_at(1000));
    assert_eq!((short.felt_peak_n, short.felt_drop_n), (None, None));
}
