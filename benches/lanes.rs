//! The cost of a tick per case with eight cases side by side, in each available instruction set.
//!
//! Measures from resolved scenarios to metrics, including the construction of the engines and their lanes, and
//! compares with the same cases one after the other. Criterion reports the throughput in ticks of one case (elements)
//! per second; `cargo bench --bench table` reports ns.

#[path = "table/shipped.rs"]
mod shipped;
#[path = "table/side_by_side.rs"]
mod side_by_side;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use trocar::engine::InstructionSet;
use trocar::run::PACK;

use shipped::scenario;
use side_by_side::{cases, run_in, run_singly};

const SCENARIOS: [&str; 4] = ["augmented", "classical", "layers/through-the-skin", "paper/depth-augmented"];

fn lanes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lanes");
    for name in SCENARIOS {
        let cases = cases(&scenario(name));
        group.throughput(Throughput::Elements(cases[0].grid.ticks() * PACK as u64));
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_available()) {
            group.bench_function(format!("{name}/{set:?}"), |bencher| bencher.iter(|| run_in(set, &cases)));
        }
        group.bench_function(format!("{name}/single"), |bencher| bencher.iter(|| run_singly(&cases)));
    }
    group.finish();
}

criterion_group!(benches, lanes);
criterion_main!(benches);
