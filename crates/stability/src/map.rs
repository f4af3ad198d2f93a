use super::limit::StabilityTester;
use super::{LinearLoop, Parameter, StabilityError};
use trocar_base::parallel::try_map;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    Linear,
    Logarithmic,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    pub parameter: Parameter,
    pub low: f64,
    pub high: f64,
    /// At least 2.
    pub count: usize,
    pub spacing: Spacing,
}

impl Axis {
    pub fn value(&self, index: usize) -> f64 {
        let share = index as f64 / (self.count - 1) as f64;
        match self.spacing {
            _ if index + 1 == self.count => self.high,
            Spacing::Linear => self.low + (self.high - self.low) * share,
            Spacing::Logarithmic => self.low * (self.high / self.low).powf(share),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct StabilityMap {
    pub x: Axis,
    pub y: Axis,
    /// Row by row from the lowest `y`.
    pub stable: Vec<bool>,
    pub boundary: Vec<[(f64, f64); 2]>,
}

impl StabilityMap {
    pub fn is_stable(&self, column: usize, row: usize) -> bool {
        self.stable[row * self.x.count + column]
    }

    pub fn stable_share(&self) -> f64 {
        self.stable.iter().filter(|stable| **stable).count() as f64 / self.stable.len() as f64
    }
}

/// By column if only `x` changes the machines, to compute matrix exponentials once per column.
pub(super) fn verdicts<T: Send + Copy>(
    settings: &LinearLoop,
    (x, y): (&Axis, &Axis),
    verdict: impl Fn(&StabilityTester<'_>, f64, f64) -> Result<T, StabilityError> + Sync,
) -> Result<Vec<T>, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    // Two delays can divide a tick equally.
    let changes = |axis: &Axis| (0..axis.count.min(8)).any(|k| !tester.has_machines_of(axis.parameter, axis.value(k)));
    if changes(x) && !changes(y) {
        let columns: Vec<Vec<T>> = try_map(x.count, |column| {
            let of_column = settings.with(x.parameter, x.value(column));
            let tester = StabilityTester::new(&of_column)?;
            (0..y.count).map(|row| verdict(&tester, x.value(column), y.value(row))).collect()
        })?;
        return Ok((0..y.count).flat_map(|row| columns.iter().map(move |column| column[row])).collect());
    }
    let rows: Vec<Vec<T>> = try_map(y.count, |row| {
        let of_row = settings.with(y.parameter, y.value(row));
        let tester = StabilityTester::new(&of_row)?;
        (0..x.count).map(|column| verdict(&tester, x.value(column), y.value(row))).collect()
    })?;
    Ok(rows.into_iter().flatten().collect())
}

pub fn map(settings: &LinearLoop, x: Axis, y: Axis) -> Result<StabilityMap, StabilityError> {
    let stable = verdicts(settings, (&x, &y), |tester, x_value, y_value| {
        tester.is_stable(&[(x.parameter, x_value), (y.parameter, y_value)])
    })?;
    let mut map = StabilityMap { x, y, stable, boundary: vec![] };
    map.boundary = boundary(settings, &map)?;
    Ok(map)
}

/// Within the relative distance `share` along an axis.
pub fn is_near_boundary(
    settings: &LinearLoop,
    point: [(Parameter, f64); 2],
    share: f64,
) -> Result<bool, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    let here = tester.is_stable(&point)?;
    for index in 0..2 {
        for factor in [1.0 + share, 1.0 / (1.0 + share)] {
            let mut other = point;
            other[index].1 *= factor;
            if tester.is_stable(&other)? != here {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

fn boundary(settings: &LinearLoop, map: &StabilityMap) -> Result<Vec<[(f64, f64); 2]>, StabilityError> {
    const BISECTIONS: usize = 12;
    let StabilityMap { x, y, .. } = map;
    let tester = StabilityTester::new(settings)?;
    let crossing = |a: (usize, usize), b: (usize, usize)| -> Result<Option<(f64, f64)>, StabilityError> {
        let first = map.is_stable(a.0, a.1);
        if first == map.is_stable(b.0, b.1) {
            return Ok(None);
        }
        let at = |(column, row): (usize, usize)| (x.value(column), y.value(row));
        let (mut here, mut there) = (at(a), at(b));
        for _ in 0..BISECTIONS {
            let middle = (0.5 * (here.0 + there.0), 0.5 * (here.1 + there.1));
            let verdict = tester.is_stable(&[(x.parameter, middle.0), (y.parameter, middle.1)])?;
            if verdict == first { here = middle } else { there = middle }
        }
        Ok(Some((0.5 * (here.0 + there.0), 0.5 * (here.1 + there.1))))
    };
    let edges = |to_right: bool| {
        let of_row = |row: usize| {
            let at = |column: usize| {
                let other = if to_right { (column + 1, row) } else { (column, row + 1) };
                let is_inside = other.0 < x.count && other.1 < y.count;
                if is_inside { crossing((column, row), other) } else { Ok(None) }
            };
            (0..x.count).map(at).collect::<Result<Vec<_>, StabilityError>>()
        };
        try_map(y.count, of_row).map(|rows| rows.concat())
    };
    let (across, upwards) = (edges(true)?, edges(false)?);
    let mut pieces = vec![];
    for row in 0..y.count - 1 {
        for column in 0..x.count - 1 {
            let at = row * x.count + column;
            let around = [across[at], upwards[at + 1], across[at + x.count], upwards[at]];
            let points: Vec<(f64, f64)> = around.into_iter().flatten().collect();
            match points[..] {
                [a, b] => pieces.push([a, b]),
                // A saddle: both pairings are valid.
                [a, b, c, d] => pieces.extend([[a, b], [c, d]]),
                _ => {}
            }
        }
    }
    Ok(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_ends_at_its_limits() {
        let axis = |spacing| Axis { parameter: Parameter::Stiffness, low: 10.0, high: 2000.0, count: 200, spacing };
        for spacing in [Spacing::Linear, Spacing::Logarithmic] {
            let axis = axis(spacing);
            assert_eq!((axis.value(0), axis.value(199)), (10.0, 2000.0));
            assert!((1..200).all(|k| axis.value(k) > axis.value(k - 1)));
        }
        assert!((axis(Spacing::Logarithmic).value(1) / 10.0 - 200.0_f64.powf(1.0 / 199.0)).abs() < 1e-12);
    }
}
