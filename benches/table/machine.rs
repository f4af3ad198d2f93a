//! The machine of the measurements.

use std::hint::black_box;

use crate::markdown::Table;
use crate::measured::{available, name_of};
use crate::timing::{elapsed_s, time_ns};

/// Number of rotations, and of exclusive ors, in a measurement of the clock rate.
const STEPS: u64 = 1_000_000;

/// Measures the clock rate in GHz. Assumes that a dependent rotation and exclusive or take one cycle each, as on
/// every x86-64.
fn clock_ghz() -> f64 {
    let step_ns = time_ns(STEPS as f64, || {
        elapsed_s(|| {
            let (mut word, key) = (black_box(1_u64), black_box(0x9e37_79b9_7f4a_7c15_u64));
            for _ in 0..STEPS {
                word = word.rotate_left(7) ^ key;
            }
            black_box(word);
        })
    });
    2.0 / step_ns.best
}

/// Returns the processor's name, from Linux.
fn model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

pub fn section() -> String {
    let mut table = Table::new(2, &["", ""]);
    let mut row = |name: &str, value: String| table.row([name.to_owned(), value]);
    row("processor", model().unwrap_or_else(|| format!("unknown, {}", std::env::consts::ARCH)));
    let processors = std::thread::available_parallelism().map_or_else(|_| "unknown".to_owned(), |n| n.to_string());
    row("hardware threads", processors);
    row("instruction sets", available().map(name_of).collect::<Vec<_>>().join(", "));
    row("clock, from a chain of rotations", format!("{:.2} GHz at best", clock_ghz()));
    table.section("The machine", "The clock is measured in scalar code; it may run slower in wide registers.")
}
