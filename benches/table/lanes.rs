//! Eight cases side by side, by instruction set.

use std::hint::black_box;

use trocar::engine::InstructionSet;
use trocar::run::{PACK, run_pack_sharing};
use trocar::scenario::Scenario;
use trocar::sensor::NoiseBank;

use crate::markdown::{Table, figure};
use crate::measured::{MEASURED, available, name_of};
use crate::shipped::scenario_with;
use crate::side_by_side::{cases, run_in, run_singly};
use crate::timing::{Cost, elapsed_s, time_ns};

pub struct PackCost {
    pub name: &'static str,
    /// The instruction set; `None` for cases one after the other.
    pub set: Option<InstructionSet>,
    /// The cost, in ns per tick and case.
    pub ns: Cost,
}

pub fn measure() -> Vec<PackCost> {
    let mut costs = vec![];
    for (name, file, settings) in MEASURED {
        let cases = cases(&scenario_with(file, settings));
        let items = cases[0].grid.ticks() as f64 * cases.len() as f64;
        for set in available().filter(|&set| set != InstructionSet::Baseline) {
            let ns = time_ns(items, || elapsed_s(|| run_in(set, &cases)));
            costs.push(PackCost { name, set: Some(set), ns });
        }
        let ns = time_ns(items, || elapsed_s(|| run_singly(&cases)));
        costs.push(PackCost { name, set: None, ns });
    }
    costs
}

/// Measures the scenarios with noise in the widest instruction set. The noise is drawn in advance, as in a sweep that
/// uses a seed at many points.
pub fn measure_with_bank() -> Vec<PackCost> {
    let with_bank = |&(name, file, settings): &(&'static str, &str, &[&str])| {
        let cases = cases(&scenario_with(file, settings));
        let items = cases[0].grid.ticks() as f64 * cases.len() as f64;
        let mut bank = NoiseBank::new(cases.len() * 2 * cases[0].grid.ticks() as usize);
        let ns = time_ns(items, || elapsed_s(|| run_sharing(&mut bank, &cases)));
        PackCost { name, set: Some(InstructionSet::widest()), ns }
    };
    let is_noisy = |name: &str| name.contains("noise") || name.contains("skin");
    MEASURED.iter().filter(|(name, ..)| is_noisy(name)).map(with_bank).collect()
}

fn run_sharing(bank: &mut NoiseBank, cases: &[Scenario]) {
    for metrics in black_box(run_pack_sharing(bank, black_box(cases))) {
        metrics.expect("runs");
    }
}

/// Returns the name of the mode in which a pack runs.
pub fn mode_of(set: Option<InstructionSet>) -> &'static str {
    set.map_or("one by one", name_of)
}

pub fn section(costs: &[PackCost], with_bank: &[PackCost]) -> String {
    let mut table = Table::new(2, &["ns per tick and case", "lanes", "best", "median", "one by one / best"]);
    let drawn_now = costs.iter().map(|cost| (cost, mode_of(cost.set).to_owned()));
    let drawn_in_advance =
        with_bank.iter().map(|cost| (cost, format!("{}, noise drawn in advance", mode_of(cost.set))));
    for (cost, mode) in drawn_now.chain(drawn_in_advance) {
        let single = costs.iter().find(|other| other.name == cost.name && other.set.is_none());
        let gain = single.map_or(f64::NAN, |single| single.ns.best / cost.ns.best);
        let names = [cost.name.to_owned(), mode];
        table.row(names.into_iter().chain([figure(cost.ns.best), figure(cost.ns.median), figure(gain)]));
    }
    let about = format!(
        "{PACK} cases that differ in force scale, threshold and seed, on one thread, from resolved scenarios to \
         metrics, including the construction of the engines and their lanes. Without AVX2 and AVX-512, cases run one by \
         one. Drawing the noise is included, except in the last rows: a sweep draws the noise of a seed once for all \
         its points."
    );
    table.section("Cases side by side", &about)
}
