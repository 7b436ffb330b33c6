//! A fitted regression.

use serde::{Deserialize, Serialize};

use crate::vector::dot;

/// A fitted ridge logistic regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogisticFit {
    /// The weight of each feature, shape (d).
    pub weights: Vec<f64>,
    /// The intercept.
    pub intercept: f64,
    /// The number of Newton steps.
    pub iterations: usize,
    /// Whether the gradient came below the tolerance before the steps ran out.
    pub converged: bool,
}

impl LogisticFit {
    /// The log odds of `true` at a row, shape (d).
    pub fn log_odds(&self, row: &[f64]) -> f64 {
        self.intercept + dot(&self.weights, row)
    }

    /// The probability of `true` at a row, shape (d).
    pub fn probability(&self, row: &[f64]) -> f64 {
        sigmoid(self.log_odds(row))
    }
}

/// 1/(1 + e^−z), without overflow.
fn sigmoid(z: f64) -> f64 {
    if z >= 0.0 {
        1.0 / (1.0 + libm::exp(-z))
    } else {
        let odds = libm::exp(z);
        odds / (1.0 + odds)
    }
}
