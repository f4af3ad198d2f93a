//! Runs the passivity schemes on many random cases and compares their results.
//!
//! ```sh
//! cargo run --release --example passive -- 2000
//! ```
//! It prints for each scheme the number of cases that violate the promise `E_m - E_s >= -E_0` at the ports of hand
//! and needle, the smallest margin, and the number of cases whose peak force exceeds 1.5 times the peak force of the
//! plain loop without delay.

#[allow(dead_code, reason = "shared with the tests")]
#[path = "../tests/it/support/passive_cases.rs"]
mod passive_cases;

use passive_cases::{Case, Random};
use trocar::run::{Run, run};
use trocar::scenario::{Scenario, Source};

const SCHEMES: [&str; 3] = ["time-domain", "wave-variables", "energy-tank"];

fn ran(base: &str, settings: &[String]) -> Run {
    let scenario = Scenario::load(&Source::parse(&format!("builtin:{base}.toml")), settings);
    let scenario = scenario.unwrap_or_else(|error| panic!("{error:?}\n{settings:?}"));
    run(scenario).unwrap_or_else(|error| panic!("{error}\n{settings:?}"))
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak, value| value.abs().max(peak))
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let cases: usize = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(200);
    let seed: u64 = arguments.next().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let mut random = Random::new(seed);
    let mut broken = [0; 3];
    let mut worst = [(f64::INFINITY, 0); 3];
    let mut ratios: [Vec<(f64, usize)>; 3] = Default::default();
    for index in 0..cases {
        let case = Case::draw(&mut random, 3.0);
        let plain = ran(case.base, &case.settings);
        let plain_n = peak(&plain.trace.feedback_force_n).max(peak(&plain.trace.tissue_force_n));
        for (at, scheme) in SCHEMES.into_iter().enumerate() {
            let run = ran(case.base, &case.with(scheme));
            let (link, ports) = (run.metrics.link.expect("a link"), run.metrics.ports.expect("ticks"));
            let margin_j = link.promised_energy_j.expect("a promise") - ports.generated_j;
            if margin_j < -1e-9 {
                broken[at] += 1;
            }
            if margin_j < worst[at].0 {
                worst[at] = (margin_j, index);
            }
            let forces = [&run.trace.feedback_force_n, &run.trace.tissue_force_n];
            let ratio = forces.map(|force| peak(force)).into_iter().fold(0.0, f64::max) / plain_n.max(1e-9);
            ratios[at].push((ratio, index));
        }
    }
    for (at, scheme) in SCHEMES.into_iter().enumerate() {
        ratios[at].sort_by(|a, b| b.0.total_cmp(&a.0));
        let high = ratios[at].iter().filter(|(ratio, _)| *ratio > 1.5).count();
        let (margin_j, index) = worst[at];
        println!(
            "{scheme}: broken in {} of {cases}, smallest margin {:.4} mJ (case {index}); above 1.5 times the force: {high}, highest {:.2?}",
            broken[at],
            1e3 * margin_j,
            &ratios[at][..ratios[at].len().min(4)]
        );
    }
}
