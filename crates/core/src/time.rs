//! Tick `k` happens at `k * tick_s`, never at a sum of increments.

use crate::error::{InvalidValue, positive, require};

/// In ticks.
const WHOLE_TICK_TOLERANCE: f64 = 1e-6;

/// `k * tick_s` stays exact far beyond it.
const MAX_TICKS: f64 = 1e9;

/// A regular grid of ticks from time 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickGrid {
    tick_s: f64,
    ticks: u64,
    /// If the tick is exactly its inverse.
    rate_hz: Option<f64>,
}

impl TickGrid {
    /// The number of ticks, 1 to 10⁹, is the one nearest to `duration_s`; both in s.
    pub fn new(tick_s: f64, duration_s: f64) -> Result<Self, InvalidValue> {
        positive("simulation.tick_s", tick_s)?;
        positive("simulation.duration_s", duration_s)?;
        let ticks = libm::round(duration_s / tick_s);
        require("simulation.duration_s", duration_s, ticks >= 1.0, "at least one tick")?;
        require("simulation.duration_s", duration_s, ticks <= MAX_TICKS, "at most 1e9 ticks")?;
        let rate = libm::round(1.0 / tick_s);
        Ok(Self { tick_s, ticks: ticks as u64, rate_hz: (1.0 / rate == tick_s).then_some(rate) })
    }

    /// The length of a tick in s.
    #[must_use]
    pub fn tick_s(&self) -> f64 {
        self.tick_s
    }

    /// The number of ticks.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Rounded once: 0.069 and not 0.06900000000000001 if the rate is whole.
    #[inline]
    #[must_use]
    pub fn time_s(&self, k: u64) -> f64 {
        self.rate_hz.map_or(k as f64 * self.tick_s, |rate| k as f64 / rate)
    }
}

/// At least 0.
#[must_use]
pub fn nearest_ticks(duration_s: f64, tick_s: f64) -> u64 {
    libm::round(duration_s / tick_s).max(0.0) as u64
}

/// `None` unless it is whole to within a millionth of a tick.
#[must_use]
pub fn whole_ticks(duration_s: f64, tick_s: f64) -> Option<u64> {
    let ticks = duration_s / tick_s;
    let whole = libm::round(ticks);
    ((ticks - whole).abs() <= WHOLE_TICK_TOLERANCE && (0.0..=MAX_TICKS).contains(&whole)).then_some(whole as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_a_tick_is_not_an_accumulated_sum() {
        let grid = TickGrid::new(0.1, 1e5).expect("valid");
        assert_eq!(grid.ticks(), 1_000_000);
        assert_eq!(grid.time_s(999_999), 99_999.9);
    }

    #[test]
    fn a_fraction_of_a_tick_is_not_whole() {
        assert_eq!(whole_ticks(0.005, 0.001), Some(5));
        assert_eq!(whole_ticks(0.0037, 0.001), None);
        assert_eq!(whole_ticks(-0.001, 0.001), None);
        assert_eq!(whole_ticks(f64::NAN, 0.001), None);
    }

    #[test]
    fn a_grid_without_ticks_is_refused() {
        for (tick, duration) in
            [(0.0, 1.0), (f64::NAN, 1.0), (1e-3, 0.0), (1e-3, 1e-5), (1e-12, 1.0), (1.0, f64::INFINITY)]
        {
            assert!(TickGrid::new(tick, duration).is_err(), "{tick} {duration}");
        }
    }
}
