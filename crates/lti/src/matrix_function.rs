use nalgebra::DMatrix;

use super::Error;
use super::linear_algebra::{check_finite, check_size, eigenvalues, one_norm, product, solve};

/// [13/13] Padé approximant (Higham, *SIAM J. Matrix Anal. Appl.* 26, 2005), divided by the last coefficient.
const PADE_13: [f64; 14] = [
    64_764_752_532_480_000.0,
    32_382_376_266_240_000.0,
    7_771_770_303_897_600.0,
    1_187_353_796_428_800.0,
    129_060_195_264_000.0,
    10_559_470_521_600.0,
    670_442_572_800.0,
    33_522_128_640.0,
    1_323_241_920.0,
    40_840_800.0,
    960_960.0,
    16_380.0,
    182.0,
    1.0,
];
/// Maximum 1-norm (theta_13, same source).
const PADE_13_NORM: f64 = 5.371_920_351_148_152;
const MAX_SQUARE_ROOTS: usize = 64;
const MAX_NEWTON_STEPS: usize = 60;
const LOGARITHM_TOLERANCE: f64 = 1e-9;

/// Scaling and squaring, `exp(A) = (r(A / 2^m))^(2^m)`, with the same bits on every computer.
pub fn exponential(a: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check_size("the number of columns of the matrix", a.nrows(), a.ncols())?;
    check_finite("the matrix", a.as_slice())?;
    let norm = one_norm(a);
    let overflow = || Error::ExponentialOverflow { norm };
    if !norm.is_finite() {
        return Err(overflow());
    }
    let n = a.nrows();
    let (mut scaled_norm, mut scale, mut squarings) = (norm, 1.0, 0);
    while scaled_norm > PADE_13_NORM {
        scaled_norm *= 0.5;
        scale *= 0.5;
        squarings += 1;
    }
    let a1 = a * scale;
    let a2 = product(&a1, &a1);
    let a4 = product(&a2, &a2);
    let a6 = product(&a4, &a2);
    let identity = DMatrix::<f64>::identity(n, n);
    let b = &PADE_13;
    let combine = |i: usize| {
        let high = &a6 * b[i + 12] + &a4 * b[i + 10] + &a2 * b[i + 8];
        product(&a6, &high) + &a6 * b[i + 6] + &a4 * b[i + 4] + &a2 * b[i + 2] + &identity * b[i]
    };
    let even = combine(0);
    let odd = product(&a1, &combine(1));
    let mut result = solve(&(&even - &odd), &(&even + &odd)).ok_or_else(overflow)?;
    for _ in 0..squarings {
        result = product(&result, &result);
    }
    if result.iter().all(|v| v.is_finite()) { Ok(result) } else { Err(overflow()) }
}

/// The real `L` with `exp(L) = A` whose eigenvalues have |Im| < π, by inverse scaling and squaring:
/// `log A = 2^m · 2 atanh((R - I)(R + I)⁻¹)`, `R = A^(1/2^m)` (Higham, *Functions of Matrices*, ch. 11).
///
/// Fails for an eigenvalue at 0 or on the negative real axis, or too close for `exp(L)` to reproduce `A`.
pub fn logarithm(a: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check_size("the number of columns of the matrix", a.nrows(), a.ncols())?;
    let values = eigenvalues(a)?;
    let largest = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let zero = 8.0 * a.nrows() as f64 * f64::EPSILON * largest;
    if let Some(v) = values.iter().find(|v| v.norm() <= zero || (v.re < 0.0 && v.im == 0.0)) {
        return Err(Error::NoRealLogarithm { re: v.re, im: v.im });
    }
    let inaccurate = |residual| Error::LogarithmInaccurate { residual };

    let n = a.nrows();
    let identity = DMatrix::<f64>::identity(n, n);
    let mut root = a.clone();
    let mut factor = 2.0;
    for _ in 0..MAX_SQUARE_ROOTS {
        if one_norm(&(&root - &identity)) <= 0.25 {
            break;
        }
        root = square_root(&root).ok_or_else(|| inaccurate(f64::INFINITY))?;
        factor *= 2.0;
    }
    let x = solve(&(&root + &identity), &(&root - &identity)).ok_or_else(|| inaccurate(f64::INFINITY))?;
    let square = product(&x, &x);
    let mut term = x.clone();
    let mut sum = x;
    // |X| <= 0.15, so each term is at least 40 times smaller than the last.
    for k in 1..20 {
        term = product(&term, &square);
        sum += &term / f64::from(2 * k + 1);
    }
    let result = sum * factor;
    let residual = one_norm(&(exponential(&result)? - a)) / one_norm(a).max(f64::MIN_POSITIVE);
    if residual <= LOGARITHM_TOLERANCE { Ok(result) } else { Err(inaccurate(residual)) }
}

/// Denman-Beavers iteration: `X ← X (I + M⁻¹)/2`, `M ← (I + (M + M⁻¹)/2)/2` tends to `I`, from `X = M = A`.
fn square_root(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let identity = DMatrix::<f64>::identity(n, n);
    let (mut x, mut m) = (a.clone(), a.clone());
    for _ in 0..MAX_NEWTON_STEPS {
        let inverse = solve(&m, &identity)?;
        x = product(&x, &(&identity + &inverse)) * 0.5;
        m = (&identity + (m + inverse) * 0.5) * 0.5;
        if one_norm(&(&m - &identity)) <= 4.0 * n as f64 * f64::EPSILON {
            return Some(x);
        }
    }
    // M may differ slightly from the identity; the caller checks the residual.
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_agrees_with_closed_forms() {
        let nilpotent = DMatrix::from_row_slice(2, 2, &[0.0, 3.0, 0.0, 0.0]);
        assert_eq!(exponential(&nilpotent).expect("finite")[(0, 1)], 3.0);
        let rotation = exponential(&DMatrix::from_row_slice(2, 2, &[0.0, -20.0, 20.0, 0.0])).expect("finite");
        assert!((rotation[(0, 0)] - 20f64.cos()).abs() < 1e-13);
        assert!((rotation[(1, 0)] - 20f64.sin()).abs() < 1e-13);
        for v in [-700.0, -3.0, 1e-9, 0.5, 10.0] {
            let e = exponential(&DMatrix::from_element(1, 1, v)).expect("finite")[(0, 0)];
            assert!((e / f64::exp(v) - 1.0).abs() < 1e-12, "exp({v}) gave {e}");
        }
        assert_eq!(exponential(&DMatrix::zeros(0, 0)).expect("empty").nrows(), 0);
    }

    #[test]
    fn the_exponential_rejects_overflow() {
        let big = DMatrix::from_element(1, 1, 1e4);
        assert_eq!(exponential(&big), Err(Error::ExponentialOverflow { norm: 1e4 }));
        assert!(matches!(exponential(&DMatrix::zeros(1, 2)), Err(Error::DimensionMismatch { .. })));
    }

    #[test]
    fn the_exponential_agrees_with_nalgebra() {
        let a = DMatrix::from_fn(6, 6, |i, j| ((7 * i + 3 * j) % 5) as f64 - 2.2);
        let (ours, theirs) = (exponential(&a).expect("finite"), a.exp());
        assert!(one_norm(&(&ours - &theirs)) < 1e-12 * one_norm(&theirs));
    }

    #[test]
    fn the_logarithm_inverts_the_exponential() {
        let a = DMatrix::from_row_slice(3, 3, &[-1.0, 2.5, 0.0, -2.5, -1.0, 1.0, 0.0, 0.0, -4.0]);
        let back = logarithm(&exponential(&a).expect("finite")).expect("principal");
        assert!(one_norm(&(back - a)) < 1e-12);
    }

    #[test]
    fn the_logarithm_rejects_delays_and_nyquist_oscillations() {
        for diagonal in [0.0, -0.5] {
            let a = DMatrix::from_diagonal(&nalgebra::dvector![0.9, diagonal]);
            assert!(matches!(logarithm(&a), Err(Error::NoRealLogarithm { re, .. }) if re == diagonal));
        }
    }
}
