//! What a tick costs per case when eight run side by side, in each instruction set that the machine has.
//!
//! The scenarios differ in the force scale, the threshold and the seed. The table gives the best and the median of many
//! packs of eight in ns per tick and case, from ready scenarios to metrics: building the engines and laying them side by side
//! is in it. Beside it stands the single run, likewise from a ready scenario to its metrics. Criterion gives the throughput
//! in ticks of one case (elements) a second.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use trocar::engine::InstructionSet;
use trocar::run::{PACK, measure, run_pack_in};
use trocar::scenario::{Scenario, Source};

const TIMED: usize = 200;

/// Eight cases of a shipped scenario.
fn cases(name: &str) -> Vec<Scenario> {
    let path = format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let base = Scenario::load(&Source::parse(&path), &[]).expect("loads");
    let case = |i: usize| {
        let mut case = base.clone();
        case.link.machines.force_scale *= 0.8 + 0.05 * i as f64;
        case.detector.cusum.threshold *= 0.9 + 0.03 * i as f64;
        case.seed = 100 + i as u64;
        case
    };
    (0..PACK).map(case).collect()
}

fn run_in(set: InstructionSet, cases: &[Scenario]) {
    for metrics in black_box(run_pack_in(set, black_box(cases))) {
        metrics.expect("runs");
    }
}

fn run_singly(cases: &[Scenario]) {
    for case in cases {
        black_box(measure(black_box(case)).expect("runs"));
    }
}

/// The shortest and the median of many runs, in ns per tick and case.
fn time_ns(ticks: u64, mut run: impl FnMut()) -> (f64, f64) {
    let mut once = || {
        let start = Instant::now();
        run();
        1e9 * start.elapsed().as_secs_f64() / (ticks as f64 * PACK as f64)
    };
    let mut times: Vec<f64> = (0..TIMED).map(|_| once()).collect();
    times.sort_by(f64::total_cmp);
    (times[0], times[TIMED / 2])
}

const SCENARIOS: [&str; 4] = ["augmented", "classical", "01_through_the_skin", "depth_augmented"];

fn table(_: &mut Criterion) {
    println!("{:<24} {:<10} {:>10} {:>10}", "ns per tick and case", "lanes", "best", "median");
    for name in SCENARIOS {
        let cases = cases(name);
        let ticks = cases[0].grid.ticks();
        let row =
            |lanes: &str, (best, median): (f64, f64)| println!("{name:<24} {lanes:<10} {best:>10.2} {median:>10.2}");
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
            row(&format!("{set:?}"), time_ns(ticks, || run_in(set, &cases)));
        }
        row("single", time_ns(ticks, || run_singly(&cases)));
    }
}

fn lanes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lanes");
    for name in SCENARIOS {
        let cases = cases(name);
        group.throughput(Throughput::Elements(cases[0].grid.ticks() * PACK as u64));
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
            group.bench_function(format!("{name}/{set:?}"), |bencher| bencher.iter(|| run_in(set, &cases)));
        }
        group.bench_function(format!("{name}/single"), |bencher| bencher.iter(|| run_singly(&cases)));
    }
    group.finish();
}

criterion_group!(benches, table, lanes);
criterion_main!(benches);
