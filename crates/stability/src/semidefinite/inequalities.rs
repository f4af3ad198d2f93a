use nalgebra::{DMatrix, DVector};

use super::{Block, Congruence, Programme, Status, matrix_at, row, starts};
use crate::StabilityError;

/// `c Mᵀ X M` for one of the unknown symmetric matrices `X`.
#[derive(Debug, Clone)]
pub(crate) struct Term {
    pub(crate) factor: f64,
    pub(crate) unknown: usize,
    pub(crate) map: DMatrix<f64>,
}

#[derive(Debug, Clone)]
pub(crate) struct Condition {
    pub(crate) terms: Vec<Term>,
    /// Smaller for a condition per tick than for one per event.
    pub(crate) weight: f64,
}

/// An unknown symmetric matrix `X = Σ Uᵀ Z U`. A full matrix has one part, `U = I`.
#[derive(Debug, Clone)]
pub(crate) struct Unknown {
    pub(crate) parts: Vec<DMatrix<f64>>,
}

impl Unknown {
    fn size(&self) -> usize {
        self.parts[0].ncols()
    }
}

const MIN_ACCURACY: f64 = 1e-4;

/// Maximises the common margin, or reaches `enough`; feasible if positive.
pub(crate) fn solve(
    unknowns: &[Unknown],
    conditions: &[Condition],
    enough: Option<f64>,
) -> Result<(Vec<DMatrix<f64>>, f64), StabilityError> {
    let parts: Vec<(usize, &DMatrix<f64>)> =
        unknowns.iter().enumerate().flat_map(|(k, unknown)| unknown.parts.iter().map(move |part| (k, part))).collect();
    let (first, margin) = starts(parts.iter().map(|(_, part)| part.nrows()));
    let mut objective = DVector::zeros(margin + 1);
    objective[margin] = 1.0;
    let block = |condition: &Condition| {
        let size = condition.terms[0].map.ncols();
        let mut congruences = vec![];
        for term in &condition.terms {
            for (&start, (_, part)) in first.iter().zip(&parts).filter(|(_, (unknown, _))| *unknown == term.unknown) {
                congruences.push(Congruence { factor: term.factor, start, map: *part * &term.map });
            }
        }
        let loose = vec![(margin, DMatrix::identity(size, size) * -condition.weight)];
        Block { size, congruences, loose }
    };
    let blocks: Vec<Block> = conditions.iter().map(block).collect();
    let mut traces = DVector::zeros(margin + 1);
    for (&start, (_, part)) in first.iter().zip(&parts) {
        let outer = *part * part.transpose();
        for q in 0..outer.nrows() {
            for p in 0..=q {
                traces[start + row(p, q)] = if p == q { outer[(p, q)] } else { 2.0 * outer[(p, q)] };
            }
        }
    }
    let rows: usize = unknowns.iter().map(Unknown::size).sum();
    let solution = super::solve(&Programme { objective, equation: (traces, rows as f64), blocks, enough });
    let is_found = match solution.status {
        Status::Solved => true,
        Status::Stalled => solution.accuracy < MIN_ACCURACY,
        Status::Infeasible => false,
    };
    if !is_found {
        return Err(StabilityError::Solver { status: format!("{:?}", solution.status) });
    }
    let mut matrices: Vec<DMatrix<f64>> =
        unknowns.iter().map(|unknown| DMatrix::zeros(unknown.size(), unknown.size())).collect();
    for (&start, (unknown, part)) in first.iter().zip(&parts) {
        matrices[*unknown] += part.tr_mul(&(matrix_at(&solution.y, start, part.nrows()) * *part));
    }
    let matrices = matrices.iter().map(|matrix| (matrix + matrix.transpose()) * 0.5).collect();
    Ok((matrices, solution.y[margin]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(size: usize) -> Unknown {
        Unknown { parts: vec![DMatrix::identity(size, size)] }
    }

    fn term(factor: f64, map: &DMatrix<f64>) -> Term {
        Term { factor, unknown: 0, map: map.clone() }
    }

    /// The conditions `Aᵀ X A < X` for each matrix, and a positive `X`.
    fn common(matrices: &[DMatrix<f64>]) -> Vec<Condition> {
        let one = DMatrix::identity(2, 2);
        let exceeding = |terms| Condition { terms, weight: 1.0 };
        let positive = exceeding(vec![term(1.0, &one)]);
        let decreasing = matrices.iter().map(|a| exceeding(vec![term(1.0, &one), term(-1.0, a)]));
        decreasing.chain([positive]).collect()
    }

    #[test]
    fn the_margin_of_a_contraction_is_one_minus_its_square() {
        // X = I is optimal for A = a I: the margin is 1 - a².
        for a in [0.0, 0.5, 0.99] {
            let (found, margin) = solve(&[whole(2)], &common(&[DMatrix::identity(2, 2) * a]), None).expect("solved");
            assert!((margin - (1.0 - a * a)).abs() < 1e-7 && (&found[0] - DMatrix::identity(2, 2)).norm() < 1e-3);
            // The optimal matrix is diagonal.
            let rows = [0, 1].map(|k| DMatrix::from_fn(1, 2, |_, j| f64::from(u8::from(j == k))));
            let diagonal = Unknown { parts: rows.to_vec() };
            let (found, same) = solve(&[diagonal], &common(&[DMatrix::identity(2, 2) * a]), None).expect("solved");
            assert!((same - margin).abs() < 1e-7 && found[0][(0, 1)] == 0.0);
        }
    }

    #[test]
    fn two_stable_matrices_need_not_have_a_common_function() {
        let turn = |angle: f64, stretch: f64| {
            let (s, c) = angle.sin_cos();
            DMatrix::from_row_slice(2, 2, &[c, -s * stretch, s / stretch, c]) * 0.8
        };
        let pair = |stretch: f64| [turn(1.0, stretch), turn(1.0, 1.0 / stretch)];
        let (found, margin) = solve(&[whole(2)], &common(&pair(1.1)), None).expect("solved");
        assert!(margin > 0.0);
        for a in pair(1.1) {
            let less = &found[0] - a.transpose() * &found[0] * a;
            assert!(less.symmetric_eigenvalues().min() >= 0.99 * margin);
        }
        // Their product has an eigenvalue outside the unit circle, so no function decreases along both.
        let [a, b] = pair(4.0);
        assert!((a * b).complex_eigenvalues().iter().any(|value| value.norm() > 1.0));
        assert!(solve(&[whole(2)], &common(&pair(4.0)), None).expect("solved").1 <= 1e-9);
    }
}
