//! Ridge logistic regression: the initiation classifiers (decisions D2b, D2c).
//!
//! The objective is convex: Σ s_i ℓ(t_i, b + w·x_i) + ½ λ |w|². The shares s_i sum to 1, so the loss is a *mean*, and λ
//! means the same for any number of samples. ℓ is the cross-entropy against the target t_i. The intercept b is not
//! penalised. Newton's method (iteratively reweighted least squares) finds the minimum, in the dimension of the
//! features or in that of the samples, whichever is smaller; both find the same. The targets of `true` and `false` are
//! inside (0, 1): with few samples the classes can always be separated, and plain maximum likelihood would diverge.

mod blocks;
mod dual;
mod factor;
mod parameters;
mod primal;
mod problem;

pub use parameters::{LogisticError, LogisticParameters, Path};
pub use problem::LogisticFit;

use blocks::Blocks;
use primal::Point;
use problem::Problem;

/// Fits a ridge logistic regression.
///
/// `rows`: n rows of d features, already lifted and scaled. `labels`: n. Sums are in the order of the rows, so the same
/// input gives the same bits.
///
/// # Errors
/// If there is no row, lengths differ, a number is not finite or a parameter is out of its range.
pub fn fit(rows: &[&[f64]], labels: &[bool], parameters: &LogisticParameters) -> Result<LogisticFit, LogisticError> {
    parameters.check()?;
    let dimension = rows.first().ok_or(LogisticError::NoSample)?.len();
    let same = |what, found, expected| {
        if found == expected { Ok(()) } else { Err(LogisticError::Length { what, found, expected }) }
    };
    same("labels", labels.len(), rows.len())?;
    for (sample, row) in rows.iter().enumerate() {
        same("a row", row.len(), dimension)?;
        if !row.iter().fold(true, |finite, value| finite & value.is_finite()) {
            let feature = row.iter().position(|value| !value.is_finite()).unwrap_or_default();
            return Err(LogisticError::NotFinite { sample, feature });
        }
    }
    let start = LogisticFit { weights: vec![0.0; dimension], intercept: 0.0, iterations: 0, converged: false };
    let (targets, shares) = parameters.targets_and_shares(labels);
    let problem = Problem { rows, dimension, targets: &targets, shares: &shares, ridge: parameters.ridge };
    let dual = match parameters.path {
        Path::Auto => rows.len() < dimension,
        Path::Primal => false,
        Path::Dual => true,
    };
    if dual { dual::minimise(&problem, start, parameters) } else { primal::minimise(&problem, start, parameters) }
}

/// The objective that [`fit`] minimises, and its gradient: the components of the weights, then that of the intercept.
pub fn objective(
    rows: &[&[f64]],
    labels: &[bool],
    parameters: &LogisticParameters,
    weights: &[f64],
    intercept: f64,
) -> (f64, Vec<f64>) {
    let (targets, shares) = parameters.targets_and_shares(labels);
    let dimension = weights.len();
    let problem = Problem { rows, dimension, targets: &targets, shares: &shares, ridge: parameters.ridge };
    Point::at(&problem, &Blocks::panels(rows, dimension), weights, intercept).value_and_gradient(&problem)
}
