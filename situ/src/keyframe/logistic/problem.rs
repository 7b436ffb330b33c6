//! The objective of a ridge logistic regression, and what both ways to its minimum share.

use super::{dot, sigmoid};

/// A step must gain this share of what its slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// Rounding errors of the objective that a step may lose: at the minimum no step gains anything.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Halvings of a step at most. Enough to bring the longest leap, the inverse of [`LEAST_CURVATURE`], back to 1.
const HALVINGS: usize = 60;
/// Least p(1 − p) of a sample in a step: far from the minimum the sigmoid is flat, and the step would have no end.
const LEAST_CURVATURE: f64 = 1e-10;

/// n samples of d features.
pub(super) struct Problem<'a> {
    /// Shape (n, d).
    pub(super) rows: &'a [&'a [f64]],
    /// Target t_i of each sample, shape (n).
    pub(super) targets: &'a [f64],
    /// Share s_i of each sample, shape (n), summing to 1.
    pub(super) shares: &'a [f64],
    /// λ.
    pub(super) ridge: f64,
}

impl Problem<'_> {
    /// z_i = b + w·x_i.
    pub(super) fn log_odds(&self, weights: &[f64], intercept: f64) -> Vec<f64> {
        self.rows.iter().map(|row| intercept + dot(weights, row)).collect()
    }

    /// Σ s_i (log(1 + e^z_i) − t_i z_i) + ½ λ |w|².
    pub(super) fn objective(&self, odds: &[f64], squared_weights: f64) -> f64 {
        let mut loss = 0.0;
        for ((z, target), share) in odds.iter().zip(self.targets).zip(self.shares) {
            // log(1 + e^z) − t z, every term of it above 0: no cancellation.
            let linear = if *z >= 0.0 { (1.0 - target) * z } else { -target * z };
            loss += share * (linear + libm::log1p(libm::exp(-z.abs())));
        }
        loss + 0.5 * self.ridge * squared_weights
    }

    /// r_i = s_i (p_i − t_i), the loss's slope in z_i, shape (n).
    pub(super) fn residuals(&self, odds: &[f64]) -> Vec<f64> {
        let terms = odds.iter().zip(self.targets).zip(self.shares);
        terms.map(|((z, target), share)| share * (sigmoid(*z) - target)).collect()
    }

    /// D_i = s_i p_i (1 − p_i), the loss's curvature in z_i, shape (n).
    pub(super) fn curvatures(&self, odds: &[f64]) -> Vec<f64> {
        let terms = odds.iter().zip(self.shares);
        terms.map(|(z, share)| share * (sigmoid(*z) * sigmoid(-z)).max(LEAST_CURVATURE)).collect()
    }

    /// Xᵀ v added to `sums`, shape (d).
    pub(super) fn add_transposed(&self, v: &[f64], sums: &mut [f64]) {
        for (row, factor) in self.rows.iter().zip(v) {
            sums.iter_mut().zip(*row).for_each(|(sum, value)| *sum += factor * value);
        }
    }

    /// The gradient: the weights' components, then the intercept's; shape (d + 1).
    pub(super) fn gradient(&self, weights: &[f64], odds: &[f64]) -> Vec<f64> {
        let residuals = self.residuals(odds);
        let mut gradient: Vec<f64> = weights.iter().map(|weight| self.ridge * weight).collect();
        self.add_transposed(&residuals, &mut gradient);
        gradient.push(residuals.iter().sum());
        gradient
    }
}

/// `base` + `length` × `step`.
pub(super) fn along(base: &[f64], step: &[f64], length: f64) -> Vec<f64> {
    base.iter().zip(step).map(|(base, step)| base + length * step).collect()
}

/// Halves a step until the objective falls as the slope promises; its length, and what `objective` gave with its value
/// there. None where no length will do.
pub(super) fn search<T>(value: f64, slope: f64, objective: impl Fn(f64) -> (f64, T)) -> Option<(f64, f64, T)> {
    let mut length = 1.0;
    for _ in 0..HALVINGS {
        let (trial, what) = objective(length);
        if trial <= value + SUFFICIENT * length * slope + ROUNDING * value.abs() {
            return Some((length, trial, what));
        }
        length *= 0.5;
    }
    None
}
