//! Small triangular algebra of static size: that of [`gaussian`] for nalgebra's matrices. Every sum has a fixed order
//! and every root is from `libm`.

use nalgebra::SMatrix;

use crate::method::gaussian;

/// L, lower triangular, with L Lᵀ = `matrix`, which is symmetric. `None` if it is not positive definite.
pub(super) fn cholesky<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    // The matrix is symmetric, so columns and rows are the same.
    let factor = gaussian::cholesky(&matrix.data.0)?;
    Some(SMatrix::from_fn(|row, column| factor[row][column]))
}

/// The inverse of a lower triangular matrix that has no zero on its diagonal.
pub(super) fn inverse_lower<const D: usize>(lower: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let mut inverse = SMatrix::<f64, D, D>::zeros();
    for column in 0..D {
        inverse[(column, column)] = 1.0 / lower[(column, column)];
        for row in column + 1..D {
            let mut sum = 0.0;
            for k in column..row {
                sum += lower[(row, k)] * inverse[(k, column)];
            }
            inverse[(row, column)] = -sum / lower[(row, row)];
        }
    }
    inverse
}

/// log |L Lᵀ| of a lower triangular L.
pub(super) fn log_determinant<const D: usize>(lower: &SMatrix<f64, D, D>) -> f64 {
    gaussian::log_determinant(&lower.data.0)
}

/// The sum of the squares of all entries.
pub(super) fn squared_norm<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    let mut sum = 0.0;
    for value in matrix.iter() {
        sum += value * value;
    }
    sum
}
