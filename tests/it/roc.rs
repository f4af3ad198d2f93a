//! Operating characteristics: the counts equal those of the separate detectors, for any number of threads; and the
//! performance of the defaults.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trocar::detect::{DetectionReport, detect};
use trocar::detector::{
    ArmingSettings, CusumDetector, Detector, DetectorInput, DetectorSettings, DistanceKind, Hypotheses,
};
use trocar::estimation::{Estimator, Rls, RlsSettings};
use trocar::recording::{InVivoLikeVariant, RUPTURES_S};
use trocar::roc::{Characteristics, Curve, DetectorBank, Point, Signal, SignalKind, Study};
use trocar::scenario::{DetectionSpec, Scenario, Source, Values};

fn shipped() -> DetectionSpec {
    let mut values = Values::load(&Source::parse("paper/classical"), &[]).expect("good");
    DetectionSpec::resolve(&mut values).expect("good")
}

fn study(kinds: &[DistanceKind], noise_std_n: f64, seeds: u64, thresholds: usize) -> Study {
    let signal = Signal::recorded("in_vivo_like".into(), &shipped(), kinds).expect("a signal");
    Study { signals: vec![signal], noise_std_n: vec![noise_std_n], seeds, thresholds, within_s: 0.010 }
}

fn judged(study: &Study) -> Characteristics {
    study.run(&AtomicBool::new(false), &|| ()).expect("judged")
}

/// Returns the inputs of the shipped insertion in noise (N), with a few values that are not finite.
fn input(noise_std_n: f64) -> Vec<DetectorInput<f64>> {
    let spec = shipped();
    let recording = &spec.recording.recording;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut estimator = Rls::<f64>::new(&RlsSettings::default());
    let sample = |k: usize| {
        let noise: f64 = StandardNormal.sample(&mut rng);
        let force_n = recording.force_n()[k] + noise_std_n * noise;
        let position_m = recording.position_m()[k];
        let velocity_m_per_s = recording.velocity_m_per_s().expect("a velocity")[k];
        let estimate = estimator.update(force_n, position_m, velocity_m_per_s);
        DetectorInput {
            force_n,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: if k % 4000 == 3999 { f64::NAN } else { estimate.residual_n },
            correction: estimate.correction,
            depth_m: 0.02,
            velocity_m_per_s,
            in_contact: position_m > 0.0,
        }
    };
    (0..recording.len()).map(sample).collect()
}

#[test]
fn a_bank_gives_the_same_alarms_as_the_separate_detectors() {
    let input = input(0.06);
    let armings = [
        ArmingSettings::default(),
        ArmingSettings { settle_s: 0.0, drop_only: false, withdrawal_speed_m_per_s: 1.0, ..ArmingSettings::default() },
    ];
    for kind in DistanceKind::ALL {
        for arming in armings {
            let mut settings = DetectorSettings { arming, ..DetectorSettings::for_kind(kind, Hypotheses::default()) };
            settings.cusum.cap = 3.0 * settings.cusum.threshold;
            // Thirteen thresholds fill one group of lanes and part of another.
            let bank = DetectorBank::around(settings, 13);
            let mut found = vec![vec![]; 13];
            bank.evaluate(&input, 1e-3, &mut |index, sample| found[index].push(sample));
            for (index, found) in found.iter().enumerate() {
                let mut detector = CusumDetector::<f64>::new(&bank.settings_at(index), 1e-3);
                let alarms: Vec<usize> = (0..input.len()).filter(|&k| detector.update(&input[k]).alarm).collect();
                assert_eq!(*found, alarms, "{kind:?}, threshold {index}");
            }
            assert!(found.iter().any(|alarms| alarms.len() > 1), "{kind:?}: nothing to compare");
        }
    }
}

#[test]
fn a_point_agrees_with_detect_at_its_threshold() {
    let spec = shipped();
    for kind in DistanceKind::ALL {
        let roc = judged(&study(&[kind], 0.0, 1, 8));
        for point in &roc.all[0].points {
            let mut detector = DetectorSettings::for_kind(kind, Hypotheses::default());
            detector.cusum.threshold = point.threshold;
            detector.cusum.cap = 10.0 * point.threshold;
            let mut with = spec.clone();
            with.settings.detector = detector;
            let report = DetectionReport::of(&detect(&with).expect("runs"), &RUPTURES_S);
            let matched: Vec<f64> = report.alarms.iter().filter_map(|alarm| alarm.delay_s).collect();
            let in_time = matched.iter().filter(|delay| **delay <= 0.010).count() as u64;
            assert_eq!((point.detected, point.late), (in_time, matched.len() as u64 - in_time), "{kind:?}");
            assert_eq!(Some(point.false_alarms as usize), report.false_alarms, "{kind:?}");
            assert_eq!(point.ruptures, 2);
        }
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let study = study(&[DistanceKind::SquaredResidual, DistanceKind::LikelihoodRatio], 0.05, 12, 9);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| judged(&study))
    };
    let alone = with(1);
    assert_eq!(alone, with(7));
    assert!(alone.all[0].points.iter().any(|point| point.false_alarms > 0));
}

#[test]
fn a_stopped_study_counts_the_finished_cases() {
    let study = study(&[DistanceKind::SquaredResidual], 0.025, 40, 2);
    let (stop, done) = (AtomicBool::new(false), AtomicU64::new(0));
    let roc = study
        .run(&stop, &|| {
            if done.fetch_add(1, Ordering::SeqCst) == 4 {
                stop.store(true, Ordering::SeqCst);
            }
        })
        .expect("judged");
    assert_eq!((roc.cases, roc.cases_planned), (done.load(Ordering::SeqCst), 40));
    assert!((5..40).contains(&roc.cases), "{}", roc.cases);
    let nothing = study.run(&AtomicBool::new(true), &|| ()).expect("judged");
    assert_eq!((nothing.cases, nothing.all[0].points[0].detection), (0, None));
}

#[test]
fn a_synthetic_insertion_with_the_defaults_equals_the_shipped_one() {
    let kinds = [DistanceKind::SquaredResidual];
    let synthetic = Signal::synthetic(&shipped(), InVivoLikeVariant::default(), &kinds).expect("a signal");
    let recorded = Signal::recorded("in_vivo_like".into(), &shipped(), &kinds).expect("a signal");
    let samples = |signal: Signal| match signal.kind {
        SignalKind::Recorded(samples) => samples,
        SignalKind::ClosedLoop(_) | SignalKind::Trials => panic!("no recording"),
    };
    assert_eq!(samples(synthetic), samples(recorded));
}

#[test]
fn a_closed_loop_gives_the_same_alarms_as_its_own_detector() {
    let source = Source::parse("layers/through-the-skin");
    let scenario = Scenario::load(&source, &["simulation.seed=1".into()]).expect("good");
    let metrics = trocar::run::run(scenario.clone()).expect("runs").metrics;
    let signal = Signal::closed_loop(scenario, &[DistanceKind::Adaptive]).expect("a signal");
    let study = Study { signals: vec![signal], noise_std_n: vec![0.0], seeds: 1, thresholds: 2, within_s: 0.5 };
    let roc = judged(&study);
    let point = roc.all[0].at_own_threshold().expect("there");
    assert_eq!((point.ruptures, point.detected), (3, 3 - metrics.missed_ruptures));
    assert_eq!(point.false_alarms, metrics.false_alarms);
}

fn at_threshold(roc: &Characteristics, detector: usize) -> &Point {
    roc.all[detector].at_own_threshold().expect("there")
}

#[test]
fn the_defaults_reach_the_target_that_the_derivative_never_reaches() {
    let roc = judged(&study(&[DistanceKind::SquaredResidual, DistanceKind::ForceDerivative], 0.025, 1000, 8));
    let paper = at_threshold(&roc, 0);
    assert_eq!(paper.cases, 1000);
    assert!(paper.detection_of_each.iter().all(|share| *share >= 0.995), "{:?}", paper.detection_of_each);
    // The rate must be significantly below one false alarm per hour. With even one false alarm in 4.4 h, the upper
    // end of the interval would be above it.
    let (_, max_per_minute) = paper.false_alarms_per_minute_interval.expect("listened");
    assert!(60.0 * max_per_minute < 1.0, "{} in {} h", paper.false_alarms, paper.hours);
    assert_eq!(roc.all[1].at_detection(0.995), None);
    let most = roc.all[1].points.iter().filter_map(|point| point.detection).fold(0.0, f64::max);
    assert!(most < 0.7, "{most}");
}

#[test]
fn the_adaptive_detector_outperforms_the_others_on_synthetic_recordings() {
    let kinds = [DistanceKind::Adaptive, DistanceKind::SquaredResidual, DistanceKind::ForceDerivative];
    let signals = vec![Signal::trials(&shipped(), &kinds)];
    let roc = judged(&Study { signals, ..study(&kinds, 0.0, 150, 24) });
    let [adaptive, others @ ..] = &roc.all[..] else { panic!("three curves") };
    let point = adaptive.at_own_threshold().expect("its own");
    // `trocar roc --trials --seeds 2000` gives the figures of the book; these bounds are for 150 seeds.
    assert!(point.detection.is_some_and(|share| share > 0.9), "{point:?}");
    assert!(point.false_alarms_per_minute.unwrap_or(0.0) < 0.6, "{point:?}");
    for per_hour in [6.0, 60.0, 600.0] {
        let of = |curve: &Curve| curve.at_false_alarms_per_hour(per_hour).map_or(0, |point| point.detected);
        for other in others {
            assert!(of(adaptive) >= of(other), "{} at {per_hour}/h", other.detector);
        }
    }
}

/// Returns the shipped insertion, interpolated to a rate and with noise of a seed.
fn interpolated(rate_hz: f64, noise_std_n: f64, seed: u64) -> Vec<DetectorInput<f64>> {
    let text = trocar::recording::in_vivo_like_csv(1);
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let at = |time_s: f64, column: usize| {
        let (index, share) = ((time_s * 1e3) as usize, (time_s * 1e3).fract());
        rows[index][column] * (1.0 - share) + rows[index + 1][column] * share
    };
    let samples = ((rows.len() - 2) as f64 / 1e3 * rate_hz) as usize;
    (0..samples)
        .map(|sample| {
            let time_s = sample as f64 / rate_hz;
            let noise: f64 = StandardNormal.sample(&mut random);
            DetectorInput {
                force_n: at(time_s, 3) + noise_std_n * noise,
                predicted_force_n: 0.0,
                residual_n: 0.0,
                correction: [0.0; 2],
                depth_m: at(time_s, 1),
                velocity_m_per_s: at(time_s, 2),
                in_contact: false,
            }
        })
        .collect()
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_defaults_detect_the_shipped_ruptures_at_every_rate_and_noise() {
    let settings = DetectorSettings::for_kind(DistanceKind::Adaptive, Hypotheses::default());
    for rate_hz in [100.0, 200.0, 333.0, 500.0, 1000.0, 2000.0, 5000.0, 10_000.0] {
        for noise_std_n in [0.025, 0.1] {
            for seed in 1..=20 {
                let mut detector = CusumDetector::<f64>::new(&settings, 1.0 / rate_hz);
                let input = interpolated(rate_hz, noise_std_n, seed);
                let alarm = |(sample, input)| detector.update(input).alarm.then_some(sample as f64 / rate_hz);
                let alarms: Vec<f64> = input.iter().enumerate().filter_map(alarm).collect();
                // Each force falls with a time constant of 45 ms.
                let latest_s = 0.045 + f64::max(0.010, 3.0 / rate_hz);
                let is_found =
                    |&(rupture_s, alarm_s): &(f64, f64)| (rupture_s..=rupture_s + latest_s).contains(&alarm_s);
                let found = RUPTURES_S.into_iter().zip(alarms.iter().copied()).filter(is_found).count();
                assert_eq!((found, alarms.len()), (2, 2), "{rate_hz} Hz, {noise_std_n} N, seed {seed}: {alarms:?}");
            }
        }
    }
}
