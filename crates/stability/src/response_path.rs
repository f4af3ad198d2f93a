//! The loop gain along the upper half of a circle, in segments.
//!
//! `L(z) = H(z) z^-N`, with `H` the product of both responses. Only `H` determines the segments: the delay turns `L` by
//! exactly `-N Δω` and changes its magnitude by `r^-N`.

use std::f64::consts::PI;

use super::{ClosedLoop, StabilityError};
use trocar_lti::Complex64;

const MAX_EVALUATIONS: usize = 1_000_000;

/// `ln |L|` below which `L` cannot move `1 - L` around 0.
const LN_SMALL: f64 = -1.386_294_361_119_890_6;

/// Largest change of `H` in a segment, relative to its smaller end.
const RESOLVED: f64 = 0.5;

/// Largest `|ln |L||` at the ends of a segment with a crossing.
const LN_NEAR: f64 = 0.7;

const MIN_WIDTH: f64 = 1e-14;

const BISECTIONS: usize = 60;

#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) angle_rad: f64,
    /// `H`.
    pub(super) sides: Complex64,
    /// May overflow.
    pub(super) gain: Complex64,
    pub(super) ln_gain: f64,
}

/// `|L|` stays on one side of 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) from: Point,
    pub(super) to: Point,
    pub(super) is_large: bool,
}

pub(super) struct Path<'a> {
    closed: &'a ClosedLoop,
    radius: f64,
    ticks: f64,
    /// `-N ln r`.
    ln_delay: f64,
    /// `ln |L|` below which the path is not resolved.
    ln_small: f64,
}

impl<'a> Path<'a> {
    pub(super) fn new(closed: &'a ClosedLoop, radius: f64) -> Self {
        let ticks = closed.round_trip_ticks() as f64;
        Self { closed, radius, ticks, ln_delay: -ticks * radius.ln(), ln_small: LN_SMALL }
    }

    pub(super) fn down_to(self, magnitude: f64) -> Self {
        Self { ln_small: magnitude.ln(), ..self }
    }

    pub(super) fn at(&self, angle_rad: f64) -> Point {
        let z = Complex64::from_polar(self.radius, angle_rad);
        let [master, slave] = self.closed.responses_at(z);
        let sides = master * slave;
        let gain = sides * Complex64::from_polar(self.ln_delay.exp(), -self.ticks * angle_rad);
        Point { angle_rad, sides, gain, ln_gain: sides.norm().ln() + self.ln_delay }
    }

    /// `z H'(z) / H(z)`: the imaginary part is `-d ln |L| / dω`, the real part minus `N` is `d arg L / dω`.
    fn slope(&self, angle_rad: f64) -> Complex64 {
        let z = Complex64::from_polar(self.radius, angle_rad);
        let [master, slave] = self.closed.relative_slopes_at(z);
        z * (master + slave)
    }

    pub(super) fn walk(&self, mut each: impl FnMut(Segment)) -> Result<(), StabilityError> {
        self.resolve(|from, to| self.split(from, to, &mut each))
    }

    pub(super) fn unit_crossings(&self, mut each: impl FnMut(Point)) -> Result<(), StabilityError> {
        let mut last = None;
        self.walk(|Segment { from, is_large, .. }| {
            if last.replace(is_large).is_some_and(|was_large| was_large != is_large) {
                each(from);
            }
        })
    }

    pub(super) fn resolve(&self, mut each: impl FnMut(Point, Point)) -> Result<(), StabilityError> {
        let mut evaluations = 0;
        let mut last: Option<Point> = None;
        let mut open: Vec<Point> = vec![];
        for angle_rad in self.angles() {
            let end = self.at(angle_rad);
            if !end.sides.is_finite() {
                continue;
            }
            let Some(mut from) = last.replace(end) else { continue };
            open.clear();
            open.push(end);
            while let Some(&to) = open.last() {
                let is_small = from.ln_gain < self.ln_small && to.ln_gain < self.ln_small;
                let smaller = from.sides.norm_sqr().min(to.sides.norm_sqr());
                let is_resolved = (to.sides - from.sides).norm_sqr() < RESOLVED * RESOLVED * smaller;
                if is_small || is_resolved || to.angle_rad - from.angle_rad < MIN_WIDTH {
                    each(from, to);
                    from = to;
                    open.pop();
                    continue;
                }
                evaluations += 1;
                if evaluations > MAX_EVALUATIONS {
                    return Err(StabilityError::TooFast { evaluations });
                }
                open.push(self.at(0.5 * (from.angle_rad + to.angle_rad)));
            }
        }
        Ok(())
    }

    fn split(&self, from: Point, to: Point, each: &mut impl FnMut(Segment)) {
        let (is_large, becomes_large) = (from.ln_gain >= 0.0, to.ln_gain >= 0.0);
        if is_large != becomes_large {
            let at = self.bisect(&from, &to, |point| point.ln_gain >= 0.0);
            each(Segment { from, to: at, is_large });
            each(Segment { from: at, to, is_large: becomes_large });
            return;
        }
        let is_near = |point: &Point| point.ln_gain.abs() < LN_NEAR;
        let extremum = (is_near(&from) || is_near(&to)).then(|| self.extremum(&from, &to, is_large)).flatten();
        match extremum.filter(|point| (point.ln_gain >= 0.0) != is_large) {
            Some(middle) => {
                self.split(from, middle, each);
                self.split(middle, to, each);
            }
            None => each(Segment { from, to, is_large }),
        }
    }

    fn extremum(&self, from: &Point, to: &Point, minimum: bool) -> Option<Point> {
        // True before the extremum, by the sign of d ln |L| / dω.
        let approaches = |angle_rad: f64| {
            let rises = -self.slope(angle_rad).im;
            if minimum { rises < 0.0 } else { rises > 0.0 }
        };
        (approaches(from.angle_rad) && !approaches(to.angle_rad))
            .then(|| self.bisect(from, to, |point| !approaches(point.angle_rad)))
    }

    pub(super) fn bisect(&self, from: &Point, to: &Point, holds: impl Fn(&Point) -> bool) -> Point {
        let (mut low, mut high) = (*from, *to);
        let at_low = holds(from);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low.angle_rad + high.angle_rad);
            if middle <= low.angle_rad || middle >= high.angle_rad {
                break;
            }
            let point = self.at(middle);
            if holds(&point) == at_low { low = point } else { high = point }
        }
        high
    }

    pub(super) fn positive_crossings(&self, from: &Point, to: &Point, each: &mut impl FnMut(Point)) {
        if from.ln_gain.max(to.ln_gain) < self.ln_small {
            return;
        }
        // H turns by less than 30° within the interval, so its relative argument is unambiguous.
        let phase = |point: &Point| from.sides.arg() + (point.sides / from.sides).arg() - self.ticks * point.angle_rad;
        let falls = |angle_rad: f64| self.slope(angle_rad).re < self.ticks;
        let at_begin = falls(from.angle_rad);
        if at_begin != falls(to.angle_rad) && to.angle_rad - from.angle_rad > MIN_WIDTH {
            let middle = self.bisect(from, to, |point| falls(point.angle_rad));
            if middle.angle_rad > from.angle_rad && middle.angle_rad < to.angle_rad {
                self.monotonic_crossings((from, &middle), &phase, each);
                self.monotonic_crossings((&middle, to), &phase, each);
                return;
            }
        }
        self.monotonic_crossings((from, to), &phase, each);
    }

    fn monotonic_crossings(
        &self,
        (from, to): (&Point, &Point),
        phase: &impl Fn(&Point) -> f64,
        each: &mut impl FnMut(Point),
    ) {
        const TURN: f64 = 2.0 * PI;
        let (begin, end) = (phase(from) / TURN, phase(to) / TURN);
        let (low, high) = (begin.min(end), begin.max(end));
        let mut turns = low.ceil();
        while turns <= high {
            let is_beyond = |point: &Point| (phase(point) / TURN >= turns) == (end > begin);
            each(self.bisect(from, to, is_beyond));
            turns += 1.0;
        }
    }

    fn angles(&self) -> Vec<f64> {
        const OFFSETS: [f64; 4] = [0.0, 0.5, 1.6, 6.0];
        let mut angles: Vec<f64> = vec![0.0, PI];
        angles.extend((0..12).map(|k| PI * 0.5_f64.powi(k)));
        for pole in self.closed.open_poles.iter().filter(|pole| pole.im >= 0.0 && pole.norm() > 1e-3) {
            let (at, reach) = (pole.arg(), (pole.norm() / self.radius - 1.0).abs());
            angles.extend(OFFSETS.iter().flat_map(|share| [at - share * reach, at + share * reach]));
        }
        angles.retain(|angle| (0.0..=PI).contains(angle));
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    }
}

impl ClosedLoop {
    /// Angles in rad, and the arguments of `L`.
    pub(super) fn unit_crossings(&self) -> Result<Vec<(f64, f64)>, StabilityError> {
        let mut all = vec![];
        Path::new(self, 1.0).unit_crossings(|point| all.push((point.angle_rad, point.gain.arg())))?;
        Ok(all)
    }
}
