//! Dashes along the length of a line in pixels.

use tiny_skia::{Path, PathBuilder, PathSegment, StrokeDash};

use super::thin::Point;

/// Maximum number of dashes of a line. A noisy or swinging line is much longer than its axes are wide. It is solid: with longer
/// dashes, gaps would hide some swings and not others, so that a steady swing would appear to beat.
const MAX_DASHES: f32 = 256.0;

/// Cuts `lines` into the dashes of `pattern` (`on, off, …`). An empty pattern, and lines of more than [`MAX_DASHES`], are solid.
pub(super) fn dashed(lines: Vec<Vec<Point>>, pattern: &[f32]) -> Vec<Vec<Point>> {
    let length: f64 = lines.iter().flat_map(|line| line.windows(2)).map(|p| span(p[0], p[1])).sum();
    let period: f32 = pattern.iter().sum();
    if length as f32 / period * (pattern.len() as f32 / 2.0) > MAX_DASHES {
        return lines;
    }
    let Some(dash) = StrokeDash::new(pattern.to_vec(), 0.0) else { return lines };
    let mut dashes = Vec::new();
    for line in lines {
        match path(&line).and_then(|path| path.dash(&dash, 1.0)) {
            Some(cut) => pieces(&cut, &mut dashes),
            None => dashes.push(line),
        }
    }
    dashes
}

fn path(line: &[Point]) -> Option<Path> {
    let mut path = PathBuilder::new();
    let (first, rest) = line.split_first()?;
    path.move_to(first.0 as f32, first.1 as f32);
    rest.iter().for_each(|at| path.line_to(at.0 as f32, at.1 as f32));
    path.finish()
}

fn pieces(path: &Path, pieces: &mut Vec<Vec<Point>>) {
    for segment in path.segments() {
        match (segment, pieces.last_mut()) {
            (PathSegment::MoveTo(at), _) => pieces.push(vec![(at.x.into(), at.y.into())]),
            (PathSegment::LineTo(at), Some(piece)) => piece.push((at.x.into(), at.y.into())),
            _ => {}
        }
    }
}

fn span(a: Point, b: Point) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_follow_the_length() {
        let dashes = dashed(vec![vec![(0.0, 0.0), (25.0, 0.0), (50.0, 0.0)]], &[10.0, 10.0]);
        assert_eq!(dashes.len(), 3);
        assert_eq!(dashes[1], [(20.0, 0.0), (25.0, 0.0), (30.0, 0.0)]);
    }

    #[test]
    fn every_drawn_point_is_on_the_line_and_a_steady_swing_keeps_its_height() {
        for swings in [2.0, 20.0, 200.0] {
            let height = |x: f64| 100.0 * (x * swings * std::f64::consts::TAU / 800.0).sin();
            let line: Vec<Point> = (0..8000).map(|k| 0.1 * f64::from(k)).map(|x| (x, height(x))).collect();
            let dashes = dashed(vec![line], &[6.0, 4.0]);
            assert!(dashes.iter().flatten().all(|(x, y)| (y - height(*x)).abs() < 1.0), "{swings}");
            // In each tenth of the axis the peaks of a fast swing are there.
            let reaches = |tenth: usize| {
                let part = |at: &&Point| (at.0 / 80.0) as usize == tenth;
                dashes.iter().flatten().filter(part).any(|(_, y)| y.abs() > 95.0)
            };
            assert!(swings < 20.0 || (0..10).all(reaches), "{swings}");
        }
    }
}
