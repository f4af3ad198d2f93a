//! User-defined parts: the examples run, and copies of built-in parts are identical to them, bit for bit.

use crate::support::scenario;
use trocar::augmentation::{AugmentedTick, ForceLaw, HeldReference, ModeChange, MotionLaw};
use trocar::detector::{CusumDetector, Decision, Detector, DetectorInput, Distance};
use trocar::engine::{Trace, UserDefinedParts};
use trocar::estimation::{AnyEstimator, Estimate, Estimator};
use trocar::metrics::Outcome;
use trocar::operator::Operator;
use trocar::run::{Run, RunReport, empty_trace_with, observe_with, run, run_with};
use trocar::tissue::{Reaction, Tissue};
use trocar::warning::Code;

#[path = "../../examples/user_defined_detector.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod user_defined_detector;
#[path = "../../examples/user_defined_force_law.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod user_defined_force_law;
#[path = "../../examples/user_defined_tissue.rs"]
#[allow(dead_code, reason = "its main is not called here")]
mod user_defined_tissue;

fn assert_same_bits(run: &Run, built_in: &Run, what: &str) {
    let bits = |trace: &Trace| {
        let numbers = |column: &[f64]| column.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        [&trace.slave_position_m, &trace.master_position_m, &trace.feedback_force_n, &trace.residual_n, &trace.decision]
            .map(|column| numbers(column))
    };
    // A run with user-defined parts cannot be repeated and has its own tissue, so it has no reasons for missed
    // ruptures and no layers.
    let mut expected = built_in.metrics.clone();
    expected.ruptures.iter_mut().for_each(|rupture| (rupture.layer, rupture.miss) = (None, None));
    assert_eq!(run.metrics, expected, "{what}");
    assert!(bits(&run.trace) == bits(&built_in.trace), "{what}");
}

#[test]
fn a_user_defined_tissue_relaxes_at_rest() {
    let run = user_defined_tissue::run().expect("runs");
    let force = &run.trace.tissue_force_n;
    assert!(force.iter().all(|force| *force >= 0.0) && force.iter().any(|force| *force > 2.0));
    assert!(run.metrics.ruptures.is_empty() && run.trace.len() > 1000);
}

#[test]
fn a_user_defined_detector_finds_both_ruptures() {
    let run = user_defined_detector::run().expect("runs");
    assert_eq!((run.metrics.ruptures.len(), run.metrics.missed_ruptures, run.metrics.false_alarms), (2, 0, 0));
    let late = |delay: Option<f64>| delay.is_some_and(|delay| delay < 0.01);
    assert!(run.metrics.ruptures.iter().all(|rupture| late(rupture.detection_delay_s)));
}

#[test]
fn a_user_defined_force_law_keeps_its_step_limit() {
    let run = user_defined_force_law::run().expect("runs");
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
        ("augmented", &["augmentation.reengage=ramp-until-load"]),
        ("layers/skin-augmented", &["sensor.at_tip=true"]),
    ] {
        let built_in = run(scenario(name, settings)).expect("runs");
        // The wiring for user-defined parts, without any.
        let (scenario, none) = (scenario(name, settings), UserDefinedParts::default());
        let mut trace = empty_trace_with(&scenario, &none);
        let metrics = observe_with(&scenario, none, &mut trace.recorder()).expect("runs");
        assert_same_bits(&Run::of_user_defined_parts(scenario, vec![], metrics, trace), &built_in, name);
    }
}

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
    fn update(&mut self, input: &DetectorInput<f64>) -> Decision<f64> {
        self.0.update(input)
    }
}

impl<T: MotionLaw<f64>> MotionLaw<f64> for Copied<T> {
    fn follow(&mut self, hand_m: f64, slave_m: f64) -> f64 {
        self.0.follow(hand_m, slave_m)
    }

    fn update(&mut self, modes: ModeChange<f64>, hand_m: f64, slave_m: f64) -> f64 {
        self.0.update(modes, hand_m, slave_m)
    }

    fn is_blended(&self) -> bool {
        self.0.is_blended()
    }
}

/// Separate implementations of the paper's distance and decay.
struct Square;

impl Distance<f64> for Square {
    fn update(&mut self, input: &DetectorInput<f64>) -> f64 {
        input.residual_n * input.residual_n
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
    let parts = UserDefinedParts::default()
        .operator(Copied(parts.operator))
        .tissue(Copied(parts.tissue))
        .estimator(Copied(AnyEstimator::new(&scenario.estimator)))
        .motion_law(Copied(law))
        .force_law(Decay { keep: libm::exp(-tick_s / 0.03) });
    let with_distance = run_with(built(), parts.distance(Square)).expect("runs");
    assert_same_bits(&with_distance, &built_in, "all but the detector");
    let detector = Copied(CusumDetector::<f64>::new(&scenario.detector, tick_s));
    let with_detector = run_with(built(), UserDefinedParts::default().detector(detector)).expect("runs");
    assert_same_bits(&with_detector, &built_in, "the detector");
}

/// A part that returns a bad value from a tick on.
struct Spoiled(f64);

impl Tissue<f64> for Spoiled {
    fn react(&mut self, tick: u64, position_m: f64, _velocity_m_per_s: f64) -> Reaction<f64> {
        Reaction { force_n: if tick < 500 { 100.0 * position_m.max(0.0) } else { self.0 }, ruptured: false }
    }
}

impl Estimator<f64> for Spoiled {
    fn update(&mut self, force_n: f64, _depth_m: f64, _velocity_m_per_s: f64) -> Estimate<f64> {
        let stiffness_n_per_m = if force_n > 0.5 { self.0 } else { 100.0 };
        Estimate {
            stiffness_n_per_m,
            damping_n_s_per_m: 0.0,
            predicted_force_n: force_n,
            residual_n: 0.0,
            correction: [0.0; 2],
            extra_parameter: 0.0,
        }
    }

    fn skip(&mut self) {}
}

#[test]
fn a_number_that_is_not_finite_names_the_part_that_returned_it() {
    for spoiled in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = |parts: UserDefinedParts| {
            run_with(scenario("layers/skin-augmented", &[]), parts).expect_err("a part fails").to_string()
        };
        let of_tissue = error(UserDefinedParts::default().tissue(Spoiled(spoiled)));
        assert!(of_tissue.contains("the user-defined tissue") && of_tissue.contains("tick 500"), "{of_tissue}");
        let of_estimator = error(UserDefinedParts::default().estimator(Spoiled(spoiled)));
        assert!(of_estimator.contains("the user-defined estimator"), "{of_estimator}");
    }
}

#[test]
fn a_run_with_user_defined_parts_reports_what_it_cannot_know() {
    struct Silent;
    impl Detector<f64> for Silent {
        fn update(&mut self, _input: &DetectorInput<f64>) -> Decision<f64> {
            Decision { distance: 0.0, decision: 0.0, alarm: false }
        }
    }
    let with = |name: &str, settings: &[&str]| {
        let parts = UserDefinedParts::default().detector(Silent);
        RunReport::of(&run_with(scenario(name, settings), parts).expect("runs")).warnings()
    };
    let missed = with("layers/skin-augmented", &[]);
    assert!(missed.iter().any(|warning| warning.code == Code::MissedRupture), "{missed:?}");
    let swing = with("passivity/late-wall", &[]);
    assert!(swing.iter().any(|warning| warning.code == Code::Oscillating), "{swing:?}");
    // Without a user-defined part, it is a run of the scenario.
    let late = run_with(scenario("passivity/late-wall", &[]), UserDefinedParts::default()).expect("runs");
    assert!(matches!(late.metrics.outcome, Outcome::Oscillating { .. }), "{:?}", late.metrics.outcome);
    // A setting that would silently be left out is refused.
    let moved = scenario("layers/skin-augmented", &["tissue.breathing_amplitude_m=5 mm"]);
    let error = run_with(moved, UserDefinedParts::default().tissue(Spoiled(0.0))).expect_err("refused").to_string();
    assert!(error.contains("motion of the organs"), "{error}");
}
