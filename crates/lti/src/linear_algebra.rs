//! nalgebra's large products depend on the processor; [`product`] is a plain triple loop.

use nalgebra::{DMatrix, Schur};

use super::{Complex64, Error};

const MAX_QR_ITERATIONS: usize = 10_000;

pub(super) fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(a.ncols(), b.nrows());
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| (0..a.ncols()).fold(0.0, |sum, k| sum + a[(i, k)] * b[(k, j)]))
}

pub(super) fn one_norm(a: &DMatrix<f64>) -> f64 {
    (0..a.ncols()).map(|j| a.column(j).iter().fold(0.0, |sum, v| sum + v.abs())).fold(0.0, f64::max)
}

pub(super) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(position) => Err(Error::NonFinite { what, value: values[position], position }),
    }
}

pub(super) fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), Error> {
    if expected == found { Ok(()) } else { Err(Error::DimensionMismatch { what, expected, found }) }
}

/// Solves `A X = B`; `None` if `A` is singular to working precision.
///
/// Scaling by powers of two (exact) keeps mixed units from counting as singular.
pub(super) fn solve(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    if n == 0 {
        return Some(b.clone());
    }
    let mut scaled = a.clone();
    let mut right = b.clone();
    for i in 0..n {
        let scale = power_of_two(scaled.row(i).amax())?;
        scaled.row_mut(i).unscale_mut(scale);
        right.row_mut(i).unscale_mut(scale);
    }
    let mut column_scales = Vec::with_capacity(n);
    for j in 0..n {
        let scale = power_of_two(scaled.column(j).amax())?;
        scaled.column_mut(j).unscale_mut(scale);
        column_scales.push(scale);
    }
    let lu = scaled.lu();
    let pivots = lu.u().diagonal().abs();
    // Also false for NaN.
    let regular = pivots.min() > n as f64 * f64::EPSILON * pivots.max();
    if !regular {
        return None;
    }
    let mut solution = lu.solve(&right)?;
    for (j, scale) in column_scales.into_iter().enumerate() {
        solution.row_mut(j).unscale_mut(scale);
    }
    solution.iter().all(|v| v.is_finite()).then_some(solution)
}

pub(super) fn solve_right(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    solve(&a.transpose(), &b.transpose()).map(|x| x.transpose())
}

/// The largest power of two up to `value`; `None` for 0, subnormal and non-finite values.
fn power_of_two(value: f64) -> Option<f64> {
    value.is_normal().then(|| f64::from_bits(value.abs().to_bits() & 0x7ff0_0000_0000_0000))
}

/// Sorted by real, then imaginary part; complex eigenvalues are exact conjugate pairs.
///
/// Balancing (Parlett and Reinsch) and a bounded QR iteration to real Schur form.
pub fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<Complex64>, Error> {
    let n = a.nrows();
    check_finite("the matrix", a.as_slice())?;
    let Some(scale) = (if n == 0 { None } else { power_of_two(a.amax()) }) else {
        return Ok(vec![Complex64::new(0.0, 0.0); n]);
    };
    let failed = || Error::EigenvaluesDidNotConverge { size: n, iterations: MAX_QR_ITERATIONS };
    let mut balanced = a / scale;
    nalgebra::linalg::balancing::balance_parlett_reinsch(&mut balanced);
    let (t, shift) = real_schur(&balanced).ok_or_else(failed)?;

    let mut values = Vec::with_capacity(n);
    let mut i = 0;
    while i < n {
        if i + 1 < n && t[(i + 1, i)] != 0.0 {
            // NaN in nalgebra if rounding makes this discriminant positive.
            let mean = 0.5 * (t[(i, i)] + t[(i + 1, i + 1)]) - shift;
            let half = 0.5 * (t[(i, i)] - t[(i + 1, i + 1)]);
            let discriminant = half * half + t[(i, i + 1)] * t[(i + 1, i)];
            let root = discriminant.abs().sqrt();
            let (re, im) = if discriminant < 0.0 { (0.0, root) } else { (root, 0.0) };
            values.push(Complex64::new(mean - re, -im) * scale);
            values.push(Complex64::new(mean + re, im) * scale);
            i += 2;
        } else {
            values.push(Complex64::new((t[(i, i)] - shift) * scale, 0.0));
            i += 1;
        }
    }
    if values.iter().any(|v| !(v.re.is_finite() && v.im.is_finite())) {
        return Err(failed());
    }
    sort(&mut values);
    Ok(values)
}

/// The real Schur form of `a + shift · I`, and the shift: 0 if possible.
///
/// nalgebra compares a subdiagonal entry with its diagonal, so the iteration does not converge with many eigenvalues at
/// 0, as from a chain of delays. The shift adds the norm to the diagonal, at the error of rounding the matrix.
fn real_schur(a: &DMatrix<f64>) -> Option<(DMatrix<f64>, f64)> {
    let norm = a.amax();
    [0.0, norm].into_iter().find_map(|shift| {
        let mut shifted = a.clone();
        (0..a.nrows()).for_each(|i| shifted[(i, i)] += shift);
        let (_, t) = Schur::try_new(shifted, f64::EPSILON, MAX_QR_ITERATIONS)?.unpack();
        Some((t, shift))
    })
}

pub(super) fn sort(values: &mut [Complex64]) {
    values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eigenvalues_of_a_badly_scaled_matrix_have_the_sum_of_its_diagonal() {
        let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, 0.0, 0.0, 1e6, -6.0, -11.0, -6e6]);
        // Companion form of a cubic whose third state has micro-units.
        let trace: f64 = eigenvalues(&a).expect("converges").iter().map(|v| v.re).sum();
        assert!((trace + 6e6).abs() < 1e-6);
    }

    #[test]
    fn degenerate_matrices_have_eigenvalues_or_an_error() {
        assert!(eigenvalues(&DMatrix::zeros(0, 0)).expect("empty").is_empty());
        assert_eq!(eigenvalues(&DMatrix::zeros(3, 3)).expect("zero"), vec![Complex64::new(0.0, 0.0); 3]);
        assert!(matches!(
            eigenvalues(&DMatrix::from_element(2, 2, f64::NAN)),
            Err(Error::NonFinite { position: 0, .. })
        ));
        let huge = DMatrix::from_row_slice(2, 2, &[1e300, 1e300, 0.0, 1e-300]);
        assert_eq!(eigenvalues(&huge).expect("huge")[1].re, 1e300);
    }

    #[test]
    fn the_eigenvalues_of_a_matrix_with_many_zero_eigenvalues_converge() {
        // The map of a long freeze with the force law `amplify` and ten ticks of delay in each direction; nine columns
        // are nonzero. The iteration does not converge without a shift. According to numpy one eigenvalue is above
        // rounding.
        let mut a = DMatrix::zeros(28, 28);
        for line in include_str!("long_freeze.txt").lines() {
            let mut words = line.split_whitespace();
            let column: usize = words.next().and_then(|word| word.parse().ok()).expect("a column");
            words.enumerate().for_each(|(row, word)| a[(row, column)] = word.parse().expect("a number"));
        }
        let values = eigenvalues(&a).expect("converges");
        let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        assert!((largest / 4.447_116_85e-11 - 1.0).abs() < 1e-8, "{largest}");
        assert_eq!(values.iter().filter(|value| value.norm() > 1e-6 * largest).count(), 1, "{values:?}");
    }

    #[test]
    fn solving_distinguishes_singular_matrices_from_mixed_units() {
        let mixed = DMatrix::from_diagonal(&nalgebra::dvector![1e-20, 1e15]);
        let x = solve(&mixed, &DMatrix::identity(2, 2)).expect("regular");
        assert!((x[(0, 0)] * 1e-20 - 1.0).abs() < 1e-15);
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
        assert!(solve(&singular, &DMatrix::identity(2, 2)).is_none());
    }
}
