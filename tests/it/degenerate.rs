//! Degenerate signals cause no alarm and no infinite or undefined value, and the gain stays symmetric, positive
//! definite and bounded.

use proptest::prelude::*;
use trocar::augmentation::{AmplifySettings, AugmentationSettings, ForceLawSettings, Reengage};
use trocar::detector::{DetectorSettings, DistanceKind, Hypotheses};
use trocar::estimation::{Parameters, RlsSettings};
use trocar::rig::{Command, HapticController, Sample, Settings, VelocitySource};

/// Returns true if all values of a command are finite.
fn is_finite(command: &Command) -> bool {
    [
        command.slave_reference_m,
        command.master_force_n,
        command.allowed_force_step_n,
        command.stiffness_n_per_m,
        command.damping_n_s_per_m,
        command.predicted_force_n,
        command.residual_n,
        command.distance,
        command.decision,
        command.slave_velocity_m_per_s,
    ]
    .iter()
    .all(|number| number.is_finite())
}

/// Evaluates samples and checks the invariants. Returns the number of alarms.
fn alarms(settings: &Settings, samples: impl Iterator<Item = Sample>) -> Result<usize, TestCaseError> {
    let mut controller = HapticController::new(settings).expect("valid");
    let greatest = settings.estimator.initial_gain;
    let mut alarms = 0;
    for (k, sample) in samples.enumerate() {
        let command = controller.step(&sample);
        prop_assert!(is_finite(&command), "at {k}: {sample:?} {command:?}");
        prop_assert!(!(command.alarm && command.faults.of_slave()));
        let [f00, f01, f11] = controller.estimator_gain();
        prop_assert!(f00 > 0.0 && f11 > 0.0 && f01 * f01 < f00 * f11, "at {k}: {f00:e} {f01:e} {f11:e}");
        prop_assert!(f00 <= greatest && f11 <= greatest, "at {k}: {f00:e} {f11:e}");
        alarms += usize::from(command.alarm);
    }
    Ok(alarms)
}

/// Returns a sample with the needle and the hand at the same place.
fn at(position_m: f64, velocity_m_per_s: f64, force_n: f64) -> Sample {
    Sample {
        master_position_m: position_m,
        slave_position_m: position_m,
        slave_velocity_m_per_s: velocity_m_per_s,
        force_n,
    }
}

/// Returns the shipped rule, the constant weighting, an infinite memory, and the stiffness alone, each with and
/// without a dead zone.
fn estimators() -> impl Strategy<Value = RlsSettings> {
    let rule = RlsSettings::default();
    let constant = RlsSettings { normalisation: 0.0, initial_gain: 1e4, reset_threshold: 7e-4, ..rule };
    let endless = RlsSettings { normalisation: 0.0, initial_gain: 1e12, reset_threshold: 1e12, ..rule };
    let stiffness = RlsSettings { parameters: Parameters::Stiffness, ..rule };
    (prop::sample::select(vec![rule, constant, endless, stiffness]), prop::sample::select(vec![0.0, 1e-12, 0.03]))
        .prop_map(|(settings, dead_zone_n)| RlsSettings { dead_zone_n, ..settings })
}

fn detectors() -> impl Strategy<Value = DetectorSettings> {
    prop::sample::select(DistanceKind::ALL.to_vec())
        .prop_map(|kind| DetectorSettings::for_kind(kind, Hypotheses::default()))
}

fn augmentations() -> impl Strategy<Value = AugmentationSettings> {
    let laws = vec![
        ForceLawSettings::default(),
        ForceLawSettings::Amplify(AmplifySettings { gain: 3.0 }),
        ForceLawSettings::Amplify(AmplifySettings { gain: 1e6 }),
    ];
    let ways = vec![Reengage::default(), Reengage::Clutch, Reengage::Snap];
    (prop::sample::select(laws), prop::sample::select(ways), 0.0..0.1_f64)
        .prop_map(|(force, reengage, blend_s)| AugmentationSettings { force, reengage, blend_s, ..Default::default() })
}

fn velocities() -> impl Strategy<Value = VelocitySource> {
    prop_oneof![
        Just(VelocitySource::Measured),
        Just(VelocitySource::Filtered { resolution_m: 1e-5, acceleration_std_m_per_s2: 0.5 }),
    ]
}

fn any_settings() -> impl Strategy<Value = Settings> {
    (estimators(), detectors(), augmentations(), velocities()).prop_map(
        |(estimator, detector, augmentation, velocity)| Settings {
            estimator,
            detector,
            augmentation,
            velocity,
            ..Settings::default()
        },
    )
}

fn bad_number() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 1e6, -1e6])
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![3 => -1.0..1.0_f64, 1 => any::<f64>(), 1 => bad_number(), 1 => Just(0.0), 1 => Just(f64::MIN_POSITIVE)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// With any samples and settings, the commands are finite and the gain is bounded.
    #[test]
    fn any_samples_give_finite_values(
        settings in any_settings(),
        numbers in prop::collection::vec((any_number(), any_number(), any_number(), any_number()), 1..400),
    ) {
        let sample = |&(master_position_m, slave_position_m, slave_velocity_m_per_s, force_n): &(f64, f64, f64, f64)| {
            Sample { master_position_m, slave_position_m, slave_velocity_m_per_s, force_n: 100.0 * force_n }
        };
        alarms(&settings, numbers.iter().map(sample))?;
    }

    #[test]
    fn one_sample_is_not_a_rupture(
        settings in any_settings(), depth in -1.0..1.0_f64, velocity in -1.0..1.0_f64, force in -99.0..99.0_f64,
    ) {
        prop_assert_eq!(alarms(&settings, std::iter::once(at(depth, velocity, force)))?, 0);
    }

    #[test]
    fn a_constant_force_at_a_constant_depth_is_not_a_rupture(
        settings in any_settings(), depth in -0.3..0.3_f64, force in -20.0..20.0_f64,
    ) {
        prop_assert_eq!(alarms(&settings, (0..5000).map(|_| at(depth, 0.0, force)))?, 0);
    }

    #[test]
    fn all_zeros_and_no_contact_are_no_ruptures(settings in any_settings(), force in -20.0..20.0_f64) {
        prop_assert_eq!(alarms(&settings, (0..3000).map(|_| at(0.0, 0.0, 0.0)))?, 0);
        let above = |k: u32| at(-0.01 + 0.009 * f64::from(k).sin(), 0.1, force * f64::from(k % 7));
        prop_assert_eq!(alarms(&settings, (0..3000).map(above))?, 0);
    }

    /// There is no excitation: the depth is exactly constant, while the force is outside the dead zone at most
    /// samples.
    #[test]
    fn a_motionless_needle_is_not_a_rupture(
        estimator in estimators(), depth in prop::sample::select(vec![1e-300, 1e-12, 1e-6, 1e-3, 0.02, 0.9]),
        force in 0.0..20.0_f64, noise in prop::collection::vec(-0.05..0.05_f64, 500),
    ) {
        let settings = Settings { estimator, ..Settings::default() };
        let samples = (0..20).flat_map(|_| noise.iter()).map(|noise| at(depth, 0.0, force + noise));
        prop_assert_eq!(alarms(&settings, samples)?, 0);
    }

    /// A gap of any length, in any channel, anywhere in an insertion.
    #[test]
    fn a_gap_is_not_a_rupture(
        kind in prop::sample::select(DistanceKind::ALL.to_vec()), velocity in velocities(), start in 0..3000_u64,
        length in 1..600_u64, channel in 0..4_usize, bad in bad_number(), every in 1..5_u64,
    ) {
        // Stay below the step that the derivative distance detects as a rupture, for every kind of gap.
        let detector = DetectorSettings::for_kind(kind, Hypotheses::default());
        let settings = Settings { detector, velocity, ..Settings::default() };
        let sample = |k: u64| {
            let t = 1e-3 * k as f64;
            let (depth, speed) = (1e-3 + 0.01 * t, 0.01);
            let mut sample = at(depth, speed, 300.0 * depth + 10.0 * speed);
            if (start..start + length).contains(&k) && k.is_multiple_of(every) {
                let channels = [
                    &mut sample.master_position_m,
                    &mut sample.slave_position_m,
                    &mut sample.slave_velocity_m_per_s,
                    &mut sample.force_n,
                ];
                for (index, value) in channels.into_iter().enumerate() {
                    if index == channel {
                        *value = bad;
                    }
                }
            }
            sample
        };
        prop_assert_eq!(alarms(&settings, (0..4000).map(sample))?, 0);
    }
}

#[test]
fn settings_that_may_be_0_are_safe_at_0() {
    let estimator = RlsSettings { dead_zone_n: 0.0, normalisation: 0.0, ..RlsSettings::default() };
    let augmentation = AugmentationSettings { blend_s: 0.0, ..AugmentationSettings::default() };
    let settings = Settings { estimator, augmentation, ..Settings::default() };
    let mut controller = HapticController::new(&settings).expect("safe at 0");
    assert!((0..1000).all(|k| is_finite(&controller.step(&at(1e-5 * f64::from(k), 0.01, 3.0)))));
}
