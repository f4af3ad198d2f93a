//! The states of the safety stage, and their commands.

use super::*;

const TICK_S: f64 = 1e-3;

fn stage(settings: SafetySettings) -> SafetyStage {
    SafetyStage::new(&settings, TICK_S, 0.0)
}

fn good(reference_m: f64, force_n: f64, slave_m: f64) -> Wanted {
    Wanted { reference_m, force_n, slave_m, is_good: true }
}

fn bad(reference_m: f64, force_n: f64, slave_m: f64) -> Wanted {
    Wanted { is_good: false, ..good(reference_m, force_n, slave_m) }
}

#[test]
fn a_start_near_the_hand_is_active_at_once_and_changes_nothing() {
    let mut stage = stage(SafetySettings::DEFAULT);
    for k in 0..100 {
        let (reference_m, force_n) = (0.01 + 1e-5 * f64::from(k), 1.0 + 0.01 * f64::from(k));
        let safe = stage.pass(&good(reference_m, force_n, 0.01), None);
        assert_eq!(safe, Safe { reference_m, force_n, limited: Limited::default() }, "{k}");
        assert_eq!(stage.state(), SafetyState::Active);
    }
    assert_eq!(stage.counts(), SafetyCounts::default());
}

#[test]
fn a_start_far_from_the_hand_is_a_ramp_without_force_from_the_slave() {
    let mut stage = stage(SafetySettings::DEFAULT);
    // 32 mm at 30 mm/s, but for the last 2 mm: a second.
    let mut last_m = 0.1;
    for k in 0..999 {
        let safe = stage.pass(&good(0.132, 5.0, last_m), None);
        assert!(((safe.reference_m - last_m) - 3e-5).abs() < 1e-12, "{k}: {safe:?}");
        assert_eq!((safe.force_n, stage.state()), (0.0, SafetyState::Aligning));
        last_m = safe.reference_m;
    }
    let reached = (0..4).find(|_| {
        stage.pass(&good(0.132, 5.0, 0.13), None);
        stage.state() == SafetyState::Active
    });
    assert!(reached.is_some());
    // The force returns within 0.2 s.
    let forces: Vec<f64> = (0..220).map(|_| stage.pass(&good(0.132, 5.0, 0.132), None).force_n).collect();
    assert!(forces.windows(2).all(|pair| (0.0..=0.0251).contains(&(pair[1] - pair[0]))), "{forces:?}");
    assert_eq!(forces[219], 5.0);
    assert_eq!(stage.counts().alignments, 1);
}

#[test]
fn after_bad_samples_the_force_decays_the_reference_holds_and_good_samples_end_the_fault() {
    let mut stage = stage(SafetySettings::DEFAULT);
    stage.pass(&good(0.0, 4.0, 0.0), None);
    let during: Vec<(Safe, SafetyState)> =
        (1..=300).map(|k| (stage.pass(&bad(1e-5 * f64::from(k), 4.0, 0.0), None), stage.state())).collect();
    assert!(during[..9].iter().all(|(safe, state)| safe.force_n == 4.0 && *state == SafetyState::Active));
    assert_eq!((during[9].1, stage.cause()), (SafetyState::Fault, Some(FaultCause::BadSamples)));
    assert!(during[9..].iter().all(|(safe, _)| safe.reference_m == during[8].0.reference_m));
    assert!(during[9 + 190].0.force_n < 0.05 * 4.0, "{:?}", during[199]);
    assert_eq!(during[9 + 200].0.force_n, 0.0);
    let back = stage.pass(&good(1e-4, 4.0, 0.0), None);
    assert_eq!(stage.state(), SafetyState::Active);
    assert!(back.force_n < 0.03, "{back:?}");
    assert_eq!(stage.counts().faults, 1);
}

#[test]
fn a_stop_lasts_until_it_is_ended() {
    let mut stage = stage(SafetySettings::DEFAULT);
    stage.pass(&good(0.0, 4.0, 0.0), None);
    stage.stop();
    let last = (0..300).map(|_| stage.pass(&good(0.02, 4.0, 0.0), None)).last().expect("a command");
    assert_eq!((last.force_n, last.reference_m, stage.state()), (0.0, 0.0, SafetyState::Disabled));
    stage.enable();
    let first = stage.pass(&good(0.02, 4.0, 0.0), None);
    assert_eq!((first.force_n, stage.state()), (0.0, SafetyState::Aligning));
    assert!((first.reference_m - 3e-5).abs() < 1e-15);
}

#[test]
fn a_fault_of_a_sensor_lasts_until_it_is_ended() {
    let mut stage = stage(SafetySettings::DEFAULT);
    let stuck = |k: u32| SlaveSample { position_m: 1e-5 * f64::from(k), velocity_m_per_s: None, force_n: 1.5 };
    for k in 0..400 {
        stage.pass(&good(0.0, 1.5, stuck(k).position_m), Some(&stuck(k)));
    }
    assert_eq!((stage.state(), stage.cause()), (SafetyState::Fault, Some(FaultCause::StuckForce)));
    let moving = |k: u32| SlaveSample { force_n: 1.0 + 1e-3 * f64::from(k % 7), ..stuck(k) };
    for k in 400..500 {
        stage.pass(&good(0.0, 1.5, moving(k).position_m), Some(&moving(k)));
    }
    assert_eq!(stage.state(), SafetyState::Fault);
    stage.enable();
    stage.pass(&good(0.0, 1.5, 0.0), Some(&moving(500)));
    assert_eq!((stage.state(), stage.cause()), (SafetyState::Active, None));
}

#[test]
fn where_the_stage_does_not_act_commands_pass_and_a_stop_has_no_effect() {
    let mut stage = stage(SafetySettings { acts: SafetyActs::Nowhere, ..SafetySettings::DEFAULT });
    stage.stop();
    let safe = stage.pass(&bad(3.0, 1e5, 0.0), None);
    assert_eq!((safe.reference_m, safe.force_n, stage.state()), (3.0, 1e5, SafetyState::Active));
}
