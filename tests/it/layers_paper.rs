//! The layered insertions agree with the paper's (3.2.1, 3.2.2), and the two engines with each other.

use crate::support::scenario;
use trocar::engine::{Observer, Signals};
use trocar::metrics::{Metrics, Outcome};
use trocar::run::{observe, run};
use trocar::scenario::{Scenario, Source};

const SEEDS: u64 = 10;

/// Returns the minimum and maximum measured force in N, and the metrics.
fn measure(name: &str, settings: &[&str]) -> (f64, f64, Metrics) {
    let run = run(scenario(name, settings)).expect("runs");
    assert_eq!(run.metrics.outcome, Outcome::Completed);
    let force = &run.trace.measured_force_n;
    let least = force.iter().copied().fold(f64::INFINITY, f64::min);
    (least, force.iter().copied().fold(f64::NEG_INFINITY, f64::max), run.metrics)
}

fn seeded(seed: u64) -> String {
    format!("simulation.seed={seed}")
}

fn error_n(metrics: &Metrics) -> f64 {
    metrics.mean_absolute_residual_n.expect("it ran")
}

fn within_a_factor_of_two(value: f64, paper: f64) -> bool {
    (0.5 * paper..=2.0 * paper).contains(&value)
}

#[test]
fn paper_direct_access_has_the_forces_and_errors_of_3_2_1() {
    for seed in 1..=SEEDS {
        let (least, greatest, m) = measure("layers/direct-access", &[&seeded(seed)]);
        // The forces are in the paper's range and close to both of its ends.
        assert!((-0.37..-0.9 * 0.3).contains(&least) && (0.9 * 1.45..1.45).contains(&greatest), "{least} {greatest}");
        assert!(within_a_factor_of_two(error_n(&m), 0.019), "seed {seed}: {}", error_n(&m));
        assert_eq!((m.ruptures.len(), m.missed_ruptures, m.false_alarms), (1, 0, 0), "seed {seed}: the capsule");
    }
}

#[test]
fn paper_stiffness_alone_is_about_three_times_worse_on_direct_access() {
    for seed in 1..=SEEDS {
        let both = error_n(&measure("layers/direct-access", &[&seeded(seed)]).2);
        let alone = error_n(&measure("layers/direct-access", &[&seeded(seed), "estimator.parameters=stiffness"]).2);
        // The paper states 0.0612 N and 0.019 N, a ratio of 3.2.
        assert!(within_a_factor_of_two(alone, 0.0612), "seed {seed}: {alone}");
        assert!((2.5..=3.9).contains(&(alone / both)), "seed {seed}: {}", alone / both);
    }
}

#[test]
fn paper_through_the_skin_has_the_forces_and_errors_of_3_2_2() {
    for seed in 1..=SEEDS {
        let (least, greatest, m) = measure("layers/through-the-skin", &[&seeded(seed)]);
        assert!((-2.45..-0.9 * 2.45).contains(&least) && (0.9 * 5.69..5.69).contains(&greatest), "{least} {greatest}");
        assert!(within_a_factor_of_two(error_n(&m), 0.0486), "seed {seed}: {}", error_n(&m));
        assert_eq!((m.ruptures.len(), m.missed_ruptures), (3, 0), "seed {seed}: skin, muscle, capsule");
        assert!(m.ruptures.iter().all(|rupture| rupture.detection_delay_s.expect("found") <= 0.010), "seed {seed}");
    }
}

/// The ticks of ruptures, and the position and force at each tick.
#[derive(Default)]
struct Watch {
    ruptures: Vec<u64>,
    seen: Vec<[f64; 4]>,
}

impl Observer<f64> for Watch {
    fn observe(&mut self, s: &Signals<f64>) {
        if s.ruptured {
            self.ruptures.push(s.tick);
        }
        self.seen.push([s.slave_position_m, s.master_position_m, s.tissue_force_n, s.operator_force_n]);
    }
}

#[test]
fn oracle_dop853_agrees_on_layers() {
    for name in ["layers/through-the-skin", "layers/direct-access"] {
        let watch = |engine: &str| {
            let mut watch = Watch::default();
            observe(&scenario(name, &[engine]), &mut watch).expect("runs");
            watch
        };
        let (exact, integrated) = (watch("simulation.engine=exact"), watch("simulation.engine=dop853"));
        assert!(!exact.ruptures.is_empty() && exact.ruptures.len() == integrated.ruptures.len());
        for (a, b) in exact.ruptures.iter().zip(&integrated.ruptures) {
            assert!(a.abs_diff(*b) <= 1, "{name}: ticks {a} and {b}");
        }
        for (tick, (a, b)) in exact.seen.iter().zip(&integrated.seen).enumerate() {
            let switches = exact.ruptures.iter().any(|rupture| rupture.abs_diff(tick as u64) <= 1);
            let difference = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(switches || difference < 1e-6, "{name}, tick {tick}: {difference:e}");
        }
    }
}

#[test]
fn impossible_layers_are_rejected_with_a_reason() {
    let refused = |settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
        let error = Scenario::load(&Source::parse("layers/through-the-skin"), &settings).expect_err("no");
        assert!(error.place.is_some(), "{error}");
        error.message
    };
    for (settings, parts) in [
        (&["tissue.layer.skin.relaxation_s=-0.1"][..], ["tissue.layer.skin.relaxation_s is -0.1", "at least 0"]),
        (
            &["tissue.layer.skin.relaxation_s=1e-5"],
            ["tissue.layer.skin.relaxation_s is 0.00001", "from simulation.tick_s"],
        ),
        (
            &["tissue.layer.capsule.rupture_force_n=0.2"],
            ["tissue.layer.capsule.rupture_force_n is 0.2", "at least tissue.layer.capsule.cutting_force_n"],
        ),
        (&["tissue.layer.organ.rupture_force_n=-30"], ["tissue.layer.organ.rupture_force_n is -30", "at least 1e-12"]),
        (
            &["tissue.layer.fat.stiffness_n_per_m=0"],
            ["tissue.layer.fat.stiffness_n_per_m is 0", "enough to reach tissue.layer.fat.rupture_force_n"],
        ),
        (&["tissue.static_ratio=0.5"], ["tissue.static_ratio is 0.5", "at least 1"]),
        (&["tissue.contact_m=-0.01"], ["tissue.contact_m is -0.01", "the needle's start"]),
        (&["tissue.layer.skin.thickness_m=0"], ["tissue.layer.skin.thickness_m is 0", "at least 1e-12"]),
    ] {
        let message = refused(settings);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}
