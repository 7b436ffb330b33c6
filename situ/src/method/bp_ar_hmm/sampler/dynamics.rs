//! The dynamics of one behaviour, x_t = A y_t + e with e ~ N(0, Σ) and y_t = x_{t−1}. Their conjugate prior is the
//! matrix normal inverse Wishart: Σ ~ IW(ν, S₀), A | Σ ~ MN(0, Σ, K) (West and Harrison 1997, chapter 16; Fox et al.
//! 2009).

use core::f64::consts::{LN_2, PI};

use nalgebra::{SMatrix, SVector};
use rand::Rng;
use serde::Serialize;

use super::draw::gamma;
use crate::method::gaussian;
use crate::random::standard_normal;

/// The prior; its mean of A is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct DynamicsPrior<const D: usize> {
    /// K⁻¹, the precision of the columns of A, shape (D, D), symmetric positive definite.
    pub precision: SMatrix<f64, D, D>,
    /// S₀, shape (D, D), symmetric positive definite; in squared units of the observation.
    pub scale: SMatrix<f64, D, D>,
    /// ν, the degrees of freedom. At least D + 2, so that Σ has a mean, which is S₀ / (ν − D − 1).
    pub freedom: f64,
}

/// The statistics of a set of frames, which is all that the posterior depends on. X are the current frames and Y the
/// lagged ones, as columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics<const D: usize> {
    /// The number of frames.
    pub frames: f64,
    /// X Xᵀ.
    pub current: SMatrix<f64, D, D>,
    /// X Yᵀ.
    pub cross: SMatrix<f64, D, D>,
    /// Y Yᵀ.
    pub lagged: SMatrix<f64, D, D>,
}

impl<const D: usize> Default for Statistics<D> {
    fn default() -> Self {
        let zeros = SMatrix::zeros();
        Self { frames: 0.0, current: zeros, cross: zeros, lagged: zeros }
    }
}

impl<const D: usize> Statistics<D> {
    /// Adds one frame, `weight` times. A weight of −1 removes it.
    pub fn add(&mut self, current: &SVector<f64, D>, lagged: &SVector<f64, D>, weight: f64) {
        self.frames += weight;
        for row in 0..D {
            for column in 0..D {
                self.current[(row, column)] += weight * current[row] * current[column];
                self.cross[(row, column)] += weight * current[row] * lagged[column];
                self.lagged[(row, column)] += weight * lagged[row] * lagged[column];
            }
        }
    }

    /// The statistics of the frames of both.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            frames: self.frames + other.frames,
            current: self.current + other.current,
            cross: self.cross + other.cross,
            lagged: self.lagged + other.lagged,
        }
    }
}

/// θ = (A, Σ): the dynamics of one behaviour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dynamics<const D: usize> {
    /// A, shape (D, D).
    pub transition: SMatrix<f64, D, D>,
    /// Σ, shape (D, D).
    pub covariance: SMatrix<f64, D, D>,
    /// The inverse of the lower Cholesky factor of Σ.
    #[serde(skip)]
    whitening: SMatrix<f64, D, D>,
    /// `whitening` · A.
    #[serde(skip)]
    whitened: SMatrix<f64, D, D>,
    /// log |Σ|.
    #[serde(skip)]
    log_determinant: f64,
    /// D log 2π + log |Σ|.
    #[serde(skip)]
    log_normaliser: f64,
}

impl<const D: usize> Dynamics<D> {
    /// The dynamics with this A and Σ. `None` if Σ is not positive definite.
    pub fn new(transition: SMatrix<f64, D, D>, covariance: SMatrix<f64, D, D>) -> Option<Self> {
        let factor = cholesky(&covariance)?;
        let whitening = inverse_lower(&factor);
        let whitened = whitening * transition;
        let log_determinant = log_determinant(&factor);
        let log_normaliser = D as f64 * libm::log(2.0 * PI) + log_determinant;
        Some(Self { transition, covariance, whitening, whitened, log_determinant, log_normaliser })
    }

    /// log N(`current`; A `lagged`, Σ).
    pub fn log_density(&self, current: &SVector<f64, D>, lagged: &SVector<f64, D>) -> f64 {
        let mut squares = 0.0;
        for row in 0..D {
            let mut residual = 0.0;
            for column in 0..=row {
                residual += self.whitening[(row, column)] * current[column];
            }
            for column in 0..D {
                residual -= self.whitened[(row, column)] * lagged[column];
            }
            squares += residual * residual;
        }
        -0.5 * (self.log_normaliser + squares)
    }
}

/// The posterior of θ given frames, which has the form of the prior. Without a frame it is the prior.
#[derive(Clone, Debug)]
pub struct DynamicsPosterior<const D: usize> {
    /// S_xy S_yy⁻¹, the mean of A.
    pub mean: SMatrix<f64, D, D>,
    /// S = S₀ + S_xx − A S_xyᵀ.
    pub scale: SMatrix<f64, D, D>,
    /// ν + n.
    pub freedom: f64,
    /// The lower factor of S.
    scale_factor: SMatrix<f64, D, D>,
    /// The lower factor of S_yy = Y Yᵀ + K⁻¹.
    precision_factor: SMatrix<f64, D, D>,
}

impl<const D: usize> DynamicsPrior<D> {
    /// The posterior given frames. `None` if rounding leaves a matrix that is not positive definite.
    pub fn posterior(&self, statistics: &Statistics<D>) -> Option<DynamicsPosterior<D>> {
        let precision_factor = cholesky(&(statistics.lagged + self.precision))?;
        let inverse = inverse_lower(&precision_factor);
        let half = statistics.cross * inverse.transpose();
        let scale = self.scale + statistics.current - half * half.transpose();
        let freedom = self.freedom + statistics.frames;
        Some(DynamicsPosterior {
            mean: half * inverse,
            scale,
            freedom,
            scale_factor: cholesky(&scale)?,
            precision_factor,
        })
    }

    /// log p(X | Y), with θ integrated out. `None` as for [`DynamicsPrior::posterior`].
    pub fn log_evidence(&self, statistics: &Statistics<D>) -> Option<f64> {
        let (prior, posterior) = (self.posterior(&Statistics::default())?, self.posterior(statistics)?);
        Some(prior.log_normaliser() - posterior.log_normaliser() - 0.5 * statistics.frames * D as f64 * libm::log(PI))
    }
}

impl<const D: usize> DynamicsPosterior<D> {
    /// D/2 log |S_yy| + ν/2 log |S| − log Γ_D(ν/2).
    fn log_normaliser(&self) -> f64 {
        0.5 * D as f64 * log_determinant(&self.precision_factor)
            + 0.5 * self.freedom * log_determinant(&self.scale_factor)
            - log_multivariate_gamma::<D>(0.5 * self.freedom)
    }

    /// A draw: Σ by Bartlett's decomposition, then A.
    pub fn draw(&self, rng: &mut impl Rng) -> Option<Dynamics<D>> {
        let mut bartlett = SMatrix::<f64, D, D>::zeros();
        for row in 0..D {
            for column in 0..row {
                bartlett[(row, column)] = standard_normal(rng);
            }
            bartlett[(row, row)] = libm::sqrt(2.0 * gamma(0.5 * (self.freedom - row as f64), rng));
        }
        let root = self.scale_factor * inverse_lower(&bartlett).transpose();
        let covariance = root * root.transpose();
        let normal = SMatrix::<f64, D, D>::from_fn(|_, _| standard_normal(rng));
        let factor = cholesky(&covariance)?;
        Dynamics::new(self.mean + factor * normal * inverse_lower(&self.precision_factor), covariance)
    }

    /// log density of θ.
    pub fn log_density(&self, dynamics: &Dynamics<D>) -> f64 {
        let d = D as f64;
        let wishart = 0.5 * self.freedom * (log_determinant(&self.scale_factor) - d * LN_2)
            - log_multivariate_gamma::<D>(0.5 * self.freedom)
            - 0.5 * (self.freedom + d + 1.0) * dynamics.log_determinant
            - 0.5 * squared_norm(&(dynamics.whitening * self.scale_factor));
        let apart = dynamics.whitening * (dynamics.transition - self.mean) * self.precision_factor;
        let normal = 0.5 * d * (log_determinant(&self.precision_factor) - dynamics.log_determinant)
            - 0.5 * d * d * libm::log(2.0 * PI)
            - 0.5 * squared_norm(&apart);
        wishart + normal
    }

    /// The dynamics at the posterior means of A and of Σ.
    pub fn at_mean(&self) -> Option<Dynamics<D>> {
        Dynamics::new(self.mean, self.scale / (self.freedom - D as f64 - 1.0))
    }
}

/// log Γ_D(x), the multivariate gamma function.
fn log_multivariate_gamma<const D: usize>(x: f64) -> f64 {
    let mut sum = 0.25 * (D * (D - 1)) as f64 * libm::log(PI);
    for axis in 0..D {
        sum += libm::lgamma(x - 0.5 * axis as f64);
    }
    sum
}

/// L, lower triangular, with L Lᵀ = `matrix`, which is symmetric. `None` if it is not positive definite.
fn cholesky<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    // The matrix is symmetric, so columns and rows are the same.
    let factor = gaussian::cholesky(&matrix.data.0)?;
    Some(SMatrix::from_fn(|row, column| factor[row][column]))
}

/// The inverse of a lower triangular matrix that has no zero on its diagonal.
fn inverse_lower<const D: usize>(lower: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
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
fn log_determinant<const D: usize>(lower: &SMatrix<f64, D, D>) -> f64 {
    gaussian::log_determinant(&lower.data.0)
}

/// The sum of the squares of all entries.
fn squared_norm<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    let mut sum = 0.0;
    for value in matrix.iter() {
        sum += value * value;
    }
    sum
}
