//! Every estimator finds its own parameters and predicts its own force better than the others. The example prints the
//! tables of the book.

#[path = "../../examples/estimators.rs"]
mod tables;

use trocar::estimation::{AnyEstimator, Estimate, Estimator, Forgetting, FrictionShape, Parameters, RlsSettings};
use trocar::report::ColumnFormat;
use trocar::run::{RunReport, run, trace_table};
use trocar::scenario::{Scenario, Source};

const TICK_S: f64 = 1e-3;

/// Returns depth and velocity of a needle that moves in, out and in again, with ripples that excite every parameter.
fn motion(k: u32) -> (f64, f64) {
    let t = TICK_S * f64::from(k);
    let (slow, fast) = (1.3, 23.0);
    let depth = 0.02 + 0.012 * (slow * t).sin() + 1e-3 * (fast * t).sin();
    (depth, 0.012 * slow * (slow * t).cos() + 1e-3 * fast * (fast * t).cos())
}

fn settings(parameters: Parameters) -> RlsSettings {
    RlsSettings { parameters, dead_zone_n: 0.0, ..RlsSettings::default() }
}

/// Returns the estimates over 20 s for a force law of depth and velocity.
fn estimates(settings: &RlsSettings, force: impl Fn(f64, f64) -> f64) -> Vec<Estimate<f64>> {
    let mut estimator = AnyEstimator::<f64>::new(settings);
    let mut last = (0.0, 0.0);
    (0..20_000)
        .map(|k| {
            // The prediction uses the last depth and velocity (eq. 6).
            let force = if k == 0 { 0.0 } else { force(last.0, last.1) };
            last = motion(k);
            estimator.update(force, last.0, last.1)
        })
        .collect()
}

fn mean_error_n(estimates: &[Estimate<f64>]) -> f64 {
    estimates.iter().map(|estimate| estimate.residual_n.abs()).sum::<f64>() / estimates.len() as f64
}

fn kelvin_voigt(p: f64, v: f64) -> f64 {
    180.0 * p + 9.0 * v
}

fn with_friction(p: f64, v: f64) -> f64 {
    kelvin_voigt(p, v) + 0.7 * v / (v.abs() + FrictionShape::DEFAULT.speed_m_per_s)
}

fn hunt_crossley(power: f64) -> impl Fn(f64, f64) -> f64 {
    // The force is 2 N at 1 cm for every power.
    move |p, v| 2.0 * (p / 0.01).powf(power) * (1.0 + 6.0 * v)
}

fn assert_close(value: f64, expected: f64, share: f64) {
    assert!((value - expected).abs() <= share * expected.abs(), "{value} for {expected}");
}

/// Returns an estimator with equal weights and, except for the forgetting factor, an infinite memory.
fn keeping(parameters: Parameters, forgetting: Forgetting) -> RlsSettings {
    let (initial_gain, reset_threshold) = (1e6, 1e6);
    RlsSettings { normalisation: 0.0, initial_gain, reset_threshold, forgetting, ..settings(parameters) }
}

#[test]
fn the_friction_estimator_finds_its_three_parameters() {
    for forgetting in [Forgetting::Resetting, Forgetting::Exponential { factor: 0.999 }] {
        let settings = keeping(Parameters::StiffnessDampingFriction, forgetting);
        let last = *estimates(&settings, with_friction).last().expect("some");
        assert_close(last.stiffness_n_per_m, 180.0, 1e-3);
        assert_close(last.damping_n_s_per_m, 9.0, 1e-2);
        assert_close(last.extra_parameter, 0.7, 1e-2);
    }
}

#[test]
fn the_hunt_crossley_estimator_finds_power_stiffness_and_damping() {
    // The power needs some memory, because it is observable only over different depths.
    let slow = RlsSettings { parameters: Parameters::HuntCrossley, ..RlsSettings::normalised(1e-3, 10.0, 100.0, 0.0) };
    let forgetting = Forgetting::Exponential { factor: 0.99 };
    for settings in [slow, RlsSettings { forgetting, ..slow }] {
        for power in [1.0, 1.25, 1.5, 2.0, 2.5] {
            let all = estimates(&settings, hunt_crossley(power));
            let last = all.last().expect("some");
            assert_close(last.extra_parameter, power, 5e-3);
            let (p, _) = motion(19_999);
            assert_close(last.stiffness_n_per_m, hunt_crossley(power)(p, 0.0) / p, 1e-3);
            assert_close(last.damping_n_s_per_m, 6.0 * hunt_crossley(power)(p, 0.0), 5e-3);
        }
    }
}

#[test]
fn stiffness_and_damping_are_found_while_forgetting() {
    let forgetting = Forgetting::Exponential { factor: Forgetting::DEFAULT_FACTOR };
    let settings = RlsSettings { forgetting, ..settings(Parameters::StiffnessAndDamping) };
    let last = *estimates(&settings, kelvin_voigt).last().expect("some");
    assert_close(last.stiffness_n_per_m, 180.0, 1e-6);
    assert_close(last.damping_n_s_per_m, 9.0, 1e-4);
}

#[test]
fn every_model_predicts_its_own_force_best() {
    use Parameters::{HuntCrossley, Stiffness, StiffnessAndDamping, StiffnessDampingFriction};
    let error = |parameters, force: &dyn Fn(f64, f64) -> f64| {
        // Use the default dead zone, in which the estimator does not update.
        let settings = RlsSettings { parameters, ..RlsSettings::default() };
        mean_error_n(&estimates(&settings, force))
    };
    let damped = |p: f64, v: f64| 180.0 * p + 40.0 * v;
    assert!(error(Stiffness, &damped) > 2.0 * error(StiffnessAndDamping, &damped));
    assert!(error(StiffnessDampingFriction, &with_friction) < 0.7 * error(StiffnessAndDamping, &with_friction));
    let curved = hunt_crossley(2.0);
    assert!(error(HuntCrossley, &curved) < 0.7 * error(StiffnessAndDamping, &curved));
    assert!(error(HuntCrossley, &curved) < 0.7 * error(StiffnessDampingFriction, &curved));
}

#[test]
fn least_residual_is_never_less_accurate_than_either_model() {
    for force in [&with_friction as &dyn Fn(f64, f64) -> f64, &hunt_crossley(1.5)] {
        let of = |parameters| estimates(&RlsSettings { parameters, ..RlsSettings::default() }, force);
        let without = of(Parameters::StiffnessAndDamping);
        let with = of(Parameters::StiffnessDampingFriction);
        let least = of(Parameters::LeastResidual);
        for ((a, b), least) in without.iter().zip(&with).zip(&least) {
            assert_eq!(least.residual_n.abs(), a.residual_n.abs().min(b.residual_n.abs()));
            assert_eq!((least.stiffness_n_per_m, least.extra_parameter), (a.stiffness_n_per_m, b.extra_parameter));
        }
    }
}

#[test]
fn no_model_estimates_anything_from_degenerate_signals() {
    let forgettings = [Forgetting::Resetting, Forgetting::Exponential { factor: 0.9 }];
    for (parameters, forgetting) in
        Parameters::ALL.into_iter().flat_map(|parameters| forgettings.map(|forgetting| (parameters, forgetting)))
    {
        let settings = RlsSettings { parameters, forgetting, ..RlsSettings::default() };
        // No contact; a needle at rest in noise; forces, depths and velocities that are not finite.
        let kinds: [fn(u32) -> [f64; 3]; 4] = [
            |k| [f64::from(k % 7), -1e-3, 0.1],
            |k| [2.0 + 0.3 * f64::from(k % 2), 0.02, 0.0],
            |_| [0.0; 3],
            |k| {
                let sample = [2.0, 0.02, 0.01];
                std::array::from_fn(|i| if k % 5 == i as u32 { f64::NAN } else { sample[i] })
            },
        ];
        for (which, kind) in kinds.into_iter().enumerate() {
            let mut estimator = AnyEstimator::<f64>::new(&settings);
            for k in 0..20_000 {
                let [force, depth, velocity] = kind(k);
                let e = estimator.update(force, depth, velocity);
                let numbers = [e.stiffness_n_per_m, e.damping_n_s_per_m, e.extra_parameter];
                assert!(numbers.iter().all(|n| n.abs() < 1e6), "{parameters:?}, {forgetting:?}, {which}: {e:?}");
            }
            let [force, depth, velocity] = [2.0, 0.02, 0.01];
            estimator.update(force, depth, velocity);
            assert!(estimator.update(force, depth, velocity).residual_n.is_finite());
        }
    }
}

#[test]
fn files_contain_the_additional_estimates() {
    let columns = |parameters: &str| {
        let settings = [format!("estimator.parameters={parameters}")];
        let source = Source::parse("layers/direct-access");
        let run = run(Scenario::load(&source, &settings).expect("loads")).expect("runs");
        let mut csv = vec![];
        ColumnFormat::Csv.write(&trace_table(&run.trace, |_| true), &mut csv).expect("written");
        let csv = String::from_utf8(csv).expect("text");
        let widths: Vec<usize> = csv.lines().map(|line| line.split(',').count()).collect();
        assert!(widths.len() > 1000 && widths.iter().all(|width| *width == widths[0]), "{parameters}");
        let summary: serde_json::Value = RunReport::of(&run).summary();
        (csv.lines().next().expect("a header").to_owned(), summary["further_estimate"].clone())
    };
    let (plain, none) = columns("stiffness-and-damping");
    assert!(none.is_null() && plain.ends_with(",excitation,estimate_flags"), "{plain}");
    for (parameters, column) in
        [("stiffness-damping-friction", "friction_n"), ("hunt-crossley", "power"), ("least-residual", "friction_n")]
    {
        let (header, estimate) = columns(parameters);
        assert_eq!(header, format!("{plain},{column}"));
        assert_eq!(estimate["column"], column);
        assert!(estimate["median"].is_f64() && estimate["last"].is_f64());
    }
}

#[test]
fn settings_that_an_estimator_does_not_support_are_refused_with_the_reason() {
    for (setting, reason) in [
        ("estimator.forgetting_factor=1.0", "from 0 to 0.99999"),
        ("estimator.friction_speed_m_per_s=0.0", "estimator.friction_speed_m_per_s is 0"),
        ("estimator.parameters=hunt-crosley", "hunt-crossley"),
        ("detector.minimum_depth_m=-0.01", "detector.minimum_depth_m is -0.01"),
        ("detector.motion=withdrawn", "not-withdrawn"),
    ] {
        let source = Source::parse("paper/augmented");
        let error = Scenario::load(&source, &[setting.to_owned()]).expect_err("refused");
        assert!(format!("{error:?} {error}").contains(reason), "{setting}: {error}");
    }
}

#[test]
fn the_book_has_the_tables_that_the_example_prints() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/src/evidence/estimators.md"))
        .expect("there");
    for table in [tables::estimators(), tables::gates()] {
        assert!(page.contains(&table), "paste what `cargo run --release --example estimators` prints:\n{table}");
    }
}
