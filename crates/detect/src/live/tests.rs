//! Compares streams with files of the same samples, and tests lost, late and repeated samples.

use super::super::detect;
use super::*;
use trocar_scenario::{DetectionSpec, Values};

fn insertion(settings: &[&str]) -> DetectionSpec {
    let mut all = vec!["recording.file=builtin:in_vivo_like.csv".to_owned()];
    all.extend(settings.iter().map(|&setting| setting.to_owned()));
    let mut values = Values::from_settings("insertion", &all).expect("good settings");
    DetectionSpec::resolve(&mut values).expect("a good recording")
}

fn samples(spec: &DetectionSpec) -> Vec<LiveSample> {
    let recording = &spec.recording.recording;
    let velocity = recording.velocity_m_per_s();
    (0..recording.len())
        .map(|k| LiveSample {
            time_s: recording.time_s()[k],
            position_m: recording.position_m()[k],
            velocity_m_per_s: velocity.map_or(0.0, |velocity| velocity[k]),
            force_n: recording.force_n()[k],
        })
        .collect()
}

fn stream(
    spec: &DetectionSpec,
    interval_s: Option<f64>,
    velocity: VelocitySource,
    samples: &[LiveSample],
) -> (Vec<LiveStep>, Vec<TimestampAnomaly>, LiveSummary) {
    let mut live = LiveDetector::new(spec.settings.clone(), interval_s, velocity).expect("valid");
    let (mut ticks, mut anomalies) = (vec![], vec![]);
    for sample in samples {
        anomalies.extend(live.take(sample, |tick| ticks.push(*tick)).expect("an interval"));
    }
    (ticks, anomalies, live.summary())
}

fn alarms_s(ticks: &[LiveStep]) -> Vec<f64> {
    ticks.iter().filter(|tick| tick.step.decision.alarm).map(|tick| tick.time_s).collect()
}

const MEASURED: &str = "recording.columns.velocity_m_per_s=velocity_m_per_s";

#[test]
fn an_even_stream_is_identical_to_its_file_bit_for_bit() {
    let given = "sensor.position_resolution_m=1e-6";
    for (settings, velocity) in
        [(MEASURED, VelocitySource::Measured), (given, VelocitySource::Filtered { step_m: 1e-6 })]
    {
        let spec = insertion(&[settings]);
        let file = detect(&spec).expect("valid");
        assert_eq!(file.alarms.len(), 2);
        let (ticks, anomalies, summary) = stream(&spec, Some(file.interval_s), velocity, &samples(&spec));
        assert!(anomalies.is_empty());
        assert_eq!((ticks.len(), summary.alarms, summary.restarts), (file.time_s.len(), 2, 0));
        for (k, tick) in ticks.iter().enumerate() {
            assert_eq!((tick.time_s, tick.sample), (file.time_s[k], k as u64));
            let estimate = &tick.step.estimate;
            let live = [estimate.residual_n, estimate.stiffness_n_per_m, estimate.damping_n_s_per_m];
            let stored = [file.residual_n[k], file.stiffness_n_per_m[k], file.damping_n_s_per_m[k]];
            assert_eq!(live.map(f64::to_bits), stored.map(f64::to_bits), "sample {k}");
            assert_eq!(tick.step.decision.decision.to_bits(), file.decision[k].to_bits(), "sample {k}");
            assert_eq!(tick.step.decision.alarm, file.alarms.contains(&k));
        }
        let residual = crate::DetectionReport::of(&file, &[]).residual;
        let close = |a: Option<f64>, b: f64| (a.expect("defined") - b).abs() < 1e-12;
        assert!(close(summary.std_n, residual.std_n) && close(summary.mean_n, residual.mean_n));
        assert!(close(summary.mean_absolute_n, residual.mean_absolute_n));
        assert_eq!(summary.max_absolute_n, Some(residual.max_absolute_n));
    }
}

#[test]
fn samples_that_are_not_later_are_omitted_until_the_clock_counts_as_set_back() {
    let spec = insertion(&[MEASURED]);
    let all = samples(&spec);
    let mut spoilt = all.clone();
    spoilt.insert(3001, all[3000]);
    spoilt.insert(2001, all[100]);
    let (ticks, anomalies, summary) = stream(&spec, Some(1e-3), VelocitySource::Measured, &spoilt);
    assert_eq!((ticks.len(), summary.not_later, anomalies.len()), (all.len(), 2, 2));
    assert_eq!(anomalies[0], TimestampAnomaly::NotLater { last_s: 2.0, time_s: 0.1 });
    assert_eq!(alarms_s(&ticks).len(), 2);

    // The insertion twice; the clock of the second one starts at 0 again.
    let twice: Vec<LiveSample> = all.iter().chain(&all).copied().collect();
    let (ticks, anomalies, summary) = stream(&spec, Some(1e-3), VelocitySource::Measured, &twice);
    assert_eq!((summary.not_later, summary.restarts), (9, 1));
    assert!(matches!(anomalies.last(), Some(TimestampAnomaly::SetBack { .. })));
    assert_eq!(alarms_s(&ticks).len(), 4, "both ruptures, twice");

    // One time far ahead causes a restart, and the return to the true time another.
    let mut wild = all.clone();
    wild[1000].time_s = 1e300;
    let (ticks, _, summary) = stream(&spec, Some(1e-3), VelocitySource::Measured, &wild);
    assert_eq!((summary.restarts, summary.not_later), (2, 9));
    assert_eq!(alarms_s(&ticks).len(), 2);
}

#[test]
fn an_empty_stream_has_undefined_statistics() {
    let spec = insertion(&[MEASURED]);
    let (_, _, summary) = stream(&spec, None, VelocitySource::Measured, &[]);
    assert_eq!((summary.samples, summary.mean_n, summary.std_n, summary.interval_s), (0, None, None, None));
    let (ticks, _, _) = stream(&spec, None, VelocitySource::Measured, &samples(&spec)[..1]);
    assert!(ticks.is_empty(), "without a second sample there is no interval");
    assert!(LiveDetector::new(spec.settings.clone(), Some(0.0), VelocitySource::Measured).is_err());
}

#[test]
fn a_number_that_is_not_finite_is_refused_and_changes_nothing() {
    let spec = insertion(&[]);
    let all = samples(&spec);
    let velocity = VelocitySource::Filtered { step_m: 1e-6 };
    let (expected, ..) = stream(&spec, Some(1e-3), velocity, &all);
    let mut live = LiveDetector::new(spec.settings.clone(), Some(1e-3), velocity).expect("valid");
    let mut ticks = vec![];
    for (index, sample) in all.iter().enumerate() {
        if index % 1000 == 500 {
            for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let of_force = live.take(&LiveSample { force_n: wrong, ..*sample }, |_| panic!("a tick"));
                assert_eq!(of_force.expect_err("refused").name, "force_n");
                let of_position = live.take(&LiveSample { position_m: wrong, ..*sample }, |_| panic!("a tick"));
                assert_eq!(of_position.expect_err("refused").name, "position_m");
            }
        }
        live.take(sample, |tick| ticks.push(*tick)).expect("a sample");
    }
    assert_eq!(format!("{ticks:?}"), format!("{expected:?}"));
}

#[test]
fn settings_out_of_range_are_refused() {
    let spec = insertion(&[]);
    let with = |change: fn(&mut DetectionSettings)| {
        let mut settings = spec.settings.clone();
        change(&mut settings);
        DetectionChain::new(&settings, 1e-3, VelocitySource::Measured).expect_err("refused").name
    };
    assert_eq!(with(|settings| settings.contact_m = f64::NAN), "estimator.contact_m");
    assert_eq!(with(|settings| settings.detector.cusum.threshold = f64::NAN), "detector.threshold");
    assert_eq!(with(|settings| settings.detector.cusum.threshold = -1.0), "detector.threshold");
}
