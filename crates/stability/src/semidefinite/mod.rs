//! Semidefinite programmes with some hundred variables:
//!
//! ```text
//! maximise   bᵀy
//! such that  S_k = Σ_i y_i A_ki  is positive semidefinite for each block k,   aᵀy = e
//! ```
//! The multipliers are matrices `X_k` and a number `λ`. At the optimum `S_k` and `X_k` are positive semidefinite,
//! `S_k X_k = 0` and `b + Σ_k A_kᵀ X_k = λ a`.
//!
//! A primal-dual interior-point method: Mehrotra's predictor and corrector along the Nesterov-Todd direction
//! (Vandenberghe and Boyd, *SIAM Review* 38, 1996; Todd, Toh and Tütüncü, *SIAM J. Optim.* 8, 1998). Available
//! libraries would add the unmangled symbols of BLAS and LAPACK to every program that uses this crate.

mod block;
mod factors;
pub(crate) mod inequalities;
mod newton;
mod scaling;
mod small;
mod triangle;

use nalgebra::{DMatrix, DVector};

pub(super) use block::{Block, Congruence, matrix_at, starts};
use newton::Newton;
use scaling::{Scaling, min_eigenvalue};
pub(super) use small::times;
pub(super) use triangle::row;

#[derive(Debug, Clone)]
pub(super) struct Programme {
    /// `b`, one row per variable.
    pub(super) objective: DVector<f64>,
    /// `a` and `e`.
    pub(super) equation: (DVector<f64>, f64),
    pub(super) blocks: Vec<Block>,
    /// Ends the search when reached or proved unreachable.
    pub(super) enough: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    /// Feasible and optimal to [`TOLERANCE`], or the question of `enough` is decided.
    Solved,
    /// Rounding errors or the iteration limit ended the search.
    Stalled,
    /// No `y` with a norm below [`MAX_NORM`] is feasible.
    Infeasible,
}

#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub(super) y: DVector<f64>,
    pub(super) status: Status,
    pub(super) accuracy: f64,
}

const TOLERANCE: f64 = 1e-8;

const DECIDED: f64 = 1e-9;

const MAX_NORM: f64 = 1e6;

/// 10 to 30 are usual.
const MAX_ITERATIONS: usize = 60;

const STEP: f64 = 0.98;

const MIN_STEP: f64 = 1e-4;

struct Iterate {
    y: DVector<f64>,
    multiplier: f64,
    s: Vec<DMatrix<f64>>,
    x: Vec<DMatrix<f64>>,
}

struct Residuals {
    /// `b + Σ_k A_kᵀ X_k - λ a`.
    of_multipliers: DVector<f64>,
    /// `Σ_i y_i A_ki - S_k`.
    of_blocks: Vec<DMatrix<f64>>,
    /// `e - aᵀy`.
    of_equation: f64,
}

struct Direction {
    y: DVector<f64>,
    multiplier: f64,
    s: Vec<DMatrix<f64>>,
    x: Vec<DMatrix<f64>>,
}

/// The stacked maps of all blocks must have independent columns.
pub(super) fn solve(programme: &Programme) -> Solution {
    let variables = programme.objective.len();
    let none = Solution { y: DVector::zeros(variables), status: Status::Stalled, accuracy: f64::INFINITY };
    let Some(mut now) = programme.start() else { return none };
    let mut best = none;
    for _ in 0..MAX_ITERATIONS {
        trocar_base::interrupt::check();
        let residuals = programme.residuals(&now);
        let accuracy = programme.accuracy(&now, &residuals);
        if !accuracy.is_finite() {
            break;
        }
        if accuracy < best.accuracy {
            best = Solution { y: now.y.clone(), status: Status::Stalled, accuracy };
        }
        if accuracy < TOLERANCE {
            return Solution { status: Status::Solved, ..best };
        }
        if programme.is_decided(&now, &residuals) {
            return Solution { y: now.y, status: Status::Solved, accuracy };
        }
        if programme.is_infeasible(&now, &residuals) {
            return Solution { status: Status::Infeasible, ..best };
        }
        let scalings = now.s.iter().zip(&now.x).map(|(s, x)| Scaling::new(s, x));
        let Some(scalings) = scalings.collect::<Option<Vec<_>>>() else { break };
        let Some(newton) = Newton::new(programme, &scalings, &residuals) else { break };
        let direction = newton.corrected_direction();
        let (by_s, by_x) = newton.longest_steps(&direction);
        let (by_s, by_x) = ((STEP * by_s).min(1.0), (STEP * by_x).min(1.0));
        if by_s.max(by_x) < MIN_STEP {
            break;
        }
        now.move_along(programme, &scalings, &residuals, &direction, (by_s, by_x));
    }
    best
}

impl Iterate {
    fn move_along(
        &mut self,
        programme: &Programme,
        scalings: &[Scaling],
        residuals: &Residuals,
        direction: &Direction,
        (by_s, by_x): (f64, f64),
    ) {
        self.y.axpy(by_s, &direction.y, 1.0);
        self.multiplier += by_x * direction.multiplier;
        for (k, block) in programme.blocks.iter().enumerate() {
            self.s[k] += (block.image(&direction.y) + &residuals.of_blocks[k]) * by_s;
            self.x[k] += scalings[k].unscaled_multiplier(&direction.x[k]) * by_x;
        }
    }
}

impl Programme {
    fn start(&self) -> Option<Iterate> {
        let scalings: Vec<Scaling> = self.blocks.iter().map(|block| Scaling::identity(block.size)).collect();
        let zeros = || self.blocks.iter().map(|block| DMatrix::zeros(block.size, block.size)).collect::<Vec<_>>();
        // Smallest S with S = A y and aᵀy = e.
        let none = DVector::zeros(self.objective.len());
        let residuals = Residuals { of_multipliers: none, of_blocks: zeros(), of_equation: self.equation.1 };
        let direction = Newton::new(self, &scalings, &residuals)?.direction(None);
        let (y, s) = (direction.y, direction.s);
        // Smallest X with b + Aᵀ X = λ a.
        let residuals = Residuals { of_multipliers: self.objective.clone(), of_blocks: zeros(), of_equation: 0.0 };
        let direction = Newton::new(self, &scalings, &residuals)?.direction(None);
        let (multiplier, x) = (direction.multiplier, direction.x);
        Some(Iterate { y, multiplier, s: shifted_into_cone(s)?, x: shifted_into_cone(x)? })
    }

    fn residuals(&self, now: &Iterate) -> Residuals {
        let (a, e) = &self.equation;
        let mut of_multipliers = &self.objective - a * now.multiplier;
        let mut of_blocks = vec![];
        for (k, block) in self.blocks.iter().enumerate() {
            of_blocks.push(block.image(&now.y) - &now.s[k]);
            block.add_adjoint(&now.x[k], &mut of_multipliers);
        }
        Residuals { of_multipliers, of_blocks, of_equation: e - a.dot(&now.y) }
    }

    /// `λ e`: a bound of the objective if the multipliers satisfy their equation.
    fn bound(&self, now: &Iterate) -> f64 {
        now.multiplier * self.equation.1
    }

    fn is_decided(&self, now: &Iterate, residuals: &Residuals) -> bool {
        let Some(enough) = self.enough else { return false };
        let of_blocks = residuals.of_blocks.iter().map(DMatrix::norm_squared).sum::<f64>().sqrt();
        let is_feasible = of_blocks < DECIDED && residuals.of_equation.abs() < DECIDED * self.equation.1.abs();
        let is_bound = residuals.of_multipliers.norm() < DECIDED * self.objective.norm();
        is_feasible && self.objective.dot(&now.y) > enough || is_bound && self.bound(now) < enough
    }

    fn accuracy(&self, now: &Iterate, residuals: &Residuals) -> f64 {
        let objective = self.objective.dot(&now.y);
        let of_blocks = residuals.of_blocks.iter().map(DMatrix::norm_squared).sum::<f64>().sqrt();
        let gap: f64 = now.s.iter().zip(&now.x).map(|(s, x)| s.dot(x)).sum();
        [
            residuals.of_multipliers.norm() / (1.0 + self.objective.norm()),
            of_blocks,
            residuals.of_equation.abs() / (1.0 + self.equation.1.abs()),
            gap / (1.0 + objective.abs()),
        ]
        .into_iter()
        .fold(0.0, |max, value| if value > max || value.is_nan() { value } else { max })
    }

    /// A feasible `y` with a norm below [`MAX_NORM`] would give `0 <= Σ_k <S_k, X_k> = β + yᵀd` with `β = λ e` and
    /// `d = Σ_k A_kᵀ X_k - λ a`.
    fn is_infeasible(&self, now: &Iterate, residuals: &Residuals) -> bool {
        let bound = self.bound(now);
        MAX_NORM * (&residuals.of_multipliers - &self.objective).norm() < -bound
    }
}

fn shifted_into_cone(mut matrices: Vec<DMatrix<f64>>) -> Option<Vec<DMatrix<f64>>> {
    let mut min = f64::INFINITY;
    for matrix in &matrices {
        min = min.min(min_eigenvalue(matrix.clone())?);
    }
    if min <= 1e-8 {
        for matrix in &mut matrices {
            for k in 0..matrix.nrows() {
                matrix[(k, k)] += 1.0 - min;
            }
        }
    }
    Some(matrices)
}

#[cfg(test)]
mod tests;
