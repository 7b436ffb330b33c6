//! The Gaussian of a hidden state, as the kernels take it.

use nalgebra::Matrix6;

use crate::vector::{Four, Wide};

/// The number of dimensions of a tangent vector.
pub(super) const AXES: usize = 6;
/// The number of entries of a lower triangle.
pub(super) const TRIANGLE: usize = AXES * (AXES + 1) / 2;

/// The log density of a Gaussian as a function of the residuals: `log_normaliser` − ½ |W r|².
pub(super) struct Gaussian {
    /// The lower triangle of W, row by row.
    whitening: [f64; TRIANGLE],
    log_normaliser: f64,
}

impl Gaussian {
    /// From W, which is lower triangular; |W r|² is the squared Mahalanobis length of r.
    pub(super) fn new(whitening: &Matrix6<f64>, log_normaliser: f64) -> Self {
        let mut triangle = [0.0; TRIANGLE];
        let mut at = 0;
        for row in 0..AXES {
            for column in 0..=row {
                triangle[at] = whitening[(row, column)];
                at += 1;
            }
        }
        Self { whitening: triangle, log_normaliser }
    }

    /// The log densities of four residuals.
    #[inline(always)]
    pub(super) fn log_densities<S: Wide>(&self, simd: S, residuals: [Four<S>; AXES]) -> Four<S> {
        let mut squared = Four::splat(simd, 0.0);
        let mut at = 0;
        for row in 0..AXES {
            let mut whitened = residuals[0] * self.whitening[at];
            at += 1;
            for residual in &residuals[1..=row] {
                whitened += *residual * self.whitening[at];
                at += 1;
            }
            squared += whitened * whitened;
        }
        Four::splat(simd, self.log_normaliser) - squared * 0.5
    }
}
