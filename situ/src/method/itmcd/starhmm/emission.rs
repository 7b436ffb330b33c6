//! The linear Gaussian emission of a phase.

use super::cholesky;
use crate::vector::dot;

/// log 2π.
const LOG_TWO_PI: f64 = 1.837_877_066_409_345_3;
/// A phase with less weight than this, in steps, keeps its emission: there is nothing to fit to.
const LEAST_WEIGHT: f64 = 1e-9;

/// y | x ~ N(W x, Σ).
#[derive(Clone, Debug, PartialEq)]
pub struct LinearGaussian {
    /// W, row-major, shape (d, m).
    weights: Vec<f64>,
    /// Σ, row-major, shape (d, d).
    covariance: Vec<f64>,
    inputs: usize,
    /// L with L Lᵀ = Σ.
    factor: Vec<f64>,
    /// −½ (d log 2π + log det Σ).
    log_norm: f64,
}

/// One weighted sample: weight, x and y.
pub(crate) type Sample<'a> = (f64, &'a [f64], &'a [f64]);

impl LinearGaussian {
    /// An emission with this W, row-major, shape (d, m), and this Σ, row-major, shape (d, d). `None` if the shapes do
    /// not fit or Σ is not positive definite.
    pub fn new(weights: Vec<f64>, covariance: Vec<f64>, inputs: usize) -> Option<Self> {
        let outputs = weights.len().checked_div(inputs)?;
        if outputs == 0 || outputs * inputs != weights.len() || covariance.len() != outputs * outputs {
            return None;
        }
        let mut factor = covariance.clone();
        if !weights.iter().all(|value| value.is_finite()) || !cholesky::factor(&mut factor, outputs) {
            return None;
        }
        let half_log_determinant: f64 = (0..outputs).map(|row| libm::log(factor[row * outputs + row])).sum();
        let log_norm = -0.5 * outputs as f64 * LOG_TWO_PI - half_log_determinant;
        Some(Self { weights, covariance, inputs, factor, log_norm })
    }

    /// W, row-major, shape (d, m).
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Σ, row-major, shape (d, d).
    pub fn covariance(&self) -> &[f64] {
        &self.covariance
    }

    /// d.
    pub fn outputs(&self) -> usize {
        self.weights.len() / self.inputs
    }

    /// m.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// d m + d (d + 1)/2.
    pub fn free_parameters(&self) -> usize {
        let outputs = self.outputs();
        self.weights.len() + outputs * (outputs + 1) / 2
    }

    /// log N(y; W x, Σ).
    pub fn log_density(&self, regressors: &[f64], target: &[f64]) -> f64 {
        let outputs = self.outputs();
        let mut residual = residual(&self.weights, regressors, target);
        // Forward substitution: |L⁻¹ r|² is the squared Mahalanobis distance.
        for row in 0..outputs {
            let own = &self.factor[row * outputs..row * outputs + row + 1];
            residual[row] = (residual[row] - dot(&own[..row], &residual[..row])) / own[row];
        }
        self.log_norm - 0.5 * dot(&residual, &residual)
    }

    /// The weighted ridge least squares of W, and Σ = Σ_n γ r rᵀ / Σ_n γ + ε I. `None` if there is nothing to fit to,
    /// or the normal equations cannot be solved.
    pub(crate) fn fit(samples: &[Sample<'_>], ridge: f64, floor: f64) -> Option<Self> {
        let (_, x, y) = samples.first()?;
        let (inputs, outputs) = (x.len(), y.len());
        let total: f64 = samples.iter().map(|(weight, ..)| weight).sum();
        if total < LEAST_WEIGHT {
            return None;
        }
        let mut gram = vec![0.0; inputs * inputs];
        let mut cross = vec![0.0; outputs * inputs];
        for (weight, x, y) in samples {
            add_outer(&mut gram, *weight, x, x);
            add_outer(&mut cross, *weight, y, x);
        }
        for index in 0..inputs {
            gram[index * inputs + index] += ridge;
        }
        if !cholesky::factor(&mut gram, inputs) {
            return None;
        }
        cross.chunks_exact_mut(inputs).for_each(|row| cholesky::solve(&gram, inputs, row));
        let mut covariance = vec![0.0; outputs * outputs];
        for (weight, x, y) in samples {
            let residual = residual(&cross, x, y);
            add_outer(&mut covariance, weight / total, &residual, &residual);
        }
        for index in 0..outputs {
            covariance[index * outputs + index] += floor;
        }
        Self::new(cross, covariance, inputs)
    }

    /// Σ_n γ log N(y; W x, Σ), which an M-step must not lower.
    fn expected(&self, samples: &[Sample<'_>]) -> f64 {
        samples.iter().map(|(weight, x, y)| weight * self.log_density(x, y)).sum()
    }

    /// The M-step, made monotone. The fit is taken unless ridge and floor make this sum lower. Then its W is tried with
    /// the old Σ. If the sum is lower with that too, nothing changes.
    pub(super) fn improve(&mut self, samples: &[Sample<'_>], ridge: f64, floor: f64) {
        let Some(fit) = Self::fit(samples, ridge, floor) else { return };
        let before = self.expected(samples);
        let mixed = Self { weights: fit.weights.clone(), ..self.clone() };
        if let Some(better) = [fit, mixed].into_iter().find(|emission| emission.expected(samples) >= before) {
            *self = better;
        }
    }
}

/// y − W x.
fn residual(weights: &[f64], x: &[f64], y: &[f64]) -> Vec<f64> {
    weights.chunks_exact(x.len()).zip(y).map(|(row, y)| y - dot(row, x)).collect()
}

/// `sums` += `weight` · l rᵀ.
fn add_outer(sums: &mut [f64], weight: f64, left: &[f64], right: &[f64]) {
    for (row, left) in sums.chunks_exact_mut(right.len()).zip(left) {
        row.iter_mut().zip(right).for_each(|(sum, right)| *sum += weight * left * right);
    }
}
