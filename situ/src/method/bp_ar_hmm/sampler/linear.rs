//! Small triangular algebra of static size, every sum in a fixed order and every root from `libm`.

use nalgebra::SMatrix;

/// L, lower triangular, with L Lᵀ = `matrix`, of which the lower triangle is read; `None` where it is not positive definite.
pub(super) fn cholesky<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let mut factor = SMatrix::<f64, D, D>::zeros();
    for row in 0..D {
        for column in 0..=row {
            let mut rest = matrix[(row, column)];
            for k in 0..column {
                rest -= factor[(row, k)] * factor[(column, k)];
            }
            if column < row {
                factor[(row, column)] = rest / factor[(column, column)];
            } else if rest.is_finite() && rest > 0.0 {
                factor[(row, row)] = libm::sqrt(rest);
            } else {
                return None;
            }
        }
    }
    Some(factor)
}

/// The inverse of a lower triangular matrix without a zero on its diagonal.
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
    let mut sum = 0.0;
    for axis in 0..D {
        sum += libm::log(lower[(axis, axis)]);
    }
    2.0 * sum
}

/// The sum of the squares of all entries.
pub(super) fn squared_norm<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    let mut sum = 0.0;
    for value in matrix.iter() {
        sum += value * value;
    }
    sum
}
