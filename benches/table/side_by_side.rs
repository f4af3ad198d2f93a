//! Runs cases side by side, and one after the other.

use std::hint::black_box;

use trocar::engine::InstructionSet;
use trocar::run::{PACK, measure, run_pack_in};
use trocar::scenario::Scenario;

/// Returns cases that differ in the force scale, the threshold and the seed.
pub fn cases(base: &Scenario) -> Vec<Scenario> {
    let case = |i: usize| {
        let mut case = base.clone();
        case.link.machines.force_scale *= 0.8 + 0.05 * i as f64;
        case.detector.cusum.threshold *= 0.9 + 0.03 * i as f64;
        case.seed = 100 + i as u64;
        case
    };
    (0..PACK).map(case).collect()
}

pub fn run_in(set: InstructionSet, cases: &[Scenario]) {
    for metrics in black_box(run_pack_in(set, black_box(cases))) {
        metrics.expect("runs");
    }
}

pub fn run_singly(cases: &[Scenario]) {
    for case in cases {
        black_box(measure(black_box(case)).expect("runs"));
    }
}
