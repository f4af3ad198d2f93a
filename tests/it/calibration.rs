//! One rule calibrates every recording from its first 5 s, and the settings are evaluated on the whole recording.

use std::fmt::Write as _;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trocar::detect::calibration::{Calibration, CalibrationError, CalibrationRequest, ContactRule, calibrate};
use trocar::detect::{DetectionReport, detect};
use trocar::recording::{InVivoLikeVariant, in_vivo_like_variant_csv};
use trocar::scenario::{DetectionSettings, DetectionSpec, Values};

fn spec(settings: &[String]) -> DetectionSpec {
    let mut values = Values::from_settings("calibration", settings).expect("good settings");
    DetectionSpec::resolve(&mut values).expect("a good recording")
}

fn lever(file: &str, force: &str, ruptures_s: &str) -> DetectionSpec {
    spec(&[
        format!("recording.file={file}"),
        "recording.columns={time_s='t_s', position_m='xs_rad', velocity_m_per_s='vs_rad_s'}".into(),
        "recording.scale={position_m=0.075, velocity_m_per_s=0.075, force_n=13.333333333333334}".into(),
        format!("recording.columns.force_n={force}"),
        format!("recording.ruptures_s={ruptures_s}"),
    ])
}

/// Returns a recording with rows of time in s, position in m, velocity in m/s and force in N.
fn written(rows: impl Iterator<Item = [f64; 4]>, ruptures_s: &str) -> DetectionSpec {
    let mut text = String::from("time_s,position_m,velocity_m_per_s,force_n\n");
    for [time, position, velocity, force] in rows {
        writeln!(text, "{time:.6},{position:.8},{velocity:.8},{force:.8}").expect("text takes it");
    }
    let file = tempfile::Builder::new().suffix(".csv").tempfile().expect("a file");
    std::fs::write(file.path(), text).expect("written");
    spec(&[
        format!("recording.file={}", toml::Value::String(file.path().display().to_string())),
        "recording.columns.velocity_m_per_s=velocity_m_per_s".into(),
        format!("recording.ruptures_s={ruptures_s}"),
    ])
}

/// Returns the shipped insertion with more noise on its force.
fn noisy_insertion(seed: u64, noise_std_n: f64) -> DetectionSpec {
    noisy_variant(InVivoLikeVariant::default(), seed, noise_std_n)
}

/// Returns a variant of the shipped insertion with other ruptures.
fn noisy_variant(variant: InVivoLikeVariant, seed: u64, noise_std_n: f64) -> DetectionSpec {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let recording = in_vivo_like_variant_csv(1, &variant);
    let rows = recording.lines().skip(1).map(|line| {
        let mut fields = line.split(',').map(|field| field.parse::<f64>().expect("a number"));
        let mut row = std::array::from_fn(|_| fields.next().expect("four fields"));
        let noise: f64 = StandardNormal.sample(&mut random);
        row[3] += noise_std_n * noise;
        row
    });
    written(rows, "[5.52, 8.85]")
}

/// Calibrates on the beginning without the labels, and detects in the whole recording.
fn calibrated(spec: &DetectionSpec) -> (Calibration, DetectionReport) {
    calibrated_as(spec, &CalibrationRequest::default())
}

fn calibrated_as(spec: &DetectionSpec, request: &CalibrationRequest) -> (Calibration, DetectionReport) {
    let labels = spec.recording.ruptures_s.clone();
    let mut blind = spec.clone();
    blind.recording.ruptures_s = vec![];
    let calibration = calibrate(&blind, request).expect("calibrates");
    let chosen = calibration.settings();
    let (estimator, detector, contact_m) = (chosen.estimator, chosen.detector, chosen.contact_m);
    let settings = DetectionSettings { estimator, detector, contact_m, ..blind.settings };
    let with = DetectionSpec { settings, ..blind };
    let report = DetectionReport::of(&detect(&with).expect("detects"), &labels);
    (calibration, report)
}

/// Checks that every rupture is detected within 10 ms, without another alarm.
fn assert_right(name: &str, spec: &DetectionSpec) -> Calibration {
    assert_right_as(name, spec, &CalibrationRequest::default())
}

fn assert_right_as(name: &str, spec: &DetectionSpec, request: &CalibrationRequest) -> Calibration {
    let (calibration, report) = calibrated_as(spec, request);
    let delays: Vec<f64> = report.alarms.iter().filter_map(|alarm| alarm.delay_s).collect();
    assert_eq!(delays.len(), spec.recording.ruptures_s.len(), "{name}: {report:?}");
    assert_eq!(report.alarms.len(), delays.len(), "{name}: {report:?}");
    assert!(delays.iter().all(|delay| *delay < 0.01), "{name}: {delays:?}");
    calibration
}

#[test]
fn one_rule_is_sufficient_for_synthetic_and_real_recordings() {
    let insertion = assert_right("in-vivo-like", &noisy_insertion(0, 0.0));
    assert_eq!(insertion.settings().contact_m.clamp(0.0, 3e-3), insertion.settings().contact_m);
    let pop = assert_right("own_ctrl_pop", &lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", "[1.779]"));
    assert_eq!((pop.contact_rule, pop.ruptures_s.len()), (ContactRule::Extrapolated, 1));
    assert!((pop.settings().contact_m - 6.30e-3).abs() < 0.1e-3, "{:?}", pop.settings());
    let [_, (_, spring), (_, free)] = real();
    assert_right("m2_f_spring", &spring);
    assert_eq!(assert_right("m2_d_free_motion", &free).contact_rule, ContactRule::Lowest);
}

/// Returns the real recordings, with and without a given contact position.
fn real() -> [(&'static str, DetectionSpec); 3] {
    [
        ("own_ctrl_pop", lever("builtin:own_ctrl_pop.csv", "env_out_Nm_derived", "[1.779]")),
        ("m2_f_spring", lever("tests/data/teleop_1dof/m2_f_spring.csv", "tau_e_Nm", "[]")),
        ("m2_d_free_motion", lever("tests/data/teleop_1dof/m2_d_free_motion.csv", "tau_e_Nm", "[]")),
    ]
}

#[test]
fn two_seconds_are_sufficient_for_the_other_recordings() {
    let request = CalibrationRequest { first_s: 2.0, ..CalibrationRequest::default() };
    for (name, spec) in real() {
        assert_right_as(name, &spec, &request);
    }
    assert_right_as("in-vivo-like", &noisy_insertion(0, 0.0), &request);
}

#[test]
fn a_wrong_contact_position_has_little_effect() {
    let request = CalibrationRequest { keeps_contact: true, ..CalibrationRequest::default() };
    for (name, mut spec) in real() {
        for contact_mm in [-9.0, -7.5, -5.0, -2.0, 0.0, 3.0] {
            spec.settings.contact_m = 1e-3 * contact_mm;
            let calibration = assert_right_as(&format!("{name}, {contact_mm} mm"), &spec, &request);
            assert_eq!(
                (calibration.contact_rule, calibration.settings().contact_m),
                (ContactRule::Given, spec.settings.contact_m)
            );
        }
    }
}

#[test]
fn calibration_works_in_the_noise_of_the_force_sensor_and_above() {
    for seed in 1..=10 {
        assert_right("0.025 N", &noisy_insertion(seed, 0.025));
    }
    for (seed, noise_n) in [(11, 0.005), (12, 0.015), (13, 0.035)] {
        assert_right("other noise", &noisy_insertion(seed, noise_n));
    }
}

#[test]
fn calibration_works_for_other_ruptures() {
    let mut seed = 100;
    for drop_n in [2.0, 3.0, 5.0] {
        for fall_s in [0.01, 0.02, 0.045] {
            for depth_m in [0.018, 0.027] {
                seed += 1;
                let variant = InVivoLikeVariant { drop_n: Some(drop_n), fall_s: Some(fall_s), depth_m: Some(depth_m) };
                assert_right(&format!("{variant:?}"), &noisy_variant(variant, seed, 0.0));
            }
        }
    }
}

#[test]
fn half_the_sampling_rate_is_sufficient() {
    let file = std::fs::read_to_string("scenarios/recordings/own_ctrl_pop.csv").expect("there");
    let rows = file.lines().skip(1).step_by(2).map(|line| {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
        [fields[0], 0.075 * fields[2], 0.075 * fields[3], fields[4] / 0.075]
    });
    assert_right("own_ctrl_pop at 1 kHz", &written(rows, "[1.779]"));
}

#[test]
fn a_given_quiet_segment_is_used() {
    let request = CalibrationRequest { quiet_s: Some((2.0, 4.0)), ..CalibrationRequest::default() };
    let calibration = calibrate(&noisy_insertion(0, 0.0), &request).expect("calibrates");
    let (from_s, to_s) = calibration.quiet_segment_s.expect("given");
    assert!((from_s - 2.0).abs() < 1e-9 && (to_s - 4.0).abs() < 1e-9, "{from_s} {to_s}");
    assert_eq!(calibration.whiteness.expect("enough").samples, 2000);
    let empty = CalibrationRequest { quiet_s: Some((2.0, 2.01)), ..CalibrationRequest::default() };
    let error = calibrate(&noisy_insertion(0, 0.0), &empty).expect_err("ten samples");
    assert!(matches!(error, CalibrationError::NoQuiet { samples: 10, .. }), "{error}");
}

#[test]
fn a_longer_requested_interval_needs_a_higher_threshold() {
    let threshold = |false_alarm_s: f64| {
        let request = CalibrationRequest { false_alarm_s, ..CalibrationRequest::default() };
        let calibration = calibrate(&noisy_insertion(0, 0.0), &request).expect("calibrates");
        calibration.candidates[0].run_length_threshold
    };
    assert!(threshold(60.0) < threshold(3600.0) && threshold(3600.0) < threshold(1e5));
}

#[test]
fn degenerate_recordings_give_finite_settings_and_no_alarm() {
    type Row = fn(f64) -> [f64; 3];
    let rows = |count: u32, row: Row| {
        (0..count).map(move |k| {
            let time = f64::from(k) * 1e-3;
            let [position, velocity, force] = row(time);
            [time, position, velocity, force]
        })
    };
    let cases: [(&str, Row); 6] = [
        ("zeros", |_| [0.0; 3]),
        ("constant force", |_| [0.01, 0.0, 3.0]),
        ("never in contact", |t| [-0.02 + 0.001 * t, 0.001, 0.0]),
        ("a motionless needle under a growing force", |t| [0.01, 0.0, t]),
        ("a spring without noise", |t| [0.001 + 0.005 * t, 0.005, 300.0 * (0.001 + 0.005 * t)]),
        ("pulled all the time", |t| [0.01 + 0.001 * t, 0.001, -2.0 - 0.1 * t]),
    ];
    for (name, row) in cases {
        for count in [100, 101, 3000] {
            let (calibration, report) = calibrated(&written(rows(count, row), "[]"));
            let chosen = calibration.settings();
            let numbers = [
                chosen.contact_m,
                chosen.estimator.dead_zone_n,
                chosen.detector.cusum.threshold,
                chosen.detector.cusum.drift,
                calibration.quiet_std_n,
                calibration.false_alarm_s.unwrap_or_default(),
                calibration.least_false_alarm_s(),
            ];
            assert!(numbers.iter().all(|number| number.is_finite()), "{name}, {count}: {numbers:?}");
            assert!(calibration.quiet_std_n > 0.0 && report.alarms.is_empty(), "{name}, {count}: {report:?}");
        }
    }
    let error = calibrate(&written(rows(99, |_| [0.0; 3]), "[]"), &CalibrationRequest::default());
    assert_eq!(error, Err(CalibrationError::TooShort { samples: 99 }));
}

#[test]
fn requests_out_of_range_are_named() {
    let base = CalibrationRequest::default();
    let requests = [
        ("--first-s", CalibrationRequest { first_s: 0.0, ..base }),
        ("--false-alarm-s", CalibrationRequest { false_alarm_s: f64::NAN, ..base }),
        ("--fastest-harmless-s", CalibrationRequest { fastest_harmless_s: 0.01, ..base }),
        ("--variance-ratio", CalibrationRequest { variance_ratio: 1.0, ..base }),
        ("--quiet-s", CalibrationRequest { quiet_s: Some((3.0, 2.0)), ..base }),
    ];
    for (name, request) in requests {
        assert_eq!(request.validate().expect_err(name).name, name);
    }
}
