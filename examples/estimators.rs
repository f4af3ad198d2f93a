//! The book's tables of estimators and of gates: `cargo run --release --example estimators`.

use std::fmt::Write as _;

use rayon::prelude::*;
use trocar::run::{measure, run};
use trocar::scenario::{Scenario, Source};

/// Number of seeds of the sensor's noise in the table of gates.
const SEEDS: u64 = 40;

/// Force noise added to the recordings in the table of gates, because the recordings alone do not depend on the seed.
/// Its variance is the paper's 6.25e-4 N² (4.1).
const NOISE: &str = "sensor.force_noise_std_n=0.025";

/// An estimator's name and its settings.
const ESTIMATORS: [(&str, &[&str]); 6] = [
    ("`stiffness`", &["estimator.parameters=stiffness"]),
    ("`stiffness-and-damping`", &[]),
    ("the same, `forgetting = \"exponential\"`", &["estimator.forgetting=exponential"]),
    ("`stiffness-damping-friction`", &["estimator.parameters=stiffness-damping-friction"]),
    ("`hunt-crossley`", &["estimator.parameters=hunt-crossley"]),
    ("`least-residual`", &["estimator.parameters=least-residual"]),
];

/// A gate's name and its settings.
const GATES: [(&str, &[&str]); 8] = [
    ("none", &["detector.drop_only=false", "detector.motion=any"]),
    ("`drop_only`", &["detector.motion=any"]),
    ("`motion = \"not-withdrawn\"`", &["detector.drop_only=false"]),
    ("`motion = \"inserting\"`", &["detector.drop_only=false", "detector.motion=inserting"]),
    ("both, the default", &[]),
    ("and `motion = \"inserting\"`", &["detector.motion=inserting"]),
    ("and `minimum_depth_m = 0.003`", &["detector.minimum_depth_m=0.003"]),
    ("and `parameters = \"least-residual\"`", &["estimator.parameters=least-residual"]),
];

fn scenario(name: &str, settings: &[&str]) -> Scenario {
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Scenario::load(&Source::parse(name), &settings).expect("a good scenario")
}

/// Returns the mean of |e| and the standard deviation of e over a run, in N.
fn errors(name: &str, settings: &[&str]) -> (f64, f64) {
    let run = run(scenario(name, settings)).expect("runs");
    let residual = &run.trace.residual_n;
    let count = residual.len() as f64;
    let mean = residual.iter().sum::<f64>() / count;
    let variance = residual.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count;
    (residual.iter().map(|e| e.abs()).sum::<f64>() / count, variance.sqrt())
}

/// Returns the table of the estimators' prediction errors.
pub fn estimators() -> String {
    const DATA: [(&str, &str); 4] = [
        ("paper/classical", "in-vivo-like recording"),
        ("paper/real-classical", "real hand, virtual layer"),
        ("layers/through-the-skin", "`layers/through-the-skin`"),
        ("layers/direct-access", "`layers/direct-access`"),
    ];
    let mut text = format!("| mean \\|e\\|, σ of e (mN) | {} |\n|---|", DATA.map(|(_, name)| name).join(" | "));
    text.push_str(&"---|".repeat(DATA.len()));
    text.push('\n');
    let rows: Vec<String> = ESTIMATORS
        .par_iter()
        .map(|(name, settings)| {
            let cells = DATA.map(|(data, _)| {
                let (mean, std) = errors(data, settings);
                format!("{:.1}, {:.1}", 1e3 * mean, 1e3 * std)
            });
            format!("| {name} | {} |\n", cells.join(" | "))
        })
        .collect();
    text.extend(rows);
    text
}

/// Returns the table of detections and false alarms by gate, over [`SEEDS`] seeds.
pub fn gates() -> String {
    const DATA: [(&str, &str, &[&str]); 5] = [
        ("paper/classical", "in-vivo-like recording", &[NOISE]),
        ("paper/real-classical", "real hand, virtual layer", &[NOISE]),
        ("layers/through-the-skin", "`layers/through-the-skin`", &["detector.distance=squared-residual"]),
        ("layers/direct-access", "`layers/direct-access`", &[]),
        ("hand/fast-stab", "`hand/fast-stab`", &["augmentation.enabled=false", "detector.distance=squared-residual"]),
    ];
    let names = DATA.map(|(_, name, _)| name).join(" | ");
    let mut text = format!("| ruptures detected, false alarms | {names} |\n|---|{}\n", "---|".repeat(DATA.len()));
    for (name, settings) in GATES {
        let _ = write!(text, "| {name} |");
        for (data, _, of_data) in DATA {
            let all: Vec<&str> = of_data.iter().chain(settings).copied().collect();
            let scenario = scenario(data, &all);
            let counts: Vec<[u64; 3]> = (1..=SEEDS)
                .into_par_iter()
                .map(|seed| {
                    let metrics = measure(&scenario.with_seed(seed)).expect("runs");
                    let ruptures = metrics.ruptures.len() as u64;
                    [ruptures, ruptures - metrics.missed_ruptures, metrics.false_alarms]
                })
                .collect();
            let sum = |index: usize| counts.iter().map(|count| count[index]).sum::<u64>();
            let _ = write!(text, " {} of {}, {} |", sum(1), sum(0), sum(2));
        }
        text.push('\n');
    }
    text
}

#[allow(dead_code, reason = "a test uses the tables only")]
fn main() {
    println!("{}\n{}", estimators(), gates());
}
