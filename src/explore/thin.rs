//! Reduces lines to the number of visible points.
//!
//! All lines have the same times. An interval of ticks becomes two points, and each line has its minimum and maximum of the interval
//! there, in their order. No peak is lost, and no peak moves by more than an interval.

use std::ops::Range;

use trocar_report::decimate::extremes;

/// The displayed ticks, and the number of ticks per interval.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Window {
    ticks: Range<usize>,
    interval: usize,
}

impl Window {
    /// Returns the window over some ticks with at most `points` points (at least 2).
    pub(super) fn new(ticks: Range<usize>, points: usize) -> Self {
        let count = ticks.len();
        let interval = if count <= points { 1 } else { count.div_ceil((points / 2).max(1)) };
        Self { ticks, interval }
    }

    /// Returns the number of points of a line.
    pub(super) fn len(&self) -> usize {
        if self.interval == 1 { self.ticks.len() } else { 2 * self.ticks.len().div_ceil(self.interval) }
    }

    fn intervals(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.ticks.clone().step_by(self.interval).map(|start| start..(start + self.interval).min(self.ticks.end))
    }

    /// Returns the ticks of the points.
    pub(super) fn ticks(&self) -> Vec<usize> {
        if self.interval == 1 {
            return self.ticks.clone().collect();
        }
        self.intervals().flat_map(|range| [range.start, range.start + range.len() / 2]).collect()
    }

    /// Appends the points of a line, multiplied by a factor. Points after the end of the line are NaN.
    pub(super) fn line(&self, values: impl Fn(usize) -> f64, length: usize, factor: f64, points: &mut Vec<f32>) {
        let at = |tick: usize| if tick < length { shown(factor * values(tick)) } else { f32::NAN };
        if self.interval == 1 {
            points.extend(self.ticks.clone().map(at));
            return;
        }
        for range in self.intervals() {
            let [min, max, _] = extremes(range.start..range.end.min(length), &values);
            let at = |tick: Option<usize>| tick.map_or(f32::NAN, |tick| shown(factor * values(tick)));
            points.extend(if min <= max { [at(min), at(max)] } else { [at(max), at(min)] });
        }
    }
}

/// Returns a value for the page, or NaN if it is too large to be drawn.
fn shown(value: f64) -> f32 {
    if value.abs() < 1e30 { value as f32 } else { f32::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_peak_is_lost_and_none_moves_far() {
        let values: Vec<f64> = (0..10_001).map(|k| if k == 4321 { 9.0 } else { (k as f64 / 500.0).sin() }).collect();
        let window = Window::new(0..values.len(), 400);
        let mut line = vec![];
        window.line(|tick| values[tick], values.len(), 1.0, &mut line);
        let ticks = window.ticks();
        assert_eq!((line.len(), ticks.len()), (window.len(), window.len()));
        assert!(window.len() <= 402);
        let peak = line.iter().position(|value| *value == 9.0).expect("there");
        assert!(ticks[peak].abs_diff(4321) <= 51, "{}", ticks[peak]);
        assert!(ticks.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn a_short_window_keeps_every_sample_and_missing_values_are_gaps() {
        let values = [1.0, f64::INFINITY, 3.0];
        let window = Window::new(0..5, 400);
        let mut line = vec![];
        window.line(|tick| values[tick], values.len(), 2.0, &mut line);
        assert_eq!((line[0], line[2]), (2.0, 6.0));
        assert!(line[1].is_nan() && line[3].is_nan() && line[4].is_nan());
        let mut thinned = vec![];
        Window::new(0..100, 10).line(|tick| values[tick], values.len(), 1.0, &mut thinned);
        assert!(thinned[2..].iter().all(|value| value.is_nan()));
    }
}
