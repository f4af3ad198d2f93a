use super::*;
use trocar_core::augmentation::{Mode, Modes};
use trocar_core::detector::{CusumDetector, Detector, DetectorInput, DetectorSettings};
use trocar_scenario::Source;

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Three seconds of an insertion with noise, spikes, lasting drops, withdrawals and losses of contact.
fn insertion(seed: u64) -> Vec<DetectorInput<f64>> {
    let mut state = seed;
    let mut residual = 0.0;
    let sample = |_| {
        let chance = random(&mut state);
        residual = if chance > 0.99 { -0.6 * random(&mut state).abs() } else { 0.9 * residual };
        let residual_n = residual + 0.08 * random(&mut state) * random(&mut state);
        DetectorInput {
            force_n: 2.0 + residual_n,
            predicted_force_n: 2.0,
            residual_n,
            correction: [0.0; 2],
            depth_m: 0.02,
            velocity_m_per_s: if chance < -0.9 { -0.02 } else { 0.01 },
            in_contact: chance.abs() > 3e-3,
        }
    };
    (0..3000).map(sample).collect()
}

fn scenario(detector: DetectorSettings) -> Scenario {
    let mut scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &[]).expect("it is shipped");
    assert_eq!(scenario.grid.tick_s(), 1e-3);
    scenario.detector = detector;
    scenario
}

fn signals(tick: u64, residual_n: f64, decision: f64, alarm: bool) -> SelectedSignals<f64> {
    SelectedSignals {
        tick,
        intended_position_m: 0.0,
        slave_position_m: 0.0,
        residual_n,
        decision,
        mode: Modes::splat(Mode::Teleoperation),
        ruptured: false,
        alarm,
    }
}

#[test]
fn thresholds_reported_as_equivalent_raise_the_same_alarms_and_few_are_missed() {
    let thresholds: Vec<f64> = (0..40).map(|k| 2e-3 * 1.12_f64.powi(k)).collect();
    let settings = |threshold: f64| {
        let mut settings = DetectorSettings::default();
        (settings.cusum.threshold, settings.cusum.cap) = (threshold, 0.3);
        settings.arming.settle_s = 0.03;
        settings
    };
    let (mut reported, mut true_of, mut alarm_count) = (0, 0, 0);
    for seed in 1..30 {
        let samples = insertion(seed);
        let alarms = |threshold: f64, observer: &mut dyn EventObserver<f64>| -> Vec<bool> {
            let mut detector = CusumDetector::<f64>::new(&settings(threshold), 1e-3);
            let ticks = samples.iter().zip(0..);
            let alarm = |(sample, tick): (&DetectorInput<f64>, u64)| {
                let decision = detector.update(sample);
                observer.observe(&signals(tick, sample.residual_n, decision.decision, decision.alarm));
                decision.alarm
            };
            ticks.map(alarm).collect()
        };
        for index in [0, 7, 20] {
            let higher = &thresholds[index + 1..];
            let of_run = scenario(settings(thresholds[index]));
            let mut observer = EquivalentThresholds::<f64>::new(&[of_run], &[higher.to_vec()]);
            let of_run = alarms(thresholds[index], &mut observer);
            let equivalent: Vec<f64> = observer.thresholds(0).collect();
            for &threshold in higher {
                let is_equivalent = alarms(threshold, &mut ()) == of_run;
                let is_reported = equivalent.contains(&threshold);
                assert!(is_equivalent || !is_reported, "seed {seed}, {} {threshold}", thresholds[index]);
                reported += usize::from(is_reported);
                true_of += usize::from(is_equivalent);
            }
            alarm_count += of_run.iter().filter(|alarm| **alarm).count();
        }
    }
    assert!(
        alarm_count > 500 && true_of > 300 && 10 * reported > 8 * true_of,
        "{reported} of {true_of}, {alarm_count}"
    );
}

/// The thresholds, of 1.5 and 3, that remain for a run with threshold 1 and ticks with a `g` and an alarm flag each.
fn remaining(settle_s: f64, samples: &[(f64, bool)]) -> Vec<f64> {
    let mut detector = DetectorSettings::default();
    (detector.cusum.threshold, detector.cusum.cap, detector.arming.settle_s) = (1.0, 10.0, settle_s);
    let mut observer = EquivalentThresholds::<f64>::new(&[scenario(detector)], &[vec![1.5, 3.0]]);
    for (tick, &(decision, alarm)) in (0..).zip(samples) {
        observer.observe(&signals(tick, -0.5, decision, alarm));
    }
    observer.thresholds(0).collect()
}

#[test]
fn an_alarm_that_is_not_above_a_threshold_drops_it() {
    let quiet = (0.5, false);
    assert_eq!(remaining(2e-3, &[quiet, quiet, (2.0, true)]), [1.5]);
    assert_eq!(remaining(2e-3, &[quiet, quiet, (4.0, true)]), [1.5, 3.0]);
    assert_eq!(remaining(2e-3, &[quiet, quiet, (2.0, false)]), [1.5, 3.0], "no rupture to any of them");
}

#[test]
fn a_threshold_that_alone_may_be_armed_is_dropped() {
    let (quiet, low, high) = ((0.5, false), (1.2, false), (2.0, false));
    assert_eq!(remaining(2e-3, &[quiet, low, high]), [3.0], "1.5 has been quiet for two ticks, 1 for none");
    assert_eq!(remaining(2e-3, &[low, high]), [1.5, 3.0], "for one tick");
    assert_eq!(remaining(2e-3, &[quiet, low, quiet, quiet, high]), [1.5, 3.0], "both are");
}

#[test]
fn a_phase_that_lasts_longer_than_the_minimum_hold_drops_all() {
    let hold_ticks = 500;
    let remaining = |ticks: u64| {
        let mut run = scenario(DetectorSettings::default());
        run.augmentation.automaton.min_hold_s = 0.5;
        let mut observer = EquivalentThresholds::<f64>::new(&[run], &[vec![0.1, 0.2]]);
        for tick in 0..2000 {
            let mode = match tick {
                // Two phases, because the ticks are counted per phase.
                300.. if tick < 300 + ticks => Mode::Augmented,
                1200.. if tick < 1200 + ticks => Mode::Augmented,
                300..900 | 1200.. => Mode::Reengaging,
                0..300 | 900..1200 => Mode::Teleoperation,
            };
            observer.observe(&SelectedSignals { mode: Modes::splat(mode), ..signals(tick, 0.0, 0.0, false) });
        }
        observer.thresholds(0).count()
    };
    assert_eq!([remaining(hold_ticks), remaining(hold_ticks + 1)], [2, 0]);
}
