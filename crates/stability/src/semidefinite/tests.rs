//! Programmes with known solutions.

use super::triangle::entries;
use super::*;
use std::f64::consts::PI;

/// A programme with `count` variables whose last variable is 1.
fn homogeneous(count: usize, objective: &[(usize, f64)]) -> Programme {
    let unit = |k: usize| DVector::from_fn(count, |i, _| f64::from(u8::from(i == k)));
    let objective = objective.iter().map(|&(k, value)| unit(k) * value).sum();
    Programme { objective, equation: (unit(count - 1), 1.0), blocks: vec![], enough: None }
}

impl Programme {
    /// Adds the condition that `Σ_i y_i A_i` is positive semidefinite.
    fn with(mut self, terms: &[(usize, DMatrix<f64>)]) -> Self {
        self.blocks.push(Block { size: terms[0].1.nrows(), congruences: vec![], loose: terms.to_vec() });
        self
    }
}

fn number(value: f64) -> DMatrix<f64> {
    DMatrix::from_element(1, 1, value)
}

/// The symmetric matrix with 1 at `(i, j)` and `(j, i)`.
fn unit(n: usize, i: usize, j: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |p, q| f64::from(u8::from((p, q) == (i, j) || (q, p) == (i, j))))
}

/// The entries of an unknown symmetric matrix from variable `first` on, as `(variable, i, j)`.
fn unknown(n: usize, first: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..n).flat_map(move |j| (0..=j).map(move |i| (first + row(i, j), i, j)))
}

/// `P - Aᵀ P A - Q`; `P` has the first variables, and the last variable is 1.
fn lyapunov(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Vec<(usize, DMatrix<f64>)> {
    let n = a.nrows();
    let of_entry = |(k, i, j)| (k, unit(n, i, j) - a.transpose() * unit(n, i, j) * a);
    unknown(n, 0).map(of_entry).chain([(entries(n), -q)]).collect()
}

fn solved(programme: &Programme) -> DVector<f64> {
    let solution = solve(programme);
    assert_eq!(solution.status, Status::Solved, "{}", solution.accuracy);
    assert!(solution.accuracy < TOLERANCE);
    solution.y
}

#[test]
fn a_linear_programme_is_solved_at_its_corner() {
    // 3 x + 2 y under x + y <= 4, x <= 3, x and y at least 0: x = 3, y = 1.
    let programme = homogeneous(3, &[(0, 3.0), (1, 2.0)])
        .with(&[(2, number(4.0)), (0, number(-1.0)), (1, number(-1.0))])
        .with(&[(2, number(3.0)), (0, number(-1.0))])
        .with(&[(0, number(1.0))])
        .with(&[(1, number(1.0))]);
    let y = solved(&programme);
    assert!((y[0] - 3.0).abs() < 1e-6 && (y[1] - 1.0).abs() < 1e-6, "{y}");
}

#[test]
fn the_largest_shift_of_a_matrix_is_its_smallest_eigenvalue() {
    for n in [1, 2, 5, 20] {
        let entry = |i: usize, j: usize| [2.0, -1.0].get(i.abs_diff(j)).copied().unwrap_or(0.0);
        let chain = DMatrix::from_fn(n, n, entry);
        let programme = homogeneous(2, &[(0, 1.0)]).with(&[(1, chain), (0, -DMatrix::identity(n, n))]);
        let known = 2.0 - 2.0 * (PI / (n as f64 + 1.0)).cos();
        assert!((solved(&programme)[0] - known).abs() < 1e-7);
    }
}

#[test]
fn the_largest_value_over_matrices_of_trace_one_is_the_largest_eigenvalue() {
    // 210 variables, and an equation over several of them.
    let n = 20;
    let matrix = DMatrix::from_fn(n, n, |i, j| ((i * j + i + j) as f64).sin());
    let mut programme = Programme {
        objective: DVector::zeros(entries(n)),
        equation: (DVector::zeros(entries(n)), 1.0),
        blocks: vec![],
        enough: None,
    };
    for (k, i, j) in unknown(n, 0) {
        programme.objective[k] = unit(n, i, j).dot(&matrix);
        programme.equation.0[k] = f64::from(u8::from(i == j));
    }
    let programme = programme.with(&unknown(n, 0).map(|(k, i, j)| (k, unit(n, i, j))).collect::<Vec<_>>());
    let y = solved(&programme);
    let known = matrix.symmetric_eigenvalues().max();
    assert!((programme.objective.dot(&y) - known).abs() < 1e-6 * known);
}

#[test]
fn the_smallest_function_that_decreases_by_q_solves_lyapunovs_equation() {
    // For numbers: P = Q / (1 - a²).
    let programme = homogeneous(2, &[(0, -1.0)]).with(&lyapunov(&number(0.5), &number(3.0)));
    assert!((solved(&programme)[0] - 4.0).abs() < 1e-6);
    // In general: P = Σ_k (Aᵀ)^k Q A^k.
    let a = DMatrix::from_row_slice(3, 3, &[0.9, 0.5, 0.0, -0.3, 0.7, 0.2, 0.1, 0.0, -0.5]);
    let q = DMatrix::from_diagonal(&DVector::from_column_slice(&[1.0, 2.0, 3.0]));
    let (mut p, mut power) = (DMatrix::zeros(3, 3), DMatrix::identity(3, 3));
    for _ in 0..2000 {
        p += power.transpose() * &q * &power;
        power = &power * &a;
    }
    let trace: Vec<(usize, f64)> = (0..3).map(|k| (row(k, k), -1.0)).collect();
    let y = solved(&homogeneous(7, &trace).with(&lyapunov(&a, &q)));
    for (k, i, j) in unknown(3, 0) {
        assert!((y[k] - p[(i, j)]).abs() < 1e-5 * p.norm(), "{} for {}", y[k], p[(i, j)]);
    }
}

#[test]
fn lovaszs_number_of_the_pentagon_is_the_root_of_five() {
    // The minimum t with a positive semidefinite t I + Σ y_ij (over edges) - J (Lovász, IEEE Trans. Inf. Theory 25,
    // 1979).
    let edges = (0..5).map(|k| (k + 1, unit(5, k, (k + 1) % 5)));
    let terms: Vec<_> = edges.chain([(0, DMatrix::identity(5, 5)), (6, DMatrix::from_element(5, 5, -1.0))]).collect();
    let y = solved(&homogeneous(7, &[(0, -1.0)]).with(&terms));
    assert!((y[0] - 5.0_f64.sqrt()).abs() < 1e-7);
}

#[test]
fn an_infeasible_programme_never_ends_as_solved() {
    // x >= 1 and x <= 0.
    let programme = homogeneous(2, &[(0, 1.0)]).with(&[(0, number(1.0)), (1, number(-1.0))]).with(&[(0, number(-1.0))]);
    assert_eq!(solve(&programme).status, Status::Infeasible);
    // No positive function decreases along a growing motion. The search may stall before the proof is complete, but
    // must not end as solved.
    for growing in [1.01, 1.5, 3.0] {
        let a = DMatrix::from_row_slice(2, 2, &[growing, 1.0, 0.0, 0.5]);
        let positive: Vec<_> = unknown(2, 0).map(|(k, i, j)| (k, unit(2, i, j))).collect();
        let programme = homogeneous(4, &[(0, -1.0)]).with(&lyapunov(&a, &DMatrix::identity(2, 2))).with(&positive);
        let solution = solve(&programme);
        assert!(solution.status != Status::Solved && solution.accuracy > 1e-3, "{growing} {solution:?}");
    }
}

#[test]
fn an_unattained_optimum_is_never_exceeded() {
    // The minimum x with a positive semidefinite [x 1; 1 y] is 0, in the limit.
    let programme = homogeneous(3, &[(0, -1.0)]).with(&[(0, unit(2, 0, 0)), (2, unit(2, 0, 1)), (1, unit(2, 1, 1))]);
    let solution = solve(&programme);
    assert!(solution.y[0] > -1e-7 && solution.y[0] < 1e-3, "{solution:?}");
}

#[test]
fn congruences_of_unknown_matrices_are_sums_over_their_entries() {
    // P - Aᵀ P A - Q as congruences and entry by entry.
    let a = DMatrix::from_row_slice(3, 3, &[0.9, 0.5, 0.0, -0.3, 0.7, 0.2, 0.1, 0.0, -0.5]);
    let q = DMatrix::from_diagonal(&DVector::from_column_slice(&[1.0, 2.0, 3.0]));
    let trace: Vec<(usize, f64)> = (0..3).map(|k| (row(k, k), -1.0)).collect();
    let mut whole = homogeneous(7, &trace);
    let congruence = |factor, map: &DMatrix<f64>| Congruence { factor, start: 0, map: map.clone() };
    let congruences = vec![congruence(1.0, &DMatrix::identity(3, 3)), congruence(-1.0, &a)];
    whole.blocks.push(Block { size: 3, congruences, loose: vec![(entries(3), -&q)] });
    let single = homogeneous(7, &trace).with(&lyapunov(&a, &q));
    assert!((solved(&whole) - solved(&single)).norm() < 1e-6);
}

#[test]
fn a_search_ends_when_it_is_decided() {
    let programme = |enough| Programme { enough: Some(enough), ..homogeneous(2, &[(0, 1.0)]) };
    let bounded = |enough| programme(enough).with(&[(1, number(1.0)), (0, number(-1.0))]).with(&[(0, number(1.0))]);
    assert!(solved_y(&bounded(0.5)) > 0.5);
    assert!(solved_y(&bounded(2.0)) <= 1.0 + 1e-6);
}

fn solved_y(programme: &Programme) -> f64 {
    let solution = solve(programme);
    assert_eq!(solution.status, Status::Solved);
    solution.y[0]
}
