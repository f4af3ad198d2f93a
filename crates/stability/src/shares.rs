use super::limit::StabilityTester;
use super::{Axis, LinearLoop, StabilityError};
use trocar_base::parallel::try_map;

/// For a two-sided 95 % interval of a normal distribution.
pub(super) const CONFIDENCE: f64 = 1.959_963_984_540_054;

const CELL: usize = 8;

#[derive(Debug, Clone, PartialEq)]
pub struct ShareMap {
    pub x: Axis,
    pub y: Axis,
    pub of: usize,
    /// Row by row from the lowest `y`.
    pub stable: Vec<u32>,
}

pub(super) fn share_interval(count: usize, of: usize) -> (f64, (f64, f64)) {
    let (n, z2) = (of as f64, CONFIDENCE * CONFIDENCE);
    let share = count as f64 / n;
    let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = CONFIDENCE / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    (share, ((middle - half).max(0.0), (middle + half).min(1.0)))
}

impl ShareMap {
    pub const MAX_COUNT: usize = 50;

    pub const MAX_LOOPS: usize = 400;

    /// Evaluates a coarse grid, then the cells on the boundary: an island within a cell is not detected.
    pub fn of(loops: &[LinearLoop], (x, y): (&Axis, &Axis)) -> Result<Self, StabilityError> {
        let coarser = |axis: &Axis| Axis { count: axis.count.min(Self::MAX_COUNT), ..*axis };
        let (x, y) = (coarser(x), coarser(y));
        let verdicts = try_map(loops.len(), |index| verdicts(&loops[index], &x, &y))?;
        let mut stable = vec![0; x.count * y.count];
        for verdicts in verdicts {
            stable.iter_mut().zip(verdicts).for_each(|(sum, verdict)| *sum += u32::from(verdict));
        }
        Ok(Self { x, y, of: loops.len(), stable })
    }

    pub fn share(&self, column: usize, row: usize) -> (f64, (f64, f64)) {
        share_interval(self.stable[row * self.x.count + column] as usize, self.of)
    }
}

fn verdicts(settings: &LinearLoop, x: &Axis, y: &Axis) -> Result<Vec<bool>, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    let mut known: Vec<Option<bool>> = vec![None; x.count * y.count];
    let mut at = |(column, row): (usize, usize)| -> Result<bool, StabilityError> {
        let place = row * x.count + column;
        if let Some(verdict) = known[place] {
            return Ok(verdict);
        }
        let verdict = tester.is_stable(&[(x.parameter, x.value(column)), (y.parameter, y.value(row))])?;
        known[place] = Some(verdict);
        Ok(verdict)
    };
    let cells = |count: usize| (0..count - 1).step_by(CELL).map(move |from| (from, (from + CELL).min(count - 1)));
    let mut open: Vec<_> = cells(x.count).flat_map(|columns| cells(y.count).map(move |rows| (columns, rows))).collect();
    let mut uniform = vec![];
    while let Some(cell) = open.pop() {
        let ((left, right), (low, high)) = cell;
        let verdict = at((left, low))?;
        let is_uniform = verdict == at((right, low))? && verdict == at((left, high))? && verdict == at((right, high))?;
        if is_uniform {
            uniform.push((cell, verdict));
        } else if right - left > 1 || high - low > 1 {
            let halves = |(from, to): (usize, usize)| {
                let middle = usize::midpoint(from, to);
                if middle > from { vec![(from, middle), (middle, to)] } else { vec![(from, to)] }
            };
            for columns in halves((left, right)) {
                open.extend(halves((low, high)).into_iter().map(|rows| (columns, rows)));
            }
        }
    }
    for (((left, right), (low, high)), verdict) in uniform {
        for row in low..=high {
            for place in &mut known[row * x.count + left..=row * x.count + right] {
                place.get_or_insert(verdict);
            }
        }
    }
    Ok(known.into_iter().map(|verdict| verdict.unwrap_or(false)).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{Parameter, Spacing, TissueRange, map};
    use super::*;
    use trocar_scenario::{Scenario, Source};

    #[test]
    fn oracle_a_share_has_wilsons_interval() {
        // For 0 of 100: from 0 to z²/(n + z²).
        let (share, (low, high)) = share_interval(0, 100);
        let z2 = CONFIDENCE * CONFIDENCE;
        assert!(share == 0.0 && low < 1e-12 && (high - z2 / (100.0 + z2)).abs() < 1e-12);
    }

    #[test]
    fn the_share_of_one_loop_agrees_with_its_map() {
        let late = Scenario::load(&Source::parse("passivity/late-wall"), &[]).expect("good");
        let settings = LinearLoop::of(&late, TissueRange::of_parameters(&late).expect("a spring")).expect("analysed");
        let axis = |parameter, low, high, count| Axis { parameter, low, high, count, spacing: Spacing::Logarithmic };
        let x = axis(Parameter::ForceScale, 0.1, 10.0, 29);
        let y = axis(Parameter::Stiffness, 10.0, 5000.0, 20);
        let expected = map(&settings, x, y).expect("mapped").stable;
        let once = ShareMap::of(std::slice::from_ref(&settings), (&x, &y)).expect("mapped");
        assert!(once.stable.iter().zip(&expected).all(|(count, stable)| *count == u32::from(*stable)));
        assert!(expected.contains(&true) && expected.contains(&false));
        let softer = settings.with(Parameter::Delay, 0.0);
        let both = ShareMap::of(&[settings, softer], (&x, &y)).expect("mapped");
        assert!(both.of == 2 && (0..3).all(|count| both.stable.contains(&count)));
        assert!(both.stable.iter().zip(&once.stable).all(|(both, once)| both >= once));
    }
}
