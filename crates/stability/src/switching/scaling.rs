use nalgebra::{Cholesky, DMatrix, DVector};

use super::modes::{Modes, Space};
use crate::StabilityError;
use crate::certificate::interval::{Enclosure, exact, product, rounded, solved};

/// 2^40 ticks exceed any transient.
const DOUBLINGS: usize = 40;

/// Lower triangular maps from the unit ball to the reachable states.
#[derive(Debug, Clone)]
pub(super) struct Scales {
    of_loop: DMatrix<f64>,
    metre: f64,
    newton: f64,
    number: f64,
}

/// Scaling by a power of two is exact.
fn power_of_two(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value.log2().floor().exp2() } else { 1.0 }
}

impl Scales {
    pub(super) fn new(modes: &Modes) -> Result<Self, StabilityError> {
        // Delayed hand positions have the hand's scale.
        let (n, machines) = (modes.states(), modes.states() - modes.delay());
        let direct = modes.without_delay();
        let of_loop = |map: &DMatrix<f64>| map.view((0, 0), (machines, map.ncols().min(machines))).into_owned();
        let middle = (of_loop(&direct.teleoperation(0)) + of_loop(&direct.teleoperation(1))) * 0.5;
        let inputs = [direct.of_reference(), direct.of_force(), direct.of_desired()].map(|input| of_loop(&input));
        let mut gramian: DMatrix<f64> = DMatrix::zeros(machines, machines);
        for input in &inputs {
            let mut sum = input * input.transpose();
            let mut step = middle.clone();
            for _ in 0..DOUBLINGS {
                sum += &step * &sum * step.transpose();
                step = &step * &step;
            }
            // Without a tissue the reference moves the slave alone.
            let position = if sum[(0, 0)] > 0.0 { sum[(0, 0)] } else { sum.diagonal().max() };
            gramian += sum / position.max(f64::MIN_POSITIVE);
        }
        // Without a tissue nothing reaches the states of the force reading.
        let spread = gramian.diagonal().map(|value| if value == 0.0 { 1.0 } else { 1e-10 * value });
        gramian += DMatrix::from_diagonal(&spread);
        let gramian = gramian.map(|value| if value.is_finite() { value } else { 0.0 });
        let root = Cholesky::new(gramian)
            .map(|found| found.l())
            .ok_or(StabilityError::Solver { status: "the loop's states do not scale".into() })?;
        let inverse = root.clone().try_inverse().ok_or(StabilityError::Solver { status: "singular".into() })?;
        let rest = |input: &DMatrix<f64>| {
            let apart = DMatrix::identity(machines, machines) - of_loop(&direct.apart(0));
            let state = apart.lu().solve(input).unwrap_or_else(|| input.clone());
            power_of_two((&inverse * state).norm())
        };
        let hand = power_of_two((direct.hand(0).columns(0, machines) * &root).norm());
        let mut of_loop = DMatrix::identity(n, n) * hand;
        of_loop.view_mut((0, 0), (machines, machines)).copy_from(&root);
        let (metre, newton) = (rest(&inputs[0]), rest(&inputs[1]));
        Ok(Self { of_loop, metre, newton, number: 1.0 })
    }

    pub(super) fn with_quantities(&self, modes: &Modes, rows: &[DMatrix<f64>]) -> Self {
        let space = Space::FadingGap;
        let scale = self.of(modes, space);
        let size = rows.iter().map(|row| (modes.row(row, space) * &scale).norm()).fold(0.0, f64::max);
        Self { number: power_of_two(size), ..self.clone() }
    }

    pub(super) fn of(&self, modes: &Modes, space: Space) -> DMatrix<f64> {
        let n = modes.states();
        let (gap, force) = (1.0 / self.metre, 1.0 / self.newton);
        let (space, is_driven) = space.undriven();
        let mut extra = match space {
            Space::Input => return DMatrix::from_element(1, 1, force),
            Space::Loop | Space::All => vec![],
            Space::LoopGap => vec![gap],
            Space::Fading => vec![force],
            Space::FadingGap => vec![force, gap],
            Space::Frozen => [gap, force, force, force][..modes.size(space) - n].to_vec(),
            Space::Held => {
                let held = [gap, force, force];
                return DMatrix::from_diagonal(&DVector::from_column_slice(&held[..modes.size(space)]));
            }
            Space::Gap => return DMatrix::from_element(1, 1, gap),
            Space::Number => return DMatrix::from_element(1, 1, self.number),
            Space::DrivenLoop
            | Space::DrivenLoopGap
            | Space::DrivenFading
            | Space::DrivenFadingGap
            | Space::DrivenFrozen => vec![],
        };
        if is_driven {
            extra.push(force);
        }
        let mut scale = DMatrix::zeros(n + extra.len(), n + extra.len());
        scale.view_mut((0, 0), (n, n)).copy_from(&self.of_loop);
        for (k, value) in extra.into_iter().enumerate() {
            scale[(n + k, n + k)] = value;
        }
        scale
    }

    /// `S_to⁻¹ M S_from`.
    pub(super) fn scaled(&self, modes: &Modes, map: &DMatrix<f64>, (from, to): (Space, Space)) -> Enclosure {
        solved(&self.of(modes, to), product(&rounded(map), &exact(&self.of(modes, from))))
    }
}
