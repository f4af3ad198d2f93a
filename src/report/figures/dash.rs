//! Dashes, cut along the line's length in pixels.

use super::thin::Point;

/// Dashes one line may have; a noisy line, many times longer than its axes are wide, gets longer dashes instead of more.
const MOST_DASHES: f64 = 160.0;

/// Cuts `lines` into the dashes of `pattern` (`on, off, …`); an empty pattern leaves them whole.
pub(super) fn dashed(lines: Vec<Vec<Point>>, pattern: &[f64]) -> Vec<Vec<Point>> {
    let period: f64 = pattern.iter().sum();
    if pattern.len() < 2 || period <= 0.0 {
        return lines;
    }
    let length: f64 = lines.iter().flat_map(|line| line.windows(2)).map(|p| span(p[0], p[1])).sum();
    let stretch = (length / period * (pattern.len() as f64 / 2.0) / MOST_DASHES).max(1.0);
    let mut dashes = Vec::new();
    for line in lines {
        if line.len() == 1 {
            dashes.push(line);
            continue;
        }
        cut(&line, pattern, stretch, &mut dashes);
    }
    dashes
}

fn cut(line: &[Point], pattern: &[f64], stretch: f64, dashes: &mut Vec<Vec<Point>>) {
    let mut phase = 0;
    let mut left = pattern[0] * stretch;
    let mut open = vec![line[0]];
    for pair in line.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        let mut remaining = span(from, to);
        while remaining > left {
            let part = left / remaining;
            from = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
            remaining -= left;
            if phase % 2 == 0 {
                open.push(from);
                dashes.push(std::mem::take(&mut open));
            } else {
                open = vec![from];
            }
            phase = (phase + 1) % pattern.len();
            left = (pattern[phase] * stretch).max(0.5);
        }
        left -= remaining;
        if phase % 2 == 0 {
            open.push(to);
        }
    }
    if open.len() > 1 {
        dashes.push(open);
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
