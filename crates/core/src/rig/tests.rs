//! The controller of a rig: its commands, and the effects of bad samples.

use super::*;
use crate::safety::{SafetyActs, SafetySettings};

/// Settings without the safety stage: most tests are about the commands that enter it.
fn settings() -> Settings {
    let safety = SafetySettings { acts: SafetyActs::Nowhere, ..SafetySettings::DEFAULT };
    Settings { contact_m: 0.01, position_scale: 0.5, force_scale: 3.0, safety, ..Settings::default() }
}

/// A needle that advances at 10 mm/s in a spring of 200 N/m, with the hand ahead.
fn sample(tick: u64) -> Sample {
    let slave_position_m = 0.012 + 1e-5 * tick as f64;
    Sample {
        master_position_m: 0.03 + 2e-5 * tick as f64,
        slave_position_m,
        slave_velocity_m_per_s: 0.01,
        force_n: 200.0 * (slave_position_m - 0.01),
    }
}

#[test]
fn a_channel_that_is_nan_or_beyond_its_limit_is_a_fault_of_that_channel() {
    let faults = |sample: Sample| HapticController::new(&settings()).expect("valid").step(&sample).faults;
    let good = sample(0);
    let of = |master_position, slave_position, slave_velocity, force| Faults {
        master_position,
        slave_position,
        slave_velocity,
        force,
    };
    assert_eq!(faults(good), of(false, false, false, false));
    assert_eq!(faults(Sample { master_position_m: f64::NAN, ..good }), of(true, false, false, false));
    assert_eq!(faults(Sample { slave_position_m: -1.1, ..good }), of(false, true, false, false));
    assert_eq!(faults(Sample { slave_velocity_m_per_s: f64::INFINITY, ..good }), of(false, false, true, false));
    assert_eq!(faults(Sample { force_n: 100.1, ..good }), of(false, false, false, true));
    assert_eq!(faults(Sample { force_n: -100.0, ..good }), of(false, false, false, false), "the limit itself");
    assert_eq!(faults(Sample::MISSING), of(true, true, true, true));
    let velocity = VelocitySource::Filtered { resolution_m: 1e-6, acceleration_std_m_per_s2: 1.0 };
    let mut filtered = HapticController::new(&Settings { velocity, ..settings() }).expect("valid");
    assert_eq!(filtered.step(&Sample::MISSING).faults, of(true, true, false, true), "a velocity that is not read");
}

#[test]
fn missing_samples_are_counted_hold_the_commands_and_raise_no_alarm() {
    let mut controller = HapticController::new(&settings()).expect("valid");
    for tick in 0..300 {
        controller.step(&sample(tick));
    }
    let last = controller.step(&sample(300));
    assert!((last.predicted_force_n + last.residual_n - sample(300).force_n).abs() < 1e-12, "{last:?}");
    for count in 1..=50 {
        let command = controller.step(&Sample::MISSING);
        assert_eq!(command.faulty_samples, count);
        assert_eq!(command.slave_reference_m, last.slave_reference_m);
        assert_eq!(command.master_force_n, last.master_force_n);
        assert_eq!(command.stiffness_n_per_m, last.stiffness_n_per_m, "nothing is learnt");
        assert_eq!((command.residual_n, command.predicted_force_n, command.alarm), (0.0, 0.0, false));
    }
    // The next good sample has no prediction.
    let back = controller.step(&sample(351));
    assert_eq!((back.faulty_samples, back.residual_n, back.faults.any()), (0, 0.0, false));
}

#[test]
fn with_the_safety_stage_lasting_losses_end_the_force_and_hold_the_reference() {
    let safe = Settings { safety: SafetySettings::DEFAULT, ..settings() };
    let mut controller = HapticController::new(&safe).expect("valid");
    let near = |tick: u64| Sample { master_position_m: 2.0 * sample(tick).slave_position_m, ..sample(tick) };
    let mut last = controller.step(&near(0));
    for tick in 1..300 {
        last = controller.step(&near(tick));
        assert_eq!((last.state, last.limited.any()), (SafetyState::Active, false), "{tick}");
    }
    let lost: Vec<Command> = (0..300).map(|_| controller.step(&Sample::MISSING)).collect();
    assert_eq!((lost[8].state, lost[8].master_force_n), (SafetyState::Active, last.master_force_n));
    assert_eq!((lost[9].state, lost[9].faulty_samples), (SafetyState::Fault, 10));
    assert_eq!((lost[299].master_force_n, lost[299].slave_reference_m), (0.0, lost[8].slave_reference_m));
    // The force alone is missing while the hand moves by 50 mm.
    let mut controller = HapticController::new(&safe).expect("valid");
    for tick in 0..300 {
        last = controller.step(&near(tick));
    }
    for tick in 0..1000 {
        let master_position_m = near(300).master_position_m + 5e-5 * tick as f64;
        let command = controller.step(&Sample { master_position_m, force_n: f64::NAN, ..near(300) });
        assert!((command.slave_reference_m - last.slave_reference_m).abs() < 1e-3, "{tick}: {command:?}");
    }
    controller.stop();
    assert_eq!(controller.step(&near(300)).state, SafetyState::Disabled);
    controller.enable();
    assert_eq!(controller.step(&near(301)).state, SafetyState::Active);
    assert_eq!(controller.safety_counts().faults, 1);
}

#[test]
fn after_missing_samples_the_commands_return_at_their_configured_speeds() {
    let mut controller = HapticController::new(&settings()).expect("valid");
    for tick in 0..300 {
        controller.step(&sample(tick));
    }
    let mut before = controller.step(&Sample::MISSING);
    // Meanwhile the hand has moved by 20 mm, 10 mm for the slave, and the force by 5 N, 15 N for the master.
    let moved = |tick: u64| Sample {
        master_position_m: 0.02 + sample(299).master_position_m,
        force_n: 5.0 + sample(299).force_n,
        slave_position_m: sample(tick).slave_position_m,
        ..sample(299)
    };
    let mut ticks = [0; 2];
    for tick in 300..1300 {
        let command = controller.step(&moved(tick));
        let steps =
            [command.slave_reference_m - before.slave_reference_m, command.master_force_n - before.master_force_n];
        // 30 mm/s and 50 N/s.
        assert!(steps[0] <= 3e-5 + 1e-12 && steps[1] <= 0.05 + 1e-9, "{tick}: {steps:?}");
        for (count, (step, largest)) in ticks.iter_mut().zip(steps.into_iter().zip([3e-5, 0.05])) {
            *count += u32::from((step - largest).abs() < 1e-9 * largest.max(1e-4));
        }
        before = command;
    }
    assert!((before.slave_reference_m - 0.5 * moved(0).master_position_m).abs() < 1e-12);
    assert!((before.master_force_n - 3.0 * moved(0).force_n).abs() < 1e-9);
    assert!((330..=334).contains(&ticks[0]) && (298..=300).contains(&ticks[1]), "{ticks:?}");
}

#[test]
fn a_single_bad_channel_does_not_affect_the_others() {
    let mut controller = HapticController::new(&settings()).expect("valid");
    for tick in 0..300 {
        controller.step(&sample(tick));
    }
    let before = controller.step(&sample(300));
    let without_force = controller.step(&Sample { force_n: f64::NAN, ..sample(301) });
    assert!((without_force.slave_reference_m - 0.5 * sample(301).master_position_m).abs() < 1e-15);
    assert_eq!(without_force.master_force_n, before.master_force_n);
    let without_hand = controller.step(&Sample { master_position_m: f64::NAN, ..sample(302) });
    assert_eq!(without_hand.slave_reference_m, without_force.slave_reference_m);
    assert!(without_hand.master_force_n > without_force.master_force_n, "on its way back");
    let without_velocity = controller.step(&Sample { slave_velocity_m_per_s: f64::NAN, ..sample(303) });
    assert_eq!(without_velocity.slave_velocity_m_per_s, 0.01, "the last good one");
}

#[cfg(feature = "alloc")]
#[test]
fn a_controller_continues_from_its_stored_state() {
    let velocity = VelocitySource::Filtered { resolution_m: 1e-6, acceleration_std_m_per_s2: 1.0 };
    for velocity in [VelocitySource::Measured, velocity] {
        let new = || HapticController::new(&Settings { velocity, ..settings() }).expect("valid");
        let step = |controller: &mut HapticController, tick: u64| {
            let bad = tick % 350 < 3;
            let fallen = if tick >= 400 { 0.4 } else { 0.0 };
            let good = Sample { force_n: sample(tick).force_n - fallen, ..sample(tick) };
            controller.step(&if bad { Sample::MISSING } else { good })
        };
        for stored_at in [351, 500] {
            let (mut used, mut restored) = (new(), new());
            for tick in 0..stored_at {
                step(&mut used, tick);
            }
            restored.restore(&used.state()).expect("the same settings");
            assert_eq!(restored.ticks(), stored_at);
            for tick in stored_at..1200 {
                assert_eq!(step(&mut used, tick), step(&mut restored, tick), "{tick}");
            }
        }
        let mut other = new();
        assert!(other.restore(&[1, 2, 3]).is_err(), "a state of another length");
    }
}

#[test]
fn a_missing_master_position_does_not_disturb_the_detection() {
    let mut controller = HapticController::new(&settings()).expect("valid");
    let commands: Vec<Command> = (0..600)
        .map(|tick| {
            let fallen = if tick >= 400 { 0.4 } else { 0.0 };
            let good = Sample { force_n: sample(tick).force_n - fallen, ..sample(tick) };
            controller.step(&Sample { master_position_m: f64::NAN, ..good })
        })
        .collect();
    assert!(commands[400..405].iter().any(|command| command.alarm));
}
