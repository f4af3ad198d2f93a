//! The best and the median of many runs.

use std::time::Instant;

/// How long one figure is measured for, in s.
const BUDGET_S: f64 = 0.4;
const FEWEST: usize = 5;
const MOST: usize = 400;

/// What something costs.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Of the quickest run.
    pub best: f64,
    /// Of the run in the middle.
    pub median: f64,
}

impl Cost {
    /// The best and the median of figures, of which there has to be one at least.
    pub fn of(mut figures: Vec<f64>) -> Self {
        figures.sort_by(f64::total_cmp);
        Self { best: figures[0], median: figures[figures.len() / 2] }
    }

    /// The cost in another unit.
    pub fn per(self, unit: f64) -> Self {
        Self { best: self.best / unit, median: self.median / unit }
    }
}

/// Repeats a run, which gives how long it took in s, for a while; gives ns per item of which a run has `items`.
pub fn time_ns(items: f64, mut run: impl FnMut() -> f64) -> Cost {
    let begin = Instant::now();
    let mut times = vec![];
    while times.len() < FEWEST || (times.len() < MOST && begin.elapsed().as_secs_f64() < BUDGET_S) {
        times.push(1e9 * run());
    }
    Cost::of(times).per(items)
}

/// How long something takes, in s.
pub fn elapsed_s(run: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    run();
    begin.elapsed().as_secs_f64()
}
