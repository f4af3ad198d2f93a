//! The eight routines of BLAS and LAPACK that the solver of semidefinite programmes calls, on nalgebra.
//!
//! clarabel is linked against whatever gives these names. A system's library would be one more thing to install and gives
//! other bits on other machines; the matrices here have ten rows, on which nothing is gained. What the solver finds is
//! verified apart from it (`interval.rs`), so that no verdict rests on this file. nalgebra's own SVD is not used, as it is wrong
//! for some matrices; the one here is Jacobi's, one-sided (Golub and Van Loan, *Matrix Computations*, section 8.6.3).
//!
//! A programme that links trocar as a library and a system's BLAS as well has each of these names twice, which its linker
//! tells; it is the price of needing no such library.
//!
//! Matrices are stored column by column, `lda` apart. Only what clarabel asks for is there: symmetric eigenvalues of all
//! kinds (`range = 'A'`), thin singular vectors (`'S'`).

#![allow(unsafe_code, reason = "names that a linker finds, and arguments as C has them")]
#![allow(clippy::too_many_arguments, reason = "as many as the routines have")]

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};
use std::ffi::{c_char, c_int};

/// Sweeps after which rotations give up; ten are many.
const MAX_SWEEPS: usize = 60;

/// Rows `rows` and columns `columns` of what is stored at `at`.
///
/// # Safety
/// `at` points to a matrix of at least that size, `stride` apart, that nobody writes to meanwhile.
unsafe fn read(at: *const f64, rows: usize, columns: usize, stride: usize) -> DMatrix<f64> {
    // SAFETY: the caller's promise; the last column need not be stored beyond its last row.
    DMatrix::from_fn(rows, columns, |i, j| unsafe { *at.add(i + j * stride) })
}

/// Stores a matrix; of a triangle (`'U'`, `'L'`) that one only.
///
/// # Safety
/// As [`read`], and nobody reads there either.
unsafe fn write(to: *mut f64, matrix: &DMatrix<f64>, stride: usize, triangle: Option<u8>) {
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            let is_in = match triangle {
                None => true,
                Some(b'U') => i <= j,
                Some(_) => i >= j,
            };
            if is_in {
                // SAFETY: the caller's promise.
                unsafe { *to.add(i + j * stride) = matrix[(i, j)] };
            }
        }
    }
}

/// A symmetric matrix from its triangle.
fn mirrored(mut matrix: DMatrix<f64>, triangle: u8) -> DMatrix<f64> {
    if triangle == b'U' {
        matrix.fill_lower_triangle_with_upper_triangle()
    } else {
        matrix.fill_upper_triangle_with_lower_triangle()
    }
    matrix
}

/// Eigenvalues, increasing, and their vectors; none where the iteration does not end.
fn symmetric_eigen(matrix: DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let found = SymmetricEigen::try_new(matrix, f64::EPSILON, 10_000)?;
    let mut order: Vec<usize> = (0..found.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
    let values = order.iter().map(|&k| found.eigenvalues[k]).collect();
    Some((values, found.eigenvectors.select_columns(&order)))
}

/// `A = U diag(s) Vᵀ` with `s` decreasing, by rotations of columns until all are at right angles; for at least as many rows as
/// columns.
fn tall_singular_values(a: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>, DMatrix<f64>) {
    let n = a.ncols();
    let (mut u, mut v) = (a.clone(), DMatrix::identity(n, n));
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let (app, aqq) = (u.column(p).norm_squared(), u.column(q).norm_squared());
                let apq = u.column(p).dot(&u.column(q));
                if apq.abs() <= f64::EPSILON * (app * aqq).sqrt() || apq == 0.0 {
                    continue;
                }
                turned = true;
                let zeta = (aqq - app) / (2.0 * apq);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = cosine * tangent;
                for matrix in [&mut u, &mut v] {
                    for i in 0..matrix.nrows() {
                        let (x, y) = (matrix[(i, p)], matrix[(i, q)]);
                        matrix[(i, p)] = cosine * x - sine * y;
                        matrix[(i, q)] = sine * x + cosine * y;
                    }
                }
            }
        }
        if !turned {
            break;
        }
    }
    let lengths: Vec<f64> = u.column_iter().map(|column| column.norm()).collect();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| lengths[b].total_cmp(&lengths[a]));
    let mut left = u.select_columns(&order);
    let s: Vec<f64> = order.iter().map(|&k| lengths[k]).collect();
    for (k, &length) in s.iter().enumerate() {
        if length > 0.0 {
            left.column_mut(k).scale_mut(1.0 / length);
        }
    }
    (left, s, v.select_columns(&order))
}

/// `U`, `s` and `Vᵀ`, thin.
fn singular_values(a: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>, DMatrix<f64>) {
    if a.nrows() >= a.ncols() {
        let (u, s, v) = tall_singular_values(a);
        return (u, s, v.transpose());
    }
    let (u, s, v) = tall_singular_values(&a.transpose());
    (v, s, u.transpose())
}

/// What a matrix is used as: itself, or transposed.
///
/// # Safety
/// As [`read`].
unsafe fn operand(at: *const f64, way: u8, rows: usize, columns: usize, stride: usize) -> DMatrix<f64> {
    // SAFETY: the caller's promise.
    unsafe { if way == b'N' { read(at, rows, columns, stride) } else { read(at, columns, rows, stride).transpose() } }
}

/// `C = product + beta C`, where `C` is not read when `beta` is 0.
///
/// # Safety
/// As [`write`].
unsafe fn accumulate(product: DMatrix<f64>, beta: f64, c: *mut f64, stride: usize, triangle: Option<u8>) {
    // SAFETY: the caller's promise.
    unsafe {
        let sum = if beta == 0.0 {
            product
        } else {
            let mut before = read(c, product.nrows(), product.ncols(), stride);
            if let Some(triangle) = triangle {
                before = mirrored(before, triangle);
            }
            product + before * beta
        };
        write(c, &sum, stride, triangle);
    }
}

/// # Safety
/// The arguments of BLAS's `dgemm`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dgemm_(
    way_a: *const c_char,
    way_b: *const c_char,
    m: *const c_int,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        let (m, n, k) = (*m as usize, *n as usize, *k as usize);
        let a = operand(a, *way_a as u8, m, k, *lda as usize);
        let b = operand(b, *way_b as u8, k, n, *ldb as usize);
        accumulate(a * b * *alpha, *beta, c, *ldc as usize, None);
    }
}

/// # Safety
/// The arguments of BLAS's `dsyrk`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dsyrk_(
    triangle: *const c_char,
    way: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        let a = operand(a, *way as u8, *n as usize, *k as usize, *lda as usize);
        let product = &a * a.transpose() * *alpha;
        accumulate(product, *beta, c, *ldc as usize, Some(*triangle as u8));
    }
}

/// # Safety
/// The arguments of BLAS's `dsyr2k`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dsyr2k_(
    triangle: *const c_char,
    way: *const c_char,
    n: *const c_int,
    k: *const c_int,
    alpha: *const f64,
    a: *const f64,
    lda: *const c_int,
    b: *const f64,
    ldb: *const c_int,
    beta: *const f64,
    c: *mut f64,
    ldc: *const c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        let (n, k) = (*n as usize, *k as usize);
        let a = operand(a, *way as u8, n, k, *lda as usize);
        let b = operand(b, *way as u8, n, k, *ldb as usize);
        let product = (&a * b.transpose() + &b * a.transpose()) * *alpha;
        accumulate(product, *beta, c, *ldc as usize, Some(*triangle as u8));
    }
}

/// # Safety
/// The arguments of LAPACK's `dpotrf`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dpotrf_(
    triangle: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        let (n, stride, triangle) = (*n as usize, *lda as usize, *triangle as u8);
        *info = match Cholesky::new(mirrored(read(a, n, n, stride), triangle)) {
            Some(found) => {
                let l = found.l();
                let factor = if triangle == b'U' { l.transpose() } else { l };
                write(a, &factor, stride, Some(triangle));
                0
            }
            None => 1,
        };
    }
}

/// # Safety
/// The arguments of LAPACK's `dpotrs`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dpotrs_(
    triangle: *const c_char,
    n: *const c_int,
    columns: *const c_int,
    a: *const f64,
    lda: *const c_int,
    b: *mut f64,
    ldb: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        let (n, stride) = (*n as usize, *ldb as usize);
        let factor = read(a, n, n, *lda as usize);
        let lower = if *triangle as u8 == b'U' { factor.transpose() } else { factor };
        let mut x = read(b, n, *columns as usize, stride);
        let solved = lower.solve_lower_triangular_mut(&mut x) && lower.tr_solve_lower_triangular_mut(&mut x);
        write(b, &x, stride, None);
        *info = c_int::from(!solved);
    }
}

/// # Safety
/// The arguments of LAPACK's `dsyevr`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dsyevr_(
    job: *const c_char,
    _range: *const c_char,
    triangle: *const c_char,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    _lower: *const f64,
    _upper: *const f64,
    _first: *const c_int,
    _last: *const c_int,
    _tolerance: *const f64,
    found: *mut c_int,
    w: *mut f64,
    z: *mut f64,
    ldz: *const c_int,
    _support: *mut c_int,
    work: *mut f64,
    lwork: *const c_int,
    iwork: *mut c_int,
    liwork: *const c_int,
    info: *mut c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        *info = 0;
        if *lwork == -1 || *liwork == -1 {
            (*work, *iwork) = (1.0, 1);
            return;
        }
        let size = *n as usize;
        let Some((values, vectors)) = symmetric_eigen(mirrored(read(a, size, size, *lda as usize), *triangle as u8))
        else {
            *info = 1;
            return;
        };
        *found = *n;
        for (k, value) in values.into_iter().enumerate() {
            *w.add(k) = value;
        }
        if *job as u8 == b'V' {
            write(z, &vectors, *ldz as usize, None);
        }
    }
}

/// # Safety
/// The arguments of LAPACK's `dgesdd`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dgesdd_(
    _job: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    _iwork: *mut c_int,
    info: *mut c_int,
) {
    // SAFETY: what the routine promises of its arguments.
    unsafe {
        *info = 0;
        if *lwork == -1 {
            *work = 1.0;
            return;
        }
        let (left, values, right) = singular_values(&read(a, *m as usize, *n as usize, *lda as usize));
        for (k, value) in values.into_iter().enumerate() {
            *s.add(k) = value;
        }
        write(u, &left, *ldu as usize, None);
        write(vt, &right, *ldvt as usize, None);
    }
}

/// # Safety
/// The arguments of LAPACK's `dgesvd`.
#[unsafe(no_mangle)]
unsafe extern "C" fn dgesvd_(
    job: *const c_char,
    _job_right: *const c_char,
    m: *const c_int,
    n: *const c_int,
    a: *mut f64,
    lda: *const c_int,
    s: *mut f64,
    u: *mut f64,
    ldu: *const c_int,
    vt: *mut f64,
    ldvt: *const c_int,
    work: *mut f64,
    lwork: *const c_int,
    info: *mut c_int,
) {
    let mut unused = 0;
    // SAFETY: the same arguments, but for integers to work with, which are not used.
    unsafe { dgesdd_(job, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, &mut unused, info) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1 that no pattern is seen in.
    fn scattered(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| ((7 * i + 13 * j + i * j) as f64 * 1.7).sin())
    }

    #[test]
    fn singular_values_of_all_ones_are_right_and_every_product_is_the_matrix() {
        let (_, s, _) = singular_values(&DMatrix::from_element(3, 5, 1.0));
        assert!((s[0] - 15.0_f64.sqrt()).abs() < 1e-14 && s[1] < 1e-14);
        for (rows, columns) in [(4, 4), (7, 3), (3, 7), (10, 10), (1, 5)] {
            let a = scattered(rows, columns);
            let (u, s, vt) = singular_values(&a);
            assert!(s.windows(2).all(|pair| pair[0] >= pair[1]));
            let again = &u * DMatrix::from_diagonal(&s.into()) * &vt;
            assert!((again - &a).norm() < 1e-13);
        }
    }

    #[test]
    fn eigenvalues_come_in_order_with_their_vectors() {
        let a = scattered(9, 9);
        let symmetric = &a + a.transpose();
        let (values, vectors) = symmetric_eigen(symmetric.clone()).expect("found");
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!((&symmetric * &vectors - &vectors * DMatrix::from_diagonal(&values.into())).norm() < 1e-12);
    }

    #[test]
    fn a_factor_solves_and_the_other_triangle_is_left_alone() {
        let root = scattered(5, 5);
        let a = &root * root.transpose() + DMatrix::identity(5, 5);
        for triangle in [b'U', b'L'] {
            let (n, one, mut info) = (5 as c_int, 1 as c_int, 7);
            let mark = triangle as c_char;
            let mut factor = a.clone();
            let b = scattered(5, 1);
            let mut x = b.clone();
            // SAFETY: matrices of five rows, stored without gaps.
            unsafe {
                dpotrf_(&mark, &n, factor.as_mut_ptr(), &n, &mut info);
                dpotrs_(&mark, &n, &one, factor.as_ptr(), &n, x.as_mut_ptr(), &n, &mut info);
            }
            assert_eq!(info, 0);
            assert!((&a * x - b).norm() < 1e-12);
            let other = if triangle == b'U' { (4, 0) } else { (0, 4) };
            assert_eq!(factor[other], a[other]);
        }
    }
}
