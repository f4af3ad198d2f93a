//! The best and the median of many runs.

use std::time::Instant;

/// Time for the measurement of one figure, in s.
const BUDGET_S: f64 = 0.4;
const MIN_RUNS: usize = 5;
const MAX_RUNS: usize = 400;

#[derive(Debug, Clone, Copy)]
pub struct Cost {
    pub best: f64,
    pub median: f64,
}

impl Cost {
    /// Returns the best and the median of at least one figure.
    pub fn of(mut figures: Vec<f64>) -> Self {
        figures.sort_by(f64::total_cmp);
        Self { best: figures[0], median: figures[figures.len() / 2] }
    }

    /// Returns the cost in another unit.
    pub fn per(self, unit: f64) -> Self {
        Self { best: self.best / unit, median: self.median / unit }
    }
}

/// Repeats a run that returns its time in s. Returns the cost in ns per item, with `items` items per run.
pub fn time_ns(items: f64, mut run: impl FnMut() -> f64) -> Cost {
    let begin = Instant::now();
    let mut times = vec![];
    while times.len() < MIN_RUNS || (times.len() < MAX_RUNS && begin.elapsed().as_secs_f64() < BUDGET_S) {
        times.push(1e9 * run());
    }
    Cost::of(times).per(items)
}

/// Returns the time of a call, in s.
pub fn elapsed_s(run: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    run();
    begin.elapsed().as_secs_f64()
}
