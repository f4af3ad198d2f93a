//! User-defined parts: the examples run, and copies of built-in parts are identical to them, bit for bit.

use trocar::augmentation::{AugmentedTick, ForceLaw, HeldReference, Modes, MotionLaw};
use trocar::detection::{CusumDetector, Decision, Detector, Distance, Evidence};
use trocar::engine::{OwnParts, Trace};
use trocar::estimation::{AnyEstimator, Estimate, Estimator};
use trocar::operator::Operator;
use trocar::run::{Run, run, run_with};
use trocar::scenario::{Scenario, Source};
use trocar::tissue::{Reaction, Tissue};

#[path = "../../examples/own_detector.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod own_detector;
#[path = "../../examples/own_force_law.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod own_force_law;
#[path = "../../examples/own_tissue.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod own_tissue;

fn scenario(name: &str, settings: &[&str]) -> Scenario {
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Scenario::load(&Source::parse(name), &settings).expect("loads")
}

fn assert_same_bits(own: &Run, built_in: &Run, what: &str) {
    let bits = |trace: &Trace| {
        let numbers = |column: &[f64]| column.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        [&trace.slave_position_m, &trace.master_position_m, &trace.feedback_force_n, &trace.residual_n, &trace.decision]
            .map(|column| numbers(column))
    };
    // A run with own parts cannot be repeated and has its own tissue, so it has no reasons for missed ruptures and no layers.
    let mut expected = built_in.metrics.clone();
    expected.ruptures.iter_mut().for_each(|rupture| (rupture.layer, rupture.miss) = (None, None));
    assert_eq!(own.metrics, expected, "{what}");
    assert!(bits(&own.trace) == bits(&built_in.trace), "{what}");
}

#[test]
fn a_user_defined_tissue_relaxes_at_rest() {
    let run = own_tissue::run().expect("runs");
    let force = &run.trace.tissue_force_n;
    assert!(force.iter().all(|force| *force >= 0.0) && force.iter().any(|force| *force > 2.0));
    assert!(run.metrics.ruptures.is_empty() && run.trace.len() > 1000);
}

#[test]
fn a_user_defined_detector_finds_both_ruptures() {
    let run = own_detector::run().expect("runs");
    assert_eq!((run.metrics.ruptures.len(), run.metrics.missed_ruptures, run.metrics.false_alarms), (2, 0, 0));
    let late = |delay: Option<f64>| delay.is_some_and(|delay| delay < 0.01);
    assert!(run.metrics.ruptures.iter().all(|rupture| late(rupture.detection_delay_s)));
}

#[test]
fn a_user_defined_force_law_keeps_its_step_limit() {
    let run = own_force_law::run().expect("runs");
    assert_eq!(run.metrics.events.len(), 2);
    assert!(run.metrics.feedback_step_excess_n <= 1e-12, "{}", run.metrics.feedback_step_excess_n);
    assert!(run.metrics.ruptures.iter().all(|rupture| rupture.feedback_fall_s.is_some_and(|fall| fall < 0.08)));
}

#[test]
fn a_scenario_with_boxed_parts_is_identical_to_the_built_in_one_bit_for_bit() {
    for (name, settings) in [
        ("augmented", &[][..]),
        ("layers/skin-augmented", &[]),
        ("hand/reflex-augmented", &["estimator.parameters=least-residual", "detector.distance=likelihood-ratio"]),
        ("link/lossy-link", &[]),
        ("link/saturating-master", &[]),
        ("passivity/long-delay-tank", &[]),
        ("link/four-channel", &["augmentation.events_s=[1.5]"]),
    ] {
        let built_in = run(scenario(name, settings)).expect("runs");
        let own = run_with(scenario(name, settings), OwnParts::default()).expect("runs");
        assert_same_bits(&own, &built_in, name);
    }
}

/// A part that delegates to a built-in one.
struct Copied<T>(T);

impl<T: Tissue<f64>> Tissue<f64> for Copied<T> {
    fn react(&mut self, tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64> {
        self.0.react(tick, position_m, velocity_m_per_s)
    }
}

impl<T: Operator<f64>> Operator<f64> for Copied<T> {
    fn desired_position_m(&mut self, tick: u64, felt_n: f64) -> f64 {
        self.0.desired_position_m(tick, felt_n)
    }
}

impl<T: Estimator<f64>> Estimator<f64> for Copied<T> {
    fn update(&mut self, force_n: f64, depth_m: f64, velocity_m_per_s: f64) -> Estimate<f64> {
        self.0.update(force_n, depth_m, velocity_m_per_s)
    }

    fn skip(&mut self) {
        self.0.skip();
    }
}

impl<T: Detector<f64>> Detector<f64> for Copied<T> {
    fn update(&mut self, evidence: &Evidence<f64>) -> Decision<f64> {
        self.0.update(evidence)
    }
}

impl<T: MotionLaw<f64>> MotionLaw<f64> for Copied<T> {
    fn follow(&mut self, hand_m: f64, slave_m: f64) -> f64 {
        self.0.follow(hand_m, slave_m)
    }

    fn update(&mut self, modes: Modes<f64>, hand_m: f64, slave_m: f64) -> f64 {
        self.0.update(modes, hand_m, slave_m)
    }

    fn is_blended(&self) -> bool {
        self.0.is_blended()
    }
}

/// Separate implementations of the paper's distance and decay.
struct Square;

impl Distance<f64> for Square {
    fn update(&mut self, evidence: &Evidence<f64>) -> f64 {
        evidence.residual_n * evidence.residual_n
    }
}

struct Decay {
    keep: f64,
}

impl ForceLaw<f64> for Decay {
    fn augmented(&mut self, now: &AugmentedTick<f64>) -> (f64, f64) {
        let end = 0.0 * now.anchor_n;
        let gap = now.last_n - end;
        (end + gap * self.keep, gap.abs() * (1.0 - self.keep))
    }
}

#[test]
fn copies_of_built_in_parts_are_identical_bit_for_bit() {
    let built = || scenario("augmented", &[]);
    let built_in = run(built()).expect("runs");
    let scenario = built();
    let tick_s = scenario.grid.tick_s();
    let parts = scenario.general_engine::<f64>(0).expect("builds").parts;
    let law = HeldReference::new(scenario.augmentation.freeze, scenario.augmentation.reengage, tick_s, 0.0);
    let own = OwnParts::default()
        .operator(Copied(parts.operator))
        .tissue(Copied(parts.tissue))
        .estimator(Copied(AnyEstimator::new(&scenario.estimator)))
        .motion_law(Copied(law))
        .force_law(Decay { keep: libm::exp(-tick_s / 0.03) });
    let with_distance = run_with(built(), own.distance(Square)).expect("runs");
    assert_same_bits(&with_distance, &built_in, "all but the detector");
    let detector = Copied(CusumDetector::<f64>::new(&scenario.detector, tick_s));
    let with_detector = run_with(built(), OwnParts::default().detector(detector)).expect("runs");
    assert_same_bits(&with_detector, &built_in, "the detector");
}
