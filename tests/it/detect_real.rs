//! Detection on recordings of a real rig, with the defaults.

use trocar::detect::{Detection, DetectionReport, detect};
use trocar::scenario::{DetectionSpec, Values};

/// Detects in a recording of the lever rig with a contact in m, and returns the specification too.
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
    let mut values = Values::from_settings("lever", &all).expect("good settings");
    let spec = DetectionSpec::resolve(&mut values).expect("a good recording");
    (detect(&spec).expect("valid"), spec)
}

#[test]
fn the_virtual_rupture_is_announced_once_within_2_ms() {
    let (detection, spec) =
        on_lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", 6.30e-3, &["recording.ruptures_s=[1.779]"]);
    let report = DetectionReport::of(&detection, &spec.recording.ruptures_s);
    assert_eq!(report.alarms.len(), 1, "{report:?}");
    let delay = report.alarms[0].time_s - 1.7790;
    assert!(delay > 0.0 && delay <= 2e-3, "{delay}");
    assert_eq!((report.missed_ruptures, report.false_alarms), (Some(0), Some(0)));
}

#[test]
fn it_hardly_depends_on_where_contact_is_taken_to_be() {
    for contact_mm in [0.0, 2.0, 4.0, 5.0, 6.0, 6.3, 7.0, 7.5] {
        let (detection, _) = on_lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", 1e-3 * contact_mm, &[]);
        assert_eq!(detection.alarms, [3559], "contact at {contact_mm} mm");
    }
}

#[test]
fn without_a_recorded_velocity_the_filter_serves() {
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
    // The needle is in contact throughout: the force of the spring is 0 about 8.5 mm before the lever's zero.
    for contact_mm in [-9.0, -8.5, -8.0] {
        let (detection, _) = on_lever("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", 1e-3 * contact_mm, &[]);
        assert!(detection.alarms.is_empty(), "spring, contact at {contact_mm} mm: {:?}", detection.alarms);
    }
    for contact_mm in [-9.0, -6.0, -5.0, -2.0, 0.0, 3.0] {
        let (detection, _) =
            on_lever("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", 1e-3 * contact_mm, &[]);
        assert!(detection.alarms.is_empty(), "free motion, contact at {contact_mm} mm: {:?}", detection.alarms);
    }
}
