//! Lines inside a pair of axes: clipped to their edges, with straight parts merged.

use super::page::Point;

/// The rectangle in which lines are drawn: its size in points and the values at its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) x: (f64, f64),
    pub(super) y: (f64, f64),
    pub(super) width: f64,
    pub(super) height: f64,
}

/// Points closer than this to a straight line are merged into it.
const TOLERANCE: f64 = 0.03;
/// Maximum number of points that are merged into a straight line. It bounds the work.
const MAX_MERGED: usize = 48;
/// Positions are clamped to this many points, so that values such as 1e300 do not overflow.
const FAR: f64 = 1e6;

impl Frame {
    /// Returns the place in points from the top left corner.
    pub(super) fn place(&self, x: f64, y: f64) -> Point {
        let across = (x - self.x.0) / (self.x.1 - self.x.0) * self.width;
        let down = (self.y.1 - y) / (self.y.1 - self.y.0) * self.height;
        (across.clamp(-FAR, FAR), down.clamp(-FAR, FAR))
    }
}

/// Returns the lines through `samples`, which are in axis coordinates. A sample that is not finite breaks the line.
pub(super) fn polylines(samples: impl IntoIterator<Item = Point>, frame: &Frame) -> Vec<Vec<Point>> {
    let mut lines = Lines::default();
    for (x, y) in samples {
        if x.is_finite() && y.is_finite() {
            lines.draw_to(frame.place(x, y), frame);
        } else {
            lines.lift(frame);
        }
    }
    lines.lift(frame);
    lines.done
}

#[derive(Default)]
struct Lines {
    done: Vec<Vec<Point>>,
    open: Vec<Point>,
    pen: Option<Point>,
    is_single: bool,
}

impl Lines {
    fn draw_to(&mut self, at: Point, frame: &Frame) {
        match self.pen {
            None => self.is_single = true,
            Some(from) if from != at => {
                self.is_single = false;
                self.segment(from, at, frame);
            }
            Some(_) => {}
        }
        self.pen = Some(at);
    }

    fn segment(&mut self, from: Point, to: Point, frame: &Frame) {
        let Some((a, b)) = clip(from, to, frame) else {
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

    /// Ends the line. A single sample between gaps becomes a point.
    fn lift(&mut self, frame: &Frame) {
        if let (Some(at), true) = (self.pen.take(), self.is_single)
            && (0.0..=frame.width).contains(&at.0)
            && (0.0..=frame.height).contains(&at.1)
        {
            self.done.push(vec![at]);
        }
        self.is_single = false;
        self.close();
    }

    fn close(&mut self) {
        if self.open.len() > 1 {
            self.done.push(straightened(&self.open));
        }
        self.open.clear();
    }
}

/// Returns the part of a segment inside the frame, or `None` (Liang and Barsky).
fn clip(a: Point, b: Point, frame: &Frame) -> Option<(Point, Point)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, distance) in [(-dx, a.0), (dx, frame.width - a.0), (-dy, a.1), (dy, frame.height - a.1)] {
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

fn straightened(line: &[Point]) -> Vec<Point> {
    let mut kept = vec![line[0]];
    let mut anchor = 0;
    for end in 2..line.len() {
        let between = &line[anchor + 1..end];
        if between.len() >= MAX_MERGED || between.iter().any(|&p| distance(p, line[anchor], line[end]) > TOLERANCE) {
            anchor = end - 1;
            kept.push(line[anchor]);
        }
    }
    kept.push(line[line.len() - 1]);
    kept
}

fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (ox, oy) = (p.0 - a.0, p.1 - a.1);
    let length_squared = dx * dx + dy * dy;
    let t = if length_squared > 0.0 { ((ox * dx + oy * dy) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (ox - t * dx).hypot(oy - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { x: (0.0, 10.0), y: (-1.0, 1.0), width: 500.0, height: 200.0 };

    #[test]
    fn straight_lines_need_two_points() {
        let lines = polylines((0..=1000).map(|k| (f64::from(k) * 0.01, 0.0)), &FRAME);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() < 40, "{}", lines[0].len());
    }

    #[test]
    fn gaps_break_lines_and_single_samples_are_points() {
        let values = [0.0, f64::NAN, 0.5, f64::INFINITY, 0.0, 0.1, f64::NAN];
        let lines = polylines(values.into_iter().enumerate().map(|(k, v)| (k as f64, v)), &FRAME);
        let lengths: Vec<usize> = lines.iter().map(Vec::len).collect();
        assert_eq!(lengths, [1, 1, 2]);
    }

    #[test]
    fn huge_values_leave_and_enter_at_the_edge() {
        let values = [0.0, 1e300, -1e300, 0.0];
        let lines = polylines(values.into_iter().enumerate().map(|(k, v)| (k as f64, v)), &FRAME);
        assert!(lines.iter().flatten().all(|p| (-1e-6..=200.0 + 1e-6).contains(&p.1)));
        assert_eq!(lines.len(), 3);
    }

    #[test]
    fn lines_to_samples_outside_the_window_end_at_its_edges() {
        let lines = polylines([(-10.0, 0.0), (20.0, 0.0)], &FRAME);
        assert_eq!(lines, [vec![(0.0, 100.0), (500.0, 100.0)]]);
    }
}
