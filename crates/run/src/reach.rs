use trocar_core::time::{TickGrid, nearest_ticks};
use trocar_engine::engine::Trace;
use trocar_metrics::{Metrics, RuptureMetrics};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    pub deepest_m: f64,
    pub is_untouched: bool,
    /// After the last rupture.
    pub last_force_n: f64,
}

impl Reach {
    pub(super) fn of(grid: &TickGrid, metrics: &Metrics, trace: &Trace) -> Option<Self> {
        let tick_after = |rupture: &RuptureMetrics| nearest_ticks(rupture.time_s, grid.tick_s()) as usize + 1;
        let first = metrics.ruptures.last().map_or(0, tick_after);
        Some(Self {
            deepest_m: trace.slave_position_m.iter().copied().reduce(f64::max)?,
            is_untouched: trace.tissue_force_n.iter().all(|force_n| *force_n == 0.0),
            last_force_n: trace.tissue_force_n.iter().skip(first).copied().fold(0.0, f64::max),
        })
    }
}
