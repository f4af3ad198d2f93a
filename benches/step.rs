//! The cost of a step of the rig's controller, on the signals of the shipped insertion.
//!
//! The table shows the best and the median of many passes over the insertion, in ns per step, without the time to
//! read the clock. `augmented` includes the events, `classical` lacks their effect, and `motionless` has noise that
//! makes the estimator correct at most samples.

use std::hint::black_box;
use std::time::Instant;

use trocar::rig::{HapticController, Sample, Settings};
use trocar::scenario::{Scenario, Source};

const PASSES: usize = 300;

/// Returns the controller of a shipped scenario and the samples of its run.
fn replay(name: &str) -> (HapticController, Vec<Sample>) {
    let scenario = Scenario::load(&Source::parse(name), &[]).expect("loads");
    let controller = HapticController::new(&scenario.rig_settings()).expect("valid");
    let trace = trocar::run::run(scenario).expect("runs").trace;
    let sample = |k: usize| Sample {
        master_position_m: trace.master_position_m[k],
        slave_position_m: trace.slave_position_m[k],
        slave_velocity_m_per_s: trace.slave_velocity_m_per_s[k],
        force_n: trace.measured_force_n[k],
    };
    (controller, (0..trace.len()).map(sample).collect())
}

/// Returns a needle at rest in the tissue, with a force that varies by ±0.1 N.
fn motionless() -> (HapticController, Vec<Sample>) {
    let varying = |k: u32| 5.0 + 0.1 * f64::from(k).sin();
    let sample = |k| Sample {
        master_position_m: 0.02,
        slave_position_m: 0.02,
        slave_velocity_m_per_s: 0.0,
        force_n: varying(k),
    };
    let controller = HapticController::new(&Settings { start_m: 0.02, ..Settings::default() }).expect("valid");
    (controller, (0..15_000).map(sample).collect())
}

fn cases() -> [(&'static str, (HapticController, Vec<Sample>)); 3] {
    [("classical", replay("paper/classical")), ("augmented", replay("paper/augmented")), ("motionless", motionless())]
}

/// Runs the controller over the samples. `black_box` keeps the compiler from removing any part of a command.
fn pass(controller: &mut HapticController, samples: &[Sample]) {
    for sample in samples {
        black_box(controller.step(black_box(sample)));
    }
}

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        // Built and started by `cargo test --benches`, too.
        return;
    }
    println!("{:<14}{:>10}{:>10}", "ns per step", "best", "median");
    for (name, (controller, samples)) in cases() {
        let time_ns = |_| {
            let mut controller = controller.clone();
            let start = Instant::now();
            pass(&mut controller, &samples);
            1e9 * start.elapsed().as_secs_f64() / samples.len() as f64
        };
        let mut times: Vec<f64> = (0..PASSES).map(time_ns).collect();
        times.sort_by(f64::total_cmp);
        println!("{name:<14}{:>10.2}{:>10.2}", times[0], times[PASSES / 2]);
    }
}
