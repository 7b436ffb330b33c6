//! The objective of a ridge logistic regression, what both ways to its minimum share, and what they find.

use serde::{Deserialize, Serialize};

use crate::vector::{EIGHT, Four, Wide, dot, exp, fours, fours_mut, joined, log_1p};

/// A step must gain at least this share of what its slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// A step may lose so much of the objective by rounding: at the minimum no step gains anything.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// The greatest number of halvings of a step. It is enough to bring the longest step, the inverse of
/// [`LEAST_CURVATURE`], back to 1.
const HALVINGS: usize = 60;
/// The least p(1 − p) of a sample in a step. Far from the minimum the sigmoid is flat, and the step would be unbounded.
const LEAST_CURVATURE: f64 = 1e-10;
/// n samples of d features.
pub(super) struct Problem<'a> {
    /// Shape (n, d).
    pub(super) rows: &'a [&'a [f64]],
    /// d.
    pub(super) dimension: usize,
    /// The target t_i of each sample, shape (n), padded with zeros.
    pub(super) targets: &'a [f64],
    /// The share s_i of each sample, shape (n), padded with zeros, so the padding has no weight. The shares sum to 1.
    pub(super) shares: &'a [f64],
    /// λ.
    pub(super) ridge: f64,
}

/// The slopes of the loss at some log odds, one number per sample, padded.
pub(super) struct Slopes {
    /// r_i = s_i (p_i − t_i), the slope of the loss in z_i.
    pub(super) residuals: Vec<f64>,
    /// D_i = s_i p_i (1 − p_i), the curvature of the loss in z_i.
    pub(super) curvatures: Vec<f64>,
}

impl Slopes {
    /// Allocates the slopes of so many samples.
    pub(super) fn new(samples: usize) -> Self {
        let zeros = vec![0.0; samples.next_multiple_of(EIGHT)];
        Self { residuals: zeros.clone(), curvatures: zeros }
    }

    /// Computes the slopes at the log odds of a panel of samples, which begins with the sample `first`. Adds Σ s_i
    /// (log(1 + e^z_i) − t_i z_i) to the running sums.
    #[inline(always)]
    pub(super) fn set<S: Wide>(
        &mut self,
        simd: S,
        problem: &Problem,
        first: usize,
        odds: &[f64],
        losses: &mut Four<S>,
    ) {
        let panel = first..first + odds.len();
        let given = fours(&problem.targets[panel.clone()]).iter().zip(fours(&problem.shares[panel.clone()]));
        let residuals = fours_mut(&mut self.residuals[panel.clone()]).iter_mut();
        let slopes = residuals.zip(fours_mut(&mut self.curvatures[panel]));
        let (zero, one) = (Four::splat(simd, 0.0), Four::splat(simd, 1.0));
        let least = Four::splat(simd, LEAST_CURVATURE);
        for ((odds, (targets, shares)), (residuals, curvatures)) in fours(odds).iter().zip(given).zip(slopes) {
            let [odds, targets, shares] = Four::all(simd, &[*odds, *targets, *shares]);
            let away = odds.abs();
            let smaller = exp(simd, zero - away);
            let larger = one / (smaller + 1.0);
            let probability = odds.below(zero, smaller * larger, larger);
            *residuals = (shares * (probability - targets)).numbers();
            *curvatures = (shares * (smaller * larger * larger).max(least)).numbers();
            // log(1 + e^z) − t z as a sum of terms above 0: it has no cancellation.
            let slope = odds.below(zero, targets, one - targets);
            *losses += shares * (slope * away + log_1p(smaller));
        }
    }
}

/// Σ l_i r_i of padded vectors.
#[inline(always)]
pub(super) fn product(left: &[f64], right: &[f64]) -> f64 {
    let mut sums = [0.0; EIGHT];
    for (left, right) in left.as_chunks::<EIGHT>().0.iter().zip(right.as_chunks::<EIGHT>().0) {
        for lane in 0..EIGHT {
            sums[lane] += left[lane] * right[lane];
        }
    }
    joined(sums)
}

/// `base` + `length` × `step`.
#[inline(always)]
pub(super) fn along(base: &[f64], step: &[f64], length: f64, there: &mut [f64]) {
    for ((there, base), step) in there.iter_mut().zip(base).zip(step) {
        *there = base + length * step;
    }
}

/// The greatest component of a gradient, without its sign. NaN if a component is NaN.
pub(super) fn steepest(gradient: &[f64]) -> f64 {
    let worse = |most: f64, part: &f64| if most.is_nan() || part.abs() <= most { most } else { part.abs() };
    gradient.iter().fold(0.0, worse)
}

/// Halves a step until the objective falls as the slope promises. Returns whether some length does; it is the length
/// that `objective` was called with last.
pub(super) fn search(value: f64, slope: f64, mut objective: impl FnMut(f64) -> f64) -> bool {
    let mut length = 1.0;
    for _ in 0..HALVINGS {
        if objective(length) <= value + SUFFICIENT * length * slope + ROUNDING * value.abs() {
            return true;
        }
        length *= 0.5;
    }
    false
}

/// A fitted ridge logistic regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
