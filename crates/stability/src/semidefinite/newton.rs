//! The linear equations of one iteration.
//!
//! Let `B_k Δy = Gᵀ (Σ_i Δy_i A_ki) G` be the maps in scaled coordinates, `Λ_k` the scaled point and `r` the residuals.
//! A direction to the target `T_k` satisfies
//!
//! ```text
//! ΔS_k = B_k Δy + r_k,   ΔX_k = T_k - ΔS_k,   Σ_k B_kᵀ ΔX_k - Δλ a = -r,   aᵀ Δy = r_e
//! ```
//! and therefore `H Δy + Δλ a = r + Σ_k B_kᵀ (T_k - r_k)` with the positive definite `H = Σ_k B_kᵀ B_k`.

use nalgebra::{DMatrix, DVector};

use super::factors::{Factors, add_transpose_to_upper};
use super::scaling::Scaling;
use super::{Direction, Programme, Residuals};

/// Relative increase of the diagonal of `H`, so that it can be factored.
const REGULARISATION: f64 = 1e-14;

const REFINEMENTS: usize = 2;

pub(super) struct Newton<'a> {
    programme: &'a Programme,
    scalings: &'a [Scaling],
    residuals: &'a Residuals,
    /// `r_k` in scaled coordinates.
    of_blocks: Vec<DMatrix<f64>>,
    factors: Factors,
    /// `H⁻¹ a`.
    of_equation: DVector<f64>,
}

impl<'a> Newton<'a> {
    /// `None` if rounding makes `H` indefinite.
    pub(super) fn new(programme: &'a Programme, scalings: &'a [Scaling], residuals: &'a Residuals) -> Option<Self> {
        let n = programme.objective.len();
        let mut h = DMatrix::zeros(n, n);
        let mut of_blocks = vec![];
        for ((block, scaling), residual) in programme.blocks.iter().zip(scalings).zip(&residuals.of_blocks) {
            block.add_gram(scaling.g(), &mut h);
            of_blocks.push(scaling.scaled(residual));
        }
        add_transpose_to_upper(&mut h);
        let factors = Factors::new(h, REGULARISATION)?;
        let of_equation = factors.solve(&programme.equation.0);
        Some(Self { programme, scalings, residuals, of_blocks, factors, of_equation })
    }

    fn solve_once(&self, rhs: &DVector<f64>, e: f64) -> (DVector<f64>, f64) {
        let a = &self.programme.equation.0;
        let u = self.factors.solve(rhs);
        let v = (a.dot(&u) - e) / a.dot(&self.of_equation);
        (u - &self.of_equation * v, v)
    }

    fn solve(&self, rhs: &DVector<f64>, e: f64) -> (DVector<f64>, f64) {
        let a = &self.programme.equation.0;
        let (mut u, mut v) = self.solve_once(rhs, e);
        for _ in 0..REFINEMENTS {
            let (du, dv) = self.solve_once(&(rhs - self.factors.product(&u) - a * v), e - a.dot(&u));
            u += du;
            v += dv;
        }
        (u, v)
    }

    /// `None` is the target 0.
    pub(super) fn direction(&self, targets: Option<&[DMatrix<f64>]>) -> Direction {
        let blocks = &self.programme.blocks;
        let mut rhs = self.residuals.of_multipliers.clone();
        for (k, block) in blocks.iter().enumerate() {
            let mut target = -&self.of_blocks[k];
            if let Some(targets) = targets {
                target += &targets[k];
            }
            block.add_adjoint(&self.scalings[k].unscaled_multiplier(&target), &mut rhs);
        }
        let (y, multiplier) = self.solve(&rhs, self.residuals.of_equation);
        let (mut s, mut x) = (vec![], vec![]);
        for (k, block) in blocks.iter().enumerate() {
            let of_s = self.scalings[k].scaled(&block.image(&y)) + &self.of_blocks[k];
            x.push(match targets {
                Some(targets) => &targets[k] - &of_s,
                None => -&of_s,
            });
            s.push(of_s);
        }
        Direction { y, multiplier, s, x }
    }

    /// Mehrotra's direction: a predictor towards complementarity, then centring and second-order correction.
    pub(super) fn corrected_direction(&self) -> Direction {
        let target = |scaling: &Scaling| -DMatrix::from_diagonal(&scaling.lambda);
        let predictor = self.direction(Some(&self.scalings.iter().map(target).collect::<Vec<_>>()));
        let (by_s, by_x) = self.longest_steps(&predictor);
        // A short step indicates a point near the boundary.
        let centring = (1.0 - by_s.min(by_x).min(1.0)).powi(3) * self.complementarity();
        let target = |((scaling, s), x): ((&Scaling, &DMatrix<f64>), &DMatrix<f64>)| {
            let product = s * x;
            let mut r = (&product + product.transpose()) * -0.5;
            for (k, value) in scaling.lambda.iter().enumerate() {
                r[(k, k)] += centring - value * value;
            }
            scaling.quotient(&r)
        };
        let targets: Vec<_> = self.scalings.iter().zip(&predictor.s).zip(&predictor.x).map(target).collect();
        self.direction(Some(&targets))
    }

    fn complementarity(&self) -> f64 {
        let rows: usize = self.scalings.iter().map(|scaling| scaling.lambda.len()).sum();
        self.scalings.iter().map(|scaling| scaling.lambda.norm_squared()).sum::<f64>() / rows as f64
    }

    pub(super) fn longest_steps(&self, direction: &Direction) -> (f64, f64) {
        let longest = |steps: &[DMatrix<f64>]| {
            let each = self.scalings.iter().zip(steps).map(|(scaling, step)| scaling.longest_step(step));
            each.fold(f64::INFINITY, f64::min)
        };
        (longest(&direction.s), longest(&direction.x))
    }
}
