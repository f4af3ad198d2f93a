//! Eight cases side by side, by instruction set.

use std::hint::black_box;

use trocar::engine::InstructionSet;
use trocar::run::{PACK, measure as measure_one, run_pack_in};
use trocar::scenario::Scenario;

use crate::markdown::{Table, figure};
use crate::shipped::{MEASURED, available, name_of, scenario_with};
use crate::timing::{Cost, elapsed_s, time_ns};

/// What a pack of a scenario costs; without a set, its cases one after the other.
pub struct PackCost {
    /// Which of the measured scenarios.
    pub name: &'static str,
    /// In which instruction set, where side by side.
    pub set: Option<InstructionSet>,
    /// In ns per tick and case.
    pub ns: Cost,
}

/// Cases that differ in the force scale, the threshold and the seed.
fn cases(base: &Scenario) -> Vec<Scenario> {
    let case = |i: usize| {
        let mut case = base.clone();
        case.link.machines.force_scale *= 0.8 + 0.05 * i as f64;
        case.detector.cusum.threshold *= 0.9 + 0.03 * i as f64;
        case.seed = 100 + i as u64;
        case
    };
    (0..PACK).map(case).collect()
}

/// Every measured scenario in every instruction set, and singly.
pub fn measure() -> Vec<PackCost> {
    let mut costs = vec![];
    for (name, file, settings) in MEASURED {
        let cases = cases(&scenario_with(file, settings));
        let items = cases[0].grid.ticks() as f64 * cases.len() as f64;
        for set in available().filter(|&set| set != InstructionSet::Baseline) {
            let ns = time_ns(items, || {
                elapsed_s(|| {
                    for metrics in black_box(run_pack_in(set, black_box(&cases))) {
                        metrics.expect("runs");
                    }
                })
            });
            costs.push(PackCost { name, set: Some(set), ns });
        }
        let ns = time_ns(items, || {
            elapsed_s(|| {
                for case in &cases {
                    black_box(measure_one(black_box(case)).expect("runs"));
                }
            })
        });
        costs.push(PackCost { name, set: None, ns });
    }
    costs
}

/// How a pack is run.
pub fn way_of(set: Option<InstructionSet>) -> &'static str {
    set.map_or("one by one", name_of)
}

/// What packs cost.
pub fn section(costs: &[PackCost]) -> String {
    let mut table = Table::new(2, &["ns per tick and case", "lanes", "best", "median", "one by one / best"]);
    for cost in costs {
        let single = costs.iter().find(|other| other.name == cost.name && other.set.is_none());
        let gain = single.map_or(f64::NAN, |single| single.ns.best / cost.ns.best);
        let names = [cost.name.to_owned(), way_of(cost.set).to_owned()];
        table.row(names.into_iter().chain([figure(cost.ns.best), figure(cost.ns.median), figure(gain)]));
    }
    let about = format!(
        "{PACK} cases that differ in force scale, threshold and seed, on one thread, from ready scenarios to metrics: \
         building the engines and laying them side by side is in it. Without AVX2 and AVX-512, cases run one by one."
    );
    table.section("Cases side by side", &about)
}
