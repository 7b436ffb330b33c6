//! The covariance of an emission, with its Cholesky factor.

use nalgebra::Matrix6;

use super::parameters::HmmError;

/// A positive definite matrix.
pub(super) struct Covariance {
    pub(super) matrix: Matrix6<f64>,
    /// Its lower Cholesky factor.
    factor: Matrix6<f64>,
    pub(super) log_determinant: f64,
}

impl Covariance {
    /// # Errors
    /// [`HmmError::NotPositiveDefinite`] if it is not.
    pub(super) fn new(matrix: Matrix6<f64>) -> Result<Self, HmmError> {
        let mut factor = Matrix6::zeros();
        let mut pivots = [0.0; 6];
        for column in 0..6 {
            for row in column..6 {
                let mut value = matrix[(row, column)];
                for k in 0..column {
                    value -= factor[(row, k)] * factor[(column, k)];
                }
                if row > column {
                    factor[(row, column)] = value / factor[(column, column)];
                } else if value.is_finite() && value > 0.0 {
                    factor[(row, column)] = libm::sqrt(value);
                    pivots[column] = value;
                } else {
                    return Err(HmmError::NotPositiveDefinite);
                }
            }
        }
        // One logarithm of the product of the pivots, unless a float cannot hold the product.
        let times = |product: f64, pivot: &f64| Some(product * pivot).filter(|next| next.is_normal());
        let product = pivots.iter().try_fold(1.0, times);
        let log_determinant = product.map_or_else(|| pivots.iter().map(|pivot| libm::log(*pivot)).sum(), libm::log);
        Ok(Self { matrix, factor, log_determinant })
    }

    /// The inverse of the factor: W with Wᵀ W = Σ⁻¹, lower triangular.
    pub(super) fn inverse_factor(&self) -> Matrix6<f64> {
        let factor = &self.factor;
        let mut inverse = Matrix6::zeros();
        for row in 0..6 {
            let pivot = 1.0 / factor[(row, row)];
            for column in 0..row {
                let mut value = 0.0;
                for k in column..row {
                    value -= factor[(row, k)] * inverse[(k, column)];
                }
                inverse[(row, column)] = value * pivot;
            }
            inverse[(row, row)] = pivot;
        }
        inverse
    }
}
