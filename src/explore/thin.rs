//! Lines with no more points than a picture shows.
//!
//! All lines of a page share their times, as its charts do: a stretch of ticks becomes two points, and each line puts its
//! least and its greatest value there in the order in which they come. So no peak is lost, and none moves by more than a
//! stretch.

use std::ops::Range;

/// Which ticks are shown, and in stretches of how many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Window {
    ticks: Range<usize>,
    stretch: usize,
}

impl Window {
    /// The window over some ticks in at most `points` points, at least 2.
    pub(super) fn new(ticks: Range<usize>, points: usize) -> Self {
        let count = ticks.len();
        let stretch = if count <= points { 1 } else { count.div_ceil((points / 2).max(1)) };
        Self { ticks, stretch }
    }

    /// How many points a line has.
    pub(super) fn len(&self) -> usize {
        if self.stretch == 1 { self.ticks.len() } else { 2 * self.ticks.len().div_ceil(self.stretch) }
    }

    fn stretches(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.ticks.clone().step_by(self.stretch).map(|start| start..(start + self.stretch).min(self.ticks.end))
    }

    /// The ticks at which the points stand.
    pub(super) fn ticks(&self) -> Vec<usize> {
        if self.stretch == 1 {
            return self.ticks.clone().collect();
        }
        self.stretches().flat_map(|range| [range.start, range.start + range.len() / 2]).collect()
    }

    /// A line's points, multiplied by a factor, after its end not a number.
    pub(super) fn line(&self, values: impl Fn(usize) -> f64, length: usize, factor: f64, points: &mut Vec<f32>) {
        let at = |tick: usize| if tick < length { shown(factor * values(tick)) } else { f32::NAN };
        if self.stretch == 1 {
            points.extend(self.ticks.clone().map(at));
            return;
        }
        for range in self.stretches() {
            let (mut least, mut greatest) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
            for tick in range.start..range.end.min(length) {
                let value = values(tick);
                if value < least.1 {
                    least = (tick, value);
                }
                if value > greatest.1 {
                    greatest = (tick, value);
                }
            }
            let pair = [shown(factor * least.1), shown(factor * greatest.1)];
            points.extend(if least.0 <= greatest.0 { pair } else { [pair[1], pair[0]] });
        }
    }
}

/// A value as the page gets it: nothing beyond what can be drawn.
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
    fn a_short_stretch_is_shown_as_it_is_and_what_is_not_there_is_a_gap() {
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
