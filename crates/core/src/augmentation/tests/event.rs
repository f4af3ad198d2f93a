//! One event from the alarm to the return to teleoperation: times, forces, references.

use super::*;

/// Returns the ticks at which the slave is frozen. The hand moves on, and a snap ends the freeze with a jump to it.
fn frozen_ticks(automaton: AutomatonSettings, timeline: impl Fn(Timeline) -> Timeline) -> Vec<usize> {
    let settings = AugmentationSettings { automaton, reengage: Reengage::Snap, blend_s: 0.01, ..settings() };
    let commands = timeline(Timeline::new(settings)).run(1500, |_| 4.0);
    let hand = |tick: usize| 0.01 * tick as f64 * TICK_S;
    (0..1500).filter(|&tick| (commands[tick].slave_reference_m - hand(tick)).abs() > 1e-12).collect()
}

fn freeze(automaton: AutomatonSettings, timeline: impl Fn(Timeline) -> Timeline) -> (usize, usize) {
    let ticks = frozen_ticks(automaton, timeline);
    let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
    assert_eq!(ticks.len(), last - first + 1, "one event");
    (first, last)
}

#[test]
fn a_freeze_without_a_minimum_waits_for_the_quiet_time_after_the_alarm() {
    // Quiet samples before the alarm do not count.
    let automaton = AutomatonSettings { min_hold_s: 0.0, exit_quiet_s: 0.08, ..Default::default() };
    assert_eq!(freeze(automaton, |timeline| timeline.alarm_at(100)), (100, 179));
}

#[test]
fn g_is_quiet_below_its_share_of_the_threshold_and_not_at_it() {
    let released = |decision: f64| {
        let automaton = AutomatonSettings { min_hold_s: 0.0, max_hold_s: 0.3, exit_ratio: 0.25, ..Default::default() };
        let settings = AugmentationSettings { automaton, reengage: Reengage::Snap, ..settings() };
        let mut supervisor = Supervisor::new(&settings, THRESHOLD, TICK_S, 0.0);
        let mut step = |tick: u64| {
            let now = SupervisorInput {
                tick,
                alarm: tick == 100,
                decision,
                hand_m: 1e-5 * tick as f64,
                slave_m: 1e-5 * tick as f64,
                force_n: 4.0,
            };
            supervisor.update(&now, 4.0, 0.01).slave_reference_m == now.hand_m
        };
        (0..101).for_each(|tick| {
            step(tick);
        });
        (101..1000).find(|&tick| step(tick))
    };
    // A quarter of γ = 2.
    assert_eq!(released(0.5 - 1e-9), Some(150), "quiet: after 50 ms");
    assert_eq!(released(0.5), Some(400), "not quiet: after the maximum");
}

#[test]
fn the_refractory_period_begins_with_the_return_and_ends_on_its_last_tick() {
    let automaton = AutomatonSettings { min_hold_s: 0.1, refractory_s: 0.05, ..Default::default() };
    let events = |second: u64| {
        // 100 ticks frozen, 10 of cross-fade: back in teleoperation at 210, refractory until 260.
        let ticks = frozen_ticks(automaton, |timeline| timeline.alarm_at(100).alarm_at(second));
        ticks.windows(2).filter(|pair| pair[1] > pair[0] + 1).count() + 1
    };
    assert_eq!([events(205), events(215), events(259), events(260)], [1, 1, 1, 2]);
}

#[test]
fn an_alarm_is_taken_only_if_it_begins_an_event() {
    let timeline = Timeline::new(settings()).alarm_at(100).alarm_at(300).alarm_at(860).alarm_at(1100);
    let taken = |commands: &[Command<f64>]| -> Vec<usize> {
        (0..commands.len()).filter(|&tick| commands[tick].alarm_taken).collect()
    };
    assert_eq!(taken(&timeline.run(1300, |_| 4.0)), [100, 1100], "in an event, and in the refractory period");
    let disabled = AugmentationSettings { enabled: false, ..settings() };
    let timeline = Timeline::new(disabled).alarm_at(100).alarm_at(300);
    assert_eq!(taken(&timeline.run(500, |_| 4.0)), [100, 300], "without augmentation every alarm is reported");
}

#[test]
fn the_maximum_of_a_freeze_is_at_least_its_minimum() {
    let automaton = AutomatonSettings { min_hold_s: 0.6, max_hold_s: 0.5, ..Default::default() };
    assert_eq!(automaton.validate().expect_err("too short").name, "augmentation.max_hold_s");
}

/// A measured force that falls from 4 N by 1 N per second.
fn falling(tick: u64) -> f64 {
    4.0 - 1e-3 * tick as f64
}

#[test]
fn in_teleoperation_the_force_is_the_measured_one_and_may_change_as_it_does() {
    let commands = Timeline::new(settings()).run(50, |tick| falling(tick * tick));
    for (tick, command) in (0..).zip(&commands).skip(1) {
        let (now, before) = (falling(tick * tick), falling((tick - 1) * (tick - 1)));
        assert_eq!(command.feedback_force_n, now);
        assert!((command.allowed_step_n - (before - now)).abs() < 1e-12);
    }
}

#[test]
fn at_the_release_the_force_fades_from_the_last_augmented_one_to_the_measured_one() {
    let force = ForceLawSettings::Decay(DecaySettings { ratio: 0.25, time_constant_s: 0.01 });
    let settings = AugmentationSettings { force, blend_s: 0.08, ..settings() };
    let commands = Timeline::new(settings).alarm_at(100).run(1000, falling);
    // After 500 ms the decay has ended at a quarter of the force just before the alarm.
    let held = 0.25 * falling(99);
    assert!((commands[599].feedback_force_n - held).abs() < 1e-12, "{}", commands[599].feedback_force_n);
    let mut weight_before = 0.0;
    for step in 1..=80_u64 {
        let tick = 599 + step;
        let share = step as f64 / 80.0;
        let weight = share * share * (3.0 - 2.0 * share);
        let Command { feedback_force_n, allowed_step_n, .. } = commands[tick as usize];
        let expected = held + weight * (falling(tick) - held);
        assert!((feedback_force_n - expected).abs() < 1e-12, "{step}: {feedback_force_n} instead of {expected}");
        let allowed = weight * 1e-3 + (weight - weight_before) * (falling(tick - 1) - held);
        assert!((allowed_step_n - allowed).abs() < 1e-12, "{step}: {allowed_step_n} instead of {allowed}");
        weight_before = weight;
    }
    assert_eq!(commands[679].feedback_force_n, falling(679), "exactly the measured force at the end");
    assert!((680..1000).all(|tick| commands[tick as usize].feedback_force_n == falling(tick)));
}

/// The modes sent by the slave's side: 100 ticks of teleoperation, 50 frozen, then re-engaging.
fn sent() -> (AugmentationSettings, Vec<SlaveCommand<f64>>) {
    let automaton = AutomatonSettings { min_hold_s: 0.05, ..Default::default() };
    let force = ForceLawSettings::Decay(DecaySettings { ratio: 0.0, time_constant_s: 1e-3 });
    let settings = AugmentationSettings { automaton, force, reengage: Reengage::Snap, blend_s: 0.02, ..settings() };
    let mut supervisor = Supervisor::new(&settings, THRESHOLD, TICK_S, 0.0);
    let mut decide = |tick| {
        let alarm = tick == 100;
        supervisor.decide(&SupervisorInput { tick, alarm, decision: 0.0, hand_m: 0.0, slave_m: 0.0, force_n: 4.0 })
    };
    let sent = (0..300).map(&mut decide).collect();
    (settings, sent)
}

/// The feedback forces for the modes of the given ticks, at a measured force of 4 N.
fn received(ticks: impl IntoIterator<Item = usize>) -> Vec<f64> {
    let (settings, sent) = sent();
    let mut master = Supervisor::<f64>::new(&settings, THRESHOLD, TICK_S, 0.0);
    ticks.into_iter().map(|tick| master.feedback_force(sent[tick].mode, 4.0, 0.0).0).collect()
}

#[test]
fn if_the_end_of_a_freeze_or_of_the_re_engaging_is_lost_the_force_returns_through_the_cross_fade() {
    // The modes are lost from the last frozen tick on, or from the fifth tick of the re-engaging on.
    for lost_from in [150, 155] {
        let forces = received((90..lost_from).chain(200..280));
        assert!(forces[59] < 1e-9, "{}", forces[59]);
        for step in 1..=20 {
            let weight = cross_fade(f64::from(step) / 20.0);
            assert!((forces[59 + step as usize] - 4.0 * weight).abs() < 1e-9, "{lost_from} {step}");
        }
        assert!(forces[79..].iter().all(|&force| force == 4.0), "{lost_from}");
    }
}

#[test]
fn if_the_freeze_is_lost_the_force_is_not_faded() {
    assert!(received((90..100).chain(150..300)).iter().all(|&force| force == 4.0));
}

#[test]
fn a_second_event_uses_the_force_at_its_own_alarm_as_anchor() {
    let automaton = AutomatonSettings { min_hold_s: 0.05, refractory_s: 0.0, ..Default::default() };
    let force = ForceLawSettings::Amplify(AmplifySettings { gain: 2.0 });
    let settings = AugmentationSettings { automaton, force, reengage: Reengage::Snap, ..settings() };
    let commands = Timeline::new(settings).alarm_at(100).alarm_at(600).run(700, falling);
    for alarm in [100, 600] {
        let anchor = falling(alarm - 1);
        let expected = anchor + 2.0 * (falling(alarm + 20) - anchor);
        assert!((commands[alarm as usize + 20].feedback_force_n - expected).abs() < 1e-12, "{alarm}");
    }
}

#[test]
fn a_cue_is_given_only_with_augmentation() {
    let (_, sent) = sent();
    let gives = |enabled, cue| {
        let supervisor =
            Supervisor::<f64>::new(&AugmentationSettings { enabled, cue, ..settings() }, THRESHOLD, TICK_S, 0.0);
        [50, 120, 155].map(|tick: usize| supervisor.cue(sent[tick].mode))
    };
    assert_eq!(gives(true, true), [false, true, false]);
    assert_eq!([gives(true, false), gives(false, true), gives(false, false)], [[false; 3]; 3]);
}

/// The references of an event with a freeze of 50 ms from tick 100 on, for a hand position per tick.
fn references(reengage: Reengage, hand: impl Fn(u64) -> f64, force: impl Fn(u64) -> f64) -> Vec<f64> {
    let automaton = AutomatonSettings { min_hold_s: 0.05, ..Default::default() };
    let settings = AugmentationSettings { automaton, reengage, blend_s: 0.0, ..settings() };
    let mut supervisor = Supervisor::new(&settings, THRESHOLD, TICK_S, hand(0));
    let mut step = |tick: u64| {
        let (hand_m, alarm) = (hand(tick), tick == 100);
        let now = SupervisorInput { tick, alarm, decision: 0.0, hand_m, slave_m: hand_m, force_n: force(tick) };
        supervisor.update(&now, force(tick), 0.0).slave_reference_m
    };
    (0..400).map(&mut step).collect()
}

#[test]
fn a_ramp_closes_a_gap_of_either_sign_at_its_speed() {
    for direction in [1.0, -1.0] {
        // The hand moves by 1 mm while the slave is frozen, and then rests.
        let hand = |tick: u64| direction * 1e-3 * ((tick.clamp(100, 150) - 100) as f64 / 50.0);
        let references = references(Reengage::Ramp(RampSettings { catch_up_speed_m_per_s: 0.02 }), hand, |_| 1.0);
        assert!((100..=150).all(|tick| references[tick].abs() < 1e-15), "frozen, and no jump at the release");
        for step in 1..50_u64 {
            let expected = direction * 2e-5 * step as f64;
            assert!((references[150 + step as usize] - expected).abs() < 1e-12, "{step}");
        }
        assert!(references[200..].iter().all(|reference| (reference - direction * 1e-3).abs() < 1e-12));
    }
}

#[test]
fn a_ramp_until_load_stops_at_the_set_rise_above_the_lowest_force() {
    let hand = |tick: u64| 1e-3 * ((tick.clamp(100, 150) - 100) as f64 / 50.0);
    let reengage = Reengage::RampUntilLoad(RampUntilLoadSettings { approach_speed_m_per_s: 0.02, stop_rise_n: 0.5 });
    // The force falls to 1 N at tick 160, then rises by 0.1 N per tick, to 0.5 N above the minimum at tick 165.
    let force = |tick: u64| if tick < 160 { 2.0 } else { 1.0 + 0.1 * (tick - 160) as f64 };
    let references = references(reengage, hand, force);
    assert!((references[164] - 14.0 * 2e-5).abs() < 1e-12, "{}", references[164]);
    assert!(references[165..].iter().all(|reference| (reference - references[164]).abs() < 1e-15), "it is kept");
}

#[test]
fn a_gap_that_fades_begins_without_a_jump_and_closes_in_teleoperation() {
    let hand = |tick: u64| 1e-3 * ((tick.clamp(100, 150) - 100) as f64 / 50.0);
    let references = references(Reengage::Fade(FadeSettings { gap_time_constant_s: 0.1 }), hand, |_| 1.0);
    for (tick, reference) in references.into_iter().enumerate().skip(150) {
        let expected = 1e-3 * (1.0 - (-(tick as f64 - 150.0) / 100.0).exp());
        assert!((reference - expected).abs() < 1e-15, "{tick}: {reference}");
    }
}

#[test]
fn a_gap_that_waits_for_the_hand_stays_while_it_moves_and_closes_when_it_rests() {
    // The hand moves at 10 mm/s, also during the freeze, and stops at tick 250.
    let hand = |tick: u64| 1e-5 * tick.min(250) as f64;
    let settings = WhenStillSettings { still_speed_m_per_s: 0.0, return_speed_m_per_s: 0.004 };
    let still = WhenStillSettings { still_speed_m_per_s: 0.02, ..settings };
    let moving = references(Reengage::WhenStill(settings), hand, |_| 1.0);
    let resting = references(Reengage::WhenStill(still), hand, |_| 1.0);
    let gap = |references: &[f64], tick: usize| hand(tick as u64) - references[tick];
    assert!((150..400).all(|tick| (gap(&moving, tick) - 5e-4).abs() < 1e-15), "an average above 0 keeps the gap");
    assert!((200..=275).step_by(25).all(|tick| {
        let expected = (5e-4 - 4e-6 * (tick as f64 - 150.0)).max(0.0);
        (gap(&resting, tick) - expected).abs() < 1e-12
    }));
}

#[test]
fn a_clutch_keeps_its_offset_in_the_next_event() {
    let automaton = AutomatonSettings { min_hold_s: 0.05, refractory_s: 0.0, ..Default::default() };
    let settings = AugmentationSettings { automaton, reengage: Reengage::Clutch, blend_s: 0.0, ..settings() };
    let commands = Timeline::new(settings).alarm_at(100).alarm_at(300).run(500, |_| 4.0);
    let gap = |tick: usize| 0.01 * tick as f64 * TICK_S - commands[tick].slave_reference_m;
    // The freeze is at the measured position, 0.1 mm behind the hand; the hand moves by 0.5 mm in 50 ms.
    assert!((gap(200) - 6e-4).abs() < 1e-12, "{}", gap(200));
    assert!((gap(299) - 6e-4).abs() < 1e-12);
    assert!(gap(499) > 0.0 && (gap(499) - gap(360)).abs() < 1e-12, "{}", gap(499));
}

#[cfg(feature = "alloc")]
#[test]
fn a_supervisor_continues_from_its_stored_state() {
    let laws = [
        ForceLawSettings::Decay(DecaySettings { ratio: 0.3, time_constant_s: 0.2 }),
        ForceLawSettings::Amplify(AmplifySettings { gain: 2.0 }),
        ForceLawSettings::Damp(DampSettings { damping_n_s_per_m: 50.0, time_constant_s: 0.2 }),
        ForceLawSettings::Guide(GuideSettings { stiffness_n_per_m: 100.0 }),
    ];
    for force in laws {
        let settings = AugmentationSettings { force, ..settings() };
        let step = |supervisor: &mut Supervisor<f64>, tick: u64| {
            let hand_m = 1e-5 * tick as f64;
            let alarm = tick == 100;
            let now =
                SupervisorInput { tick, alarm, decision: 0.0, hand_m, slave_m: hand_m - 1e-4, force_n: falling(tick) };
            let command = supervisor.update(&now, now.force_n, 0.01);
            (command.slave_reference_m, command.feedback_force_n, command.allowed_step_n)
        };
        // While frozen, and while re-engaging.
        for stored_at in [130, 640] {
            let mut used = Supervisor::<f64>::new(&settings, THRESHOLD, TICK_S, 0.0);
            for tick in 0..stored_at {
                step(&mut used, tick);
            }
            let mut restored = Supervisor::<f64>::new(&settings, THRESHOLD, TICK_S, 0.0);
            restored.restore(&used.state()).expect("the same settings");
            for tick in stored_at..1000 {
                assert_eq!(step(&mut used, tick), step(&mut restored, tick), "{force:?} {tick}");
            }
        }
    }
}
