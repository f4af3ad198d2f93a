//! The visible parts of lines, in the coordinates of a pair of axes.

use trocar_document::figure::{Axis, Point};

/// Points are clamped to this many axis ranges around an axis: values such as 1e300 would overflow.
const FAR: f64 = 1e6;

/// A non-finite sample breaks the line. A single sample between gaps is a line with one point.
pub(super) fn visible(samples: impl IntoIterator<Item = Point>, x: &Axis, y: &Axis) -> Vec<Vec<Point>> {
    let mut lines = Lines { x, y, done: vec![], open: vec![], pen: None, is_single: false };
    for at in samples {
        if at.0.is_finite() && at.1.is_finite() {
            lines.draw_to((near(at.0, x), near(at.1, y)));
        } else {
            lines.lift();
        }
    }
    lines.lift();
    lines.done
}

fn near(place: f64, axis: &Axis) -> f64 {
    let reach = FAR * (axis.high - axis.low);
    place.clamp(axis.low - reach, axis.high + reach)
}

struct Lines<'a> {
    x: &'a Axis,
    y: &'a Axis,
    done: Vec<Vec<Point>>,
    open: Vec<Point>,
    pen: Option<Point>,
    is_single: bool,
}

impl Lines<'_> {
    fn draw_to(&mut self, at: Point) {
        match self.pen {
            None => self.is_single = true,
            Some(from) if from != at => {
                self.is_single = false;
                self.segment(from, at);
            }
            Some(_) => {}
        }
        self.pen = Some(at);
    }

    fn segment(&mut self, from: Point, to: Point) {
        let Some((a, b)) = clip(from, to, self.x, self.y) else {
            self.close();
            return;
        };
        if self.open.last() != Some(&a) {
            self.close();
            self.open.push(a);
        }
        self.open.push(b);
        if b != to {
            self.close();
        }
    }

    fn lift(&mut self) {
        if let (Some(at), true) = (self.pen.take(), self.is_single)
            && (self.x.low..=self.x.high).contains(&at.0)
            && (self.y.low..=self.y.high).contains(&at.1)
        {
            self.done.push(vec![at]);
        }
        self.is_single = false;
        self.close();
    }

    fn close(&mut self) {
        if self.open.len() > 1 {
            self.done.push(std::mem::take(&mut self.open));
        }
        self.open.clear();
    }
}

/// `None` if it is outside (Liang and Barsky).
fn clip(a: Point, b: Point, x: &Axis, y: &Axis) -> Option<(Point, Point)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, distance) in [(-dx, a.0 - x.low), (dx, x.high - a.0), (-dy, a.1 - y.low), (dy, y.high - a.1)] {
        if slope == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if slope < 0.0 {
            enter = enter.max(distance / slope);
        } else {
            leave = leave.min(distance / slope);
        }
    }
    if enter > leave {
        return None;
    }
    let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    Some((start, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(samples: impl IntoIterator<Item = Point>) -> Vec<Vec<Point>> {
        visible(samples, &Axis::exact((0.0, 10.0), 0), &Axis::exact((-1.0, 1.0), 0))
    }

    fn of(values: &[f64]) -> Vec<Vec<Point>> {
        lines(values.iter().enumerate().map(|(k, v)| (k as f64, *v)))
    }

    #[test]
    fn gaps_break_lines_and_single_samples_are_points() {
        let lines = of(&[0.0, f64::NAN, 0.5, f64::INFINITY, 0.0, 0.1, f64::NAN]);
        let lengths: Vec<usize> = lines.iter().map(Vec::len).collect();
        assert_eq!(lengths, [1, 1, 2]);
    }

    #[test]
    fn huge_values_leave_and_enter_at_the_edge() {
        let lines = of(&[0.0, 1e300, -1e300, 0.0]);
        assert!(lines.iter().flatten().all(|p| (-1.0 - 1e-9..=1.0 + 1e-9).contains(&p.1)));
        assert_eq!(lines.len(), 3);
    }

    #[test]
    fn lines_to_samples_outside_the_window_end_at_its_edges() {
        assert_eq!(lines([(-10.0, 0.0), (20.0, 0.0)]), [[(0.0, 0.0), (10.0, 0.0)]]);
    }
}
