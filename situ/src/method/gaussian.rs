//! Gaussians of a fixed number of dimensions, in plain loops of fixed order: the same bits on every machine.

use core::f64::consts::PI;

/// A square matrix, row by row.
pub type Square<const D: usize> = [[f64; D]; D];

/// L, lower triangular, with L Lᵀ = m. `None` if m is not positive definite.
pub fn cholesky<const D: usize>(matrix: &Square<D>) -> Option<Square<D>> {
    let mut factor = [[0.0; D]; D];
    for column in 0..D {
        for row in column..D {
            let known = (0..column).map(|k| factor[row][k] * factor[column][k]).sum::<f64>();
            let value = matrix[row][column] - known;
            if row > column {
                factor[row][column] = value / factor[column][column];
            } else if value.is_finite() && value > 0.0 {
                factor[row][column] = libm::sqrt(value);
            } else {
                return None;
            }
        }
    }
    Some(factor)
}

/// The solution x of L x = b.
pub fn forward<const D: usize>(factor: &Square<D>, b: &[f64; D]) -> [f64; D] {
    let mut x = [0.0; D];
    for row in 0..D {
        let known = (0..row).map(|k| factor[row][k] * x[k]).sum::<f64>();
        x[row] = (b[row] - known) / factor[row][row];
    }
    x
}

/// The solution x of Lᵀ x = b.
pub fn backward<const D: usize>(factor: &Square<D>, b: &[f64; D]) -> [f64; D] {
    let mut x = [0.0; D];
    for row in (0..D).rev() {
        let known = (row + 1..D).map(|k| factor[k][row] * x[k]).sum::<f64>();
        x[row] = (b[row] - known) / factor[row][row];
    }
    x
}

/// log |L Lᵀ|.
pub fn log_determinant<const D: usize>(factor: &Square<D>) -> f64 {
    (0..D).map(|axis| 2.0 * libm::log(factor[axis][axis])).sum()
}

/// The log density at `x` of the Gaussian with this mean and the covariance L Lᵀ.
pub fn log_density<const D: usize>(mean: &[f64; D], factor: &Square<D>, x: &[f64; D]) -> f64 {
    let mut error = [0.0; D];
    for axis in 0..D {
        error[axis] = x[axis] - mean[axis];
    }
    let squared: f64 = forward(factor, &error).iter().map(|value| value * value).sum();
    -0.5 * (D as f64 * libm::log(2.0 * PI) + log_determinant(factor) + squared)
}
