//! The cost as a function of the number of cases and ticks.

use crate::markdown::{Table, figure};
use crate::shipped::scenario_with;
use crate::sweeps::Sweep;
use crate::timing::Cost;
use crate::whole::full_ns;

/// Duration of each case, in s.
const CASE_S: f64 = 0.1;

fn power(exponent: u32) -> String {
    format!("10{}", ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶"][exponent as usize])
}

/// Measures sweeps of 10² to 10⁶ short cases.
fn cases() -> Table {
    let header = ["cases", "s, best", "ns per tick and case", "ns per tick of each additional case"];
    let mut table = Table::new(1, &header);
    let mut before: Option<(f64, f64)> = None;
    for exponent in 2..=6 {
        let seeds = 10_u64.pow(exponent - 2);
        let sweep = Sweep { axes: (10, 10), seeds, duration_s: CASE_S, noise_n: 0.025, has_cap: false };
        let Cost { best, .. } = sweep.run_s(2, [5, 5, 5, 2, 1][exponent as usize - 2]);
        let items = sweep.case_ticks();
        let additional = before.map_or("—".to_owned(), |(s, of)| figure(1e9 * (best - s) / (items - of)));
        table.row([power(exponent), figure(best), figure(1e9 * best / items), additional]);
        before = Some((best, items));
    }
    table
}

/// Measures single runs of 10² to 10⁶ ticks.
fn ticks() -> Table {
    let mut table = Table::new(1, &["ticks", "µs, best", "ns per tick", "median"]);
    for exponent in 2..=6 {
        let ticks = 10_f64.powi(exponent as i32);
        let duration = format!("simulation.duration_s={}", ticks * 1e-3);
        let scenario = scenario_with("classical", &["operator.kind=sine", "tissue.kind=kelvin-voigt", &duration]);
        assert_eq!(scenario.grid.ticks() as f64, ticks);
        let cost = full_ns(&scenario);
        table.row([power(exponent), figure(1e-3 * ticks * cost.best), figure(cost.best), figure(cost.median)]);
    }
    table
}

pub fn section() -> String {
    let of_cases = cases().section(
        "Cost against cases",
        "`trocar sweep` on two threads, cases of 0.1 s with noise, 10 force scales by 10 thresholds by 1 to 10⁴ seeds: \
         all figures include reading the recording, starting and drawing, except the last column, which is the \
         difference to the row above.",
    );
    let of_ticks = ticks().section(
        "Cost against ticks",
        "A single run with metrics, from a ready engine: a sinusoidal hand motion on Kelvin-Voigt tissue.",
    );
    format!("{of_cases}\n{of_ticks}")
}
