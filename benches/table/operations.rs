//! The number of operations of a tick, counted during a run.

use trocar::engine::Observer;
use trocar::metrics::MetricsObserver;
use trocar::run::PACK;
use trocar::scenario::Scenario;

use crate::counted::{Counted, Counts};
use crate::markdown::{Table, figure};
use crate::measured::MEASURED;
use crate::shipped::scenario_with;

/// The average operations of a tick over a run.
pub struct TickCounts {
    pub name: &'static str,
    /// Number of cases side by side.
    pub lanes: usize,
    /// True if metrics are included.
    pub metrics: bool,
    counts: Counts,
    ticks: f64,
}

impl TickCounts {
    fn per_tick(&self, count: u64) -> f64 {
        count as f64 / self.ticks
    }

    /// Returns the additions, subtractions, multiplications, divisions, roots and extremes per tick.
    pub fn arithmetic(&self) -> f64 {
        let Counts { add, mul, div, extreme, .. } = self.counts;
        self.per_tick(add + mul + div + extreme)
    }

    /// Returns all operations on vector registers per tick: arithmetic, comparisons, selections and signs.
    pub fn all(&self) -> f64 {
        self.arithmetic() + self.per_tick(self.counts.select + self.counts.sign)
    }
}

fn counts_of<const N: usize>(scenario: &Scenario, observer: &mut impl Observer<Counted<N>>) -> Counts {
    let mut engine = scenario.exact_engine::<Counted<N>>(0).expect("a shipped scenario builds");
    Counts::take();
    engine.run(observer).expect("runs");
    Counts::take()
}

fn with_and_without<const N: usize>(name: &'static str, scenario: &Scenario) -> [TickCounts; 2] {
    let ticks = scenario.grid.ticks() as f64;
    let mut observer = MetricsObserver::<Counted<N>>::new(scenario.grid, scenario.rupture_times_s().len());
    let of = |metrics, counts| TickCounts { name, lanes: N, metrics, counts, ticks };
    [of(false, counts_of::<N>(scenario, &mut ())), of(true, counts_of::<N>(scenario, &mut observer))]
}

/// Counts the measured scenarios, single and side by side, without and with metrics.
pub fn count() -> Vec<TickCounts> {
    let of = |(name, file, settings)| {
        let scenario = scenario_with(file, settings);
        with_and_without::<1>(name, &scenario).into_iter().chain(with_and_without::<PACK>(name, &scenario))
    };
    MEASURED.into_iter().flat_map(of).collect()
}

pub fn section(all: &[TickCounts]) -> String {
    let header = [
        "operations per tick",
        "cases",
        "metrics",
        "+ −",
        "×",
        "÷ √",
        "min max",
        "sign",
        "compare, select",
        "masks",
        "arithmetic",
    ];
    let mut table = Table::new(3, &header);
    for one in all {
        let Counts { add, mul, div, extreme, sign, select, mask } = one.counts;
        let names =
            [one.name.to_owned(), one.lanes.to_string(), if one.metrics { "with" } else { "without" }.to_owned()];
        let counts = [add, mul, div, extreme, sign, select, mask].map(|count| figure(one.per_tick(count)));
        table.row(names.into_iter().chain(counts).chain([figure(one.arithmetic())]));
    }
    let about = format!(
        "Counted by running the engine with a number type that counts (`benches/table/counted.rs`), averaged over the \
         run. {PACK} cases side by side share each operation, so a figure per tick and case does not depend on the \
         lanes; they need more operations because what one case needs is done for all, and differ here in their noise \
         only. The count is that of the source: the compiler removes unused operations, such as the fourth row of the \
         slave's matrix where cases are side by side (four multiplications and three additions). Drawing noise, integer \
         operations, and operations per lane around an event are not counted. Arithmetic is the first four columns."
    );
    table.section("The operations of a tick", &about)
}
