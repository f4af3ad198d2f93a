//! A tick by component: each runs alone, with its recorded inputs of a whole run.

use std::hint::black_box;

use trocar::detector::{CusumDetector, DetectorSettings, DistanceKind, Hypotheses, SquaredResidual};
use trocar::estimation::Rls;
use trocar::sensor::ForceSensor;

use crate::markdown::{Table, figure};
use crate::parts::{
    Adapting, BothPlants, Detected, Estimated, Nothing, Observed, Part, SlaveMeasurement, Supervised, TissuePart,
};
use crate::record::Inputs;
use crate::shipped::scenario;
use crate::timing::{Cost, elapsed_s, time_ns};
use crate::whole::{bare_ns, full_ns, ready};

/// Ticks per batch. Their inputs fit into the first-level cache, as in a run.
const BATCH: usize = 128;

/// Runs a part, in the instruction set of the engine's single run.
#[allow(unsafe_code, reason = "calling a function that is compiled for an instruction set")]
fn run<P: Part>(part: &mut P, inputs: &[P::Input]) -> u64 {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the check above ensures that the machine has the instructions of the function.
        return unsafe { run_avx2(part, inputs) };
    }
    run_inline(part, inputs)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<P: Part>(part: &mut P, inputs: &[P::Input]) -> u64 {
    run_inline(part, inputs)
}

#[inline(always)]
fn run_inline<P: Part>(part: &mut P, inputs: &[P::Input]) -> u64 {
    let mut bits = 0;
    for input in inputs {
        bits ^= part.tick(input);
    }
    bits
}

/// Measures the cost of a part, in ns per tick.
fn cost_ns<P: Part>(part: &P, inputs: &[P::Input]) -> Cost {
    time_ns(inputs.len() as f64, || {
        let mut part = part.clone();
        let mut spent_s = 0.0;
        for inputs in inputs.chunks(BATCH) {
            // Load the inputs before the timing.
            for input in inputs {
                black_box(*input);
            }
            spent_s += elapsed_s(|| {
                black_box(run(&mut part, inputs));
            });
        }
        spent_s
    })
}

/// Measures the components of a shipped scenario, and its whole run.
fn costs(name: &str) -> Vec<(&'static str, Option<Cost>)> {
    let scenario = scenario(name);
    let (_, observer) = ready(&scenario);
    let inputs = Inputs::of(&scenario);
    let engine = scenario.general_engine::<f64>(0).expect("a shipped scenario builds");
    let tick_s = scenario.grid.tick_s();
    let is_noisy = !scenario.sensor.reads_force_exactly();
    let sensor = SlaveMeasurement(ForceSensor::new(&scenario.sensor, tick_s, scenario.seed, 0));
    let of_kind = |kind| DetectorSettings::for_kind(kind, Hypotheses::default());
    let squared = of_kind(DistanceKind::SquaredResidual);
    let detector = CusumDetector::with_distance(SquaredResidual::new(), &squared, tick_s);
    let adaptive = CusumDetector::new(&of_kind(DistanceKind::Adaptive), tick_s);
    vec![
        ("nothing (the loop)", Some(cost_ns(&Nothing(()), &inputs.sensor))),
        ("both plants, stepped exactly", Some(cost_ns(&BothPlants(engine.plants.clone()), &inputs.plants))),
        ("tissue", Some(cost_ns(&TissuePart(engine.parts.tissue.clone()), &inputs.tissue))),
        ("force sensor with noise", is_noisy.then(|| cost_ns(&sensor, &inputs.sensor))),
        ("estimator", Some(cost_ns(&Estimated(Rls::new(&scenario.estimator)), &inputs.estimator))),
        ("detector", Some(cost_ns(&Detected(detector), &inputs.detector))),
        ("adaptive detector, in its place", Some(cost_ns(&Adapting(adaptive), &inputs.detector))),
        ("supervisor", Some(cost_ns(&Supervised(engine.parts.supervisor.clone()), &inputs.supervisor))),
        ("metrics", Some(cost_ns(&Observed(observer), &inputs.observer))),
        ("the whole tick without metrics", Some(bare_ns(&scenario))),
        ("the whole tick", Some(full_ns(&scenario))),
    ]
}

pub fn section() -> String {
    let header = ["ns per tick", "augmented, best", "median", "through the skin, best", "median"];
    let mut table = Table::new(1, &header);
    for ((name, replayed), (_, layered)) in costs("augmented").into_iter().zip(costs("layers/through-the-skin")) {
        let cells = |cost: Option<Cost>| {
            cost.map_or(["—".to_owned(), "—".to_owned()], |cost| [figure(cost.best), figure(cost.median)])
        };
        table.row([name.to_owned()].into_iter().chain(cells(replayed)).chain(cells(layered)));
    }
    let about = format!(
        "A single run. Each component runs alone with its recorded inputs of a whole run, {BATCH} ticks at a time; the \
         time includes the clock and the loop. In the engine a component waits for the previous one and overlaps with \
         others, so the whole tick is not their sum. The tissue of `augmented` is a recorded force, that of \
         `layers/through-the-skin` has five layers; here it is called, in the engine it is inlined."
    );
    table.section("A tick by component", &about)
}
