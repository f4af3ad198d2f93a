//! The fraction of the machine's peak performance that a tick reaches.

use trocar::engine::InstructionSet;

use crate::lanes::{PackCost, mode_of};
use crate::markdown::{Table, figure, percent};
use crate::measured::name_of;
use crate::operations::TickCounts;
use crate::peak::Peak;

/// Returns the section on the peaks and the fraction of them that a tick reaches.
pub fn section(peaks: &[Peak], counts: &[TickCounts], costs: &[PackCost]) -> String {
    let mut of_sets = Table::new(1, &["the machine's peak", "operations per ns"]);
    for peak in peaks {
        of_sets.row([name_of(peak.set).to_owned(), figure(peak.operations_per_ns)]);
    }
    let header = [
        "share of the peak",
        "lanes",
        "arithmetic per ns",
        "of the peak",
        "with compare, select, sign",
        "ns at the peak",
    ];
    let mut table = Table::new(2, &header);
    for cost in costs {
        // A single run uses AVX2 if the machine has it.
        let set = cost.set.unwrap_or(InstructionSet::Avx2);
        let Some(peak) = peaks.iter().find(|peak| peak.set == set).or(peaks.last()) else { continue };
        let is_of = |one: &&TickCounts| one.name == cost.name && one.metrics && (one.lanes > 1) == cost.set.is_some();
        let Some(count) = counts.iter().find(is_of) else { continue };
        let per_ns = |operations: f64| operations / cost.ns.best;
        let share = |operations: f64| percent(per_ns(operations) / peak.operations_per_ns);
        let names = [cost.name.to_owned(), mode_of(cost.set).to_owned()];
        let figures = [
            figure(per_ns(count.arithmetic())),
            share(count.arithmetic()),
            share(count.all()),
            figure(count.arithmetic() / peak.operations_per_ns),
        ];
        table.row(names.into_iter().chain(figures));
    }
    let about = "The peak is the rate of independent, unfused multiplications and additions of `f64` in twelve registers in \
         turn, on one thread, measured in the same run. The share is the arithmetic of a tick with metrics, from the \
         count and the best time above, divided by the peak of the instruction set; with compare, select and sign, \
         every operation on vector registers counts. The last column is the time of the arithmetic alone at the peak, \
         in ns per tick and case. Cases one by one are compared with AVX2, for which a single run is compiled. The time \
         includes drawing noise; the operations do not.";
    let text = of_sets.section("The share of the machine's peak", about);
    format!("{text}\n{}", table.text())
}
