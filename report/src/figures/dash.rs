//! Dashes along the length of a line in pixels.

use tiny_skia::{Path, PathBuilder, PathSegment, StrokeDash};

use super::thin::Point;

/// Maximum number of dashes of a line. A noisy line is much longer than its axes are wide; it has longer dashes, not more.
const MAX_DASHES: f32 = 64.0;

/// Cuts `lines` into the dashes of `pattern` (`on, off, …`). An empty pattern gives solid lines.
pub(super) fn dashed(lines: Vec<Vec<Point>>, pattern: &[f32]) -> Vec<Vec<Point>> {
    let length: f64 = lines.iter().flat_map(|line| line.windows(2)).map(|p| span(p[0], p[1])).sum();
    let period: f32 = pattern.iter().sum();
    let factor = (length as f32 / period * (pattern.len() as f32 / 2.0) / MAX_DASHES).max(1.0);
    let Some(dash) = StrokeDash::new(pattern.iter().map(|part| part * factor).collect(), 0.0) else { return lines };
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
    fn a_noisy_line_has_a_bounded_number_of_dashes() {
        let noisy = (0..2000).map(|k| (f64::from(k), f64::from(k % 2) * 300.0)).collect();
        assert!(dashed(vec![noisy], &[5.0, 5.0]).len() < 200);
    }
}
