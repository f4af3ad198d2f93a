//! Detection on recordings of a real rig, with the defaults.

use trocar::detect::{Detection, DetectionReport, detect};
use trocar::detector::DistanceKind;
use trocar::recording::Recording;
use trocar::scenario::{DetectionSettings, DetectionSpec, Values};
use trocar::warning::Code;

/// The default detector and the paper's detector.
const DETECTORS: [&[&str]; 2] = [&[], &["detector.distance=squared-residual"]];

/// Detects in a recording of the lever rig with a contact position in m. Also returns the specification.
fn on_lever(file: &str, force: &str, contact_m: f64, settings: &[&str]) -> (Detection, DetectionSpec) {
    let mut all: Vec<String> = [
        format!("recording.file={file}"),
        "recording.columns.time_s=t_s".into(),
        "recording.columns.position_m=xs_rad".into(),
        "recording.scale.position_m=0.075".into(),
        "recording.columns.velocity_m_per_s=vs_rad_s".into(),
        "recording.scale.velocity_m_per_s=0.075".into(),
        format!("recording.columns.force_n={force}"),
        "recording.scale.force_n=13.333333333333334".into(),
        format!("estimator.contact_m={contact_m}"),
    ]
    .to_vec();
    all.extend(settings.iter().map(|&setting| setting.to_owned()));
    let mut values = Values::from_settings("lever", &all).expect("good settings").with_adaptive_detector();
    let spec = DetectionSpec::resolve(&mut values).expect("a good recording");
    (detect(&spec).expect("valid"), spec)
}

#[test]
fn the_virtual_rupture_gives_one_alarm_within_2_ms() {
    for detector in DETECTORS {
        let settings = [&["recording.ruptures_s=[1.779]"], detector].concat();
        let (detection, spec) = on_lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", 6.30e-3, &settings);
        let report = DetectionReport::of(&detection, &spec.recording.ruptures_s);
        assert_eq!(report.alarms.len(), 1, "{report:?}");
        let delay = report.alarms[0].time_s - 1.7790;
        assert!(delay > 0.0 && delay <= 2e-3, "{delay}");
        assert_eq!((report.missed_ruptures, report.false_alarms), (Some(0), Some(0)));
    }
}

#[test]
fn the_detection_hardly_depends_on_the_contact_position() {
    for (settings, sample) in DETECTORS.into_iter().zip([3561, 3559]) {
        for contact_mm in [0.0, 2.0, 4.0, 5.0, 6.0, 6.3, 7.0, 7.5] {
            let (detection, _) =
                on_lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", 1e-3 * contact_mm, settings);
            assert_eq!(detection.alarms, [sample], "contact at {contact_mm} mm, {settings:?}");
        }
    }
}

#[test]
fn without_a_recorded_velocity_the_velocity_filter_is_sufficient() {
    let settings = [
        "recording.file=builtin:own_ctrl_pop.csv",
        "recording.columns={time_s='t_s', position_m='xs_rad', force_n='env_out_Nm_derived'}",
        "recording.scale={position_m=0.075, force_n=13.333333333333334}",
        "estimator.contact_m=0.0063",
    ];
    let mut values = Values::from_settings("lever", &settings.map(str::to_owned)).expect("good settings");
    let detection = detect(&DetectionSpec::resolve(&mut values).expect("good")).expect("valid");
    assert_eq!(detection.alarms, [3559]);
}

#[test]
fn a_spring_and_free_motion_raise_no_alarm() {
    // The needle is in contact throughout, because the force of the spring is 0 about 8.5 mm before the lever's zero.
    let spring = ("tests/data/teleop_1dof/m2_f_spring.csv", &[-9.0, -8.5, -8.0][..]);
    let free = ("tests/data/teleop_1dof/m2_d_free_motion.csv", &[-9.0, -6.0, -5.0, -2.0, 0.0, 3.0][..]);
    for ((file, contacts_mm), settings) in [spring, free].into_iter().flat_map(|file| DETECTORS.map(|s| (file, s))) {
        for contact_mm in contacts_mm {
            let (detection, _) = on_lever(file, "tau_e_Nm", 1e-3 * contact_mm, settings);
            assert!(detection.alarms.is_empty(), "{file}, {contact_mm} mm, {settings:?}: {:?}", detection.alarms);
        }
    }
}

#[test]
fn a_wrong_factor_that_changes_the_alarms_gives_a_warning_at_its_column() {
    let recordings = [
        ("builtin:own_ctrl_pop.csv", "env_out_Nm_derived"),
        ("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm"),
        ("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm"),
    ];
    let columns = [
        ("position", "recording.scale.position_m", 0.075),
        ("velocity", "recording.scale.velocity_m_per_s", 0.075),
        ("force", "recording.scale.force_n", 13.333333333333334),
    ];
    let factors = [1000.0, 100.0, 10.0, 0.1, 0.01, 0.001, -1.0];
    let mut changed = 0;
    for ((file, force), detector) in recordings.into_iter().flat_map(|one| DETECTORS.map(|settings| (one, settings))) {
        let report = |settings: &[&str]| {
            let (detection, _) = on_lever(file, force, 0.0, &[settings, detector].concat());
            (DetectionReport::of(&detection, &[]).warnings, detection.alarms)
        };
        let (warnings, alarms) = report(&[]);
        assert!(warnings.is_empty(), "{file}, {detector:?}: {warnings:?}");
        for ((column, key, right), factor) in columns.into_iter().flat_map(|one| factors.map(|factor| (one, factor))) {
            let scale = format!("{key}={:?}", right * f64::abs(factor));
            let sign = format!("recording.{column}_sign={:?}", f64::signum(factor));
            // Without its own sign, a velocity has the sign of the position.
            let signs = [&sign, "recording.velocity_sign=1.0"];
            let (warnings, others) =
                report(&[&[scale.as_str()], &signs[..1 + usize::from(column != "velocity")]].concat());
            let is_at = |place: &String| place.contains(&format!("--{column}"));
            let is_named = warnings.iter().any(|warning| warning.place.as_ref().is_some_and(is_at));
            changed += usize::from(others != alarms);
            assert!(others == alarms || is_named, "{file}, {detector:?}, {column} times {factor}: {warnings:?}");
        }
    }
    assert!(changed >= 15, "{changed}");
}

#[test]
fn the_detector_is_adaptive_unless_a_setting_selects_another() {
    let kind = |settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let mut values = Values::from_settings("mine", &settings).expect("good").with_adaptive_detector();
        DetectionSettings::resolve(&mut values).expect("good").detector.distance.kind
    };
    for settings in [&[][..], &["detector.false_alarms_per_min=1"], &["detector.motion=inserting"]] {
        assert_eq!(kind(settings), DistanceKind::Adaptive, "{settings:?}");
    }
    for setting in
        ["detector.threshold=0.02", "detector.drift=0.01", "detector.settle_s=0.1", "detector.drop_only=false"]
    {
        assert_eq!(kind(&[setting]), DistanceKind::SquaredResidual, "{setting}");
    }
    assert_eq!(kind(&["detector.distance=mean-change"]), DistanceKind::MeanChange);
}

#[test]
fn a_saturated_or_stuck_force_gives_a_warning() {
    let codes = |force: fn(usize) -> f64| {
        let time_s: Vec<f64> = (0..3000).map(|k| 1e-3 * k as f64).collect();
        let position_m: Vec<f64> = time_s.iter().map(|time_s| 0.01 * time_s).collect();
        let force_n = (0..3000).map(force).collect();
        let recording = Recording::new(time_s, position_m, None, force_n, None).expect("good");
        let mut values = Values::from_settings("mine", &[]).expect("good").with_adaptive_detector();
        let detection = detect(&DetectionSpec::of(&mut values, recording).expect("good")).expect("good");
        let report = DetectionReport::of(&detection, &[]);
        report.warnings.iter().map(|warning| (warning.code, warning.message.clone())).collect::<Vec<_>>()
    };
    let rising = |k: usize| 3e-3 * k as f64 + 1e-3 * (k % 7) as f64;
    assert_eq!(codes(rising), []);
    let [saturated, stuck] = [
        codes(|k| (3e-3 * k as f64 + 1e-3 * (k % 7) as f64).min(6.0)),
        codes(|k| if (1000..2000).contains(&k) { 3.0 } else { 3e-3 * k as f64 + 1e-3 * (k % 7) as f64 }),
    ];
    assert!(
        matches!(&saturated[..], [(Code::ConstantForce, text)] if text.contains("end of its range")),
        "{saturated:?}"
    );
    assert!(matches!(&stuck[..], [(Code::ConstantForce, text)] if text.contains("not renewed")), "{stuck:?}");
}
