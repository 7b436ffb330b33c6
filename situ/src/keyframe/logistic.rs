//! Ridge logistic regression: the initiation classifiers (decisions D2b, D2c).
//!
//! The objective is convex: Σ s_i ℓ(t_i, b + w·x_i) + ½ λ |w|², where Σ s_i = 1 (a *mean* loss, so that λ means the
//! same for any number of samples), ℓ the cross-entropy against the target t_i, and the intercept b is not penalised.
//! It is solved by Newton's method (iteratively reweighted least squares), in the features' dimension or in the
//! samples', whichever is smaller; both find the same minimum. The targets of `true` and `false` are inside (0, 1):
//! with few samples the classes can always be separated, and plain maximum likelihood would diverge.

mod blocks;
mod dual;
mod factor;
mod primal;
mod problem;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use blocks::Blocks;
use primal::Point;
use problem::Problem;

use crate::vector::EIGHT;

/// What a label is regressed on (decision D2c).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Targets {
    /// Fixed numbers, whatever the counts.
    Fixed {
        /// Target of `true`.
        positive: f64,
        /// Target of `false`.
        negative: f64,
    },
    /// Platt's: (N₊ + 1)/(N₊ + 2) and 1/(N₋ + 2). They lose confidence where there are few samples.
    Platt,
}

/// In which dimension the Newton step is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Path {
    /// The smaller of the two.
    Auto,
    /// The features' dimension d: O(n d² + d³).
    Primal,
    /// The samples' dimension n: O(n² d) once, then O(n³) a step.
    Dual,
}

/// What [`fit`] depends on beside the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogisticParameters {
    /// Ridge λ on the mean loss, above 0.
    pub ridge: f64,
    /// Whether both classes weigh the same in total, whatever their counts.
    pub balanced: bool,
    /// What the labels are regressed on.
    pub targets: Targets,
    /// Stop where no component of the gradient is above this.
    pub tolerance: f64,
    /// Newton steps at most.
    pub max_iterations: usize,
    /// In which dimension the steps are solved.
    pub path: Path,
}

impl Default for LogisticParameters {
    /// Decision D2c: λ = 0.002, classes balanced, targets 0.95 and 0.05.
    fn default() -> Self {
        Self {
            ridge: 0.002,
            balanced: true,
            targets: Targets::Fixed { positive: 0.95, negative: 0.05 },
            tolerance: 1e-9,
            max_iterations: 50,
            path: Path::Auto,
        }
    }
}

/// Why a regression could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LogisticError {
    /// Nothing to fit to.
    #[error("no sample: a classifier is fitted to at least one")]
    NoSample,
    /// A row, a label or a start of another length.
    #[error("{what}: {found} numbers, expected {expected}")]
    Length {
        /// What has the wrong length.
        what: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// NaN or infinity in the data.
    #[error("sample {sample}, feature {feature} is not finite")]
    NotFinite {
        /// Index of the sample.
        sample: usize,
        /// Index of the feature.
        feature: usize,
    },
    /// A parameter out of its range.
    #[error("parameter `{parameter}` is {value}: {rule}")]
    Parameter {
        /// The parameter's name.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },
    /// The numbers are so large that a Newton step could not be solved.
    #[error("the Newton step could not be solved: the features are too large")]
    Singular,
}

/// A fitted regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogisticFit {
    /// Weight of each feature, shape (d).
    pub weights: Vec<f64>,
    /// The intercept.
    pub intercept: f64,
    /// Newton steps made.
    pub iterations: usize,
    /// Whether the gradient came under the tolerance before the steps ran out.
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

/// Fits a ridge logistic regression.
///
/// `rows`: n rows of d features, already lifted and scaled; `labels`: n. `warm` is a former fit to start from: the
/// minimum is the same, but for the tolerance. Sums are in the order of the rows: the same input gives the same bits.
///
/// # Errors
/// Where there is no row, lengths differ, a number is not finite or a parameter is out of its range.
pub fn fit(
    rows: &[&[f64]],
    labels: &[bool],
    parameters: &LogisticParameters,
    warm: Option<&LogisticFit>,
) -> Result<LogisticFit, LogisticError> {
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
    let mut start = LogisticFit { weights: vec![0.0; dimension], intercept: 0.0, iterations: 0, converged: false };
    if let Some(warm) = warm {
        same("the start's weights", warm.weights.len(), dimension)?;
        if warm.weights.iter().chain([&warm.intercept]).all(|value| value.is_finite()) {
            start.weights.copy_from_slice(&warm.weights);
            start.intercept = warm.intercept;
        }
    }
    let (targets, shares) = parameters.targets_and_shares(labels);
    let problem = Problem { rows, dimension, targets: &targets, shares: &shares, ridge: parameters.ridge };
    let dual = match parameters.path {
        Path::Auto => rows.len() < dimension,
        Path::Primal => false,
        Path::Dual => true,
    };
    if dual { dual::minimise(&problem, start, parameters) } else { primal::minimise(&problem, start, parameters) }
}

/// The objective that [`fit`] minimises, and its gradient: the weights' components, then the intercept's.
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

impl LogisticParameters {
    fn check(&self) -> Result<(), LogisticError> {
        let inside = |value: f64| value > 0.0 && value < 1.0;
        let mut rules = vec![
            ("ridge", self.ridge, self.ridge.is_finite() && self.ridge > 0.0, "must be above 0"),
            ("tolerance", self.tolerance, self.tolerance > 0.0, "must be above 0"),
        ];
        if let Targets::Fixed { positive, negative } = self.targets {
            rules.push(("targets.positive", positive, inside(positive), "must be above 0 and below 1"));
            rules.push(("targets.negative", negative, inside(negative), "must be above 0 and below 1"));
        }
        match rules.into_iter().find(|(_, _, holds, _)| !holds) {
            None => Ok(()),
            Some((parameter, value, _, rule)) => Err(LogisticError::Parameter { parameter, value, rule }),
        }
    }

    /// Target t_i and share s_i of each sample, padded with zeros; the shares sum to 1.
    fn targets_and_shares(&self, labels: &[bool]) -> (Vec<f64>, Vec<f64>) {
        let positives = labels.iter().filter(|label| **label).count();
        let negatives = labels.len() - positives;
        let (high, low) = match self.targets {
            Targets::Fixed { positive, negative } => (positive, negative),
            Targets::Platt => ((positives as f64 + 1.0) / (positives as f64 + 2.0), 1.0 / (negatives as f64 + 2.0)),
        };
        let share = |own: usize, other: usize| {
            if self.balanced && other > 0 { 0.5 / own as f64 } else { 1.0 / labels.len() as f64 }
        };
        let (positive, negative) = (share(positives, negatives), share(negatives, positives));
        let of_each = |positive, negative| {
            let mut numbers = vec![0.0; labels.len().next_multiple_of(EIGHT)];
            numbers
                .iter_mut()
                .zip(labels)
                .for_each(|(number, label)| *number = if *label { positive } else { negative });
            numbers
        };
        (of_each(high, low), of_each(positive, negative))
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

/// Σ l_i r_i: four running sums, joined in a fixed order: the same bits on every machine, and open to vector
/// instructions.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (left_lanes, right_lanes) = (left.chunks_exact(4), right.chunks_exact(4));
    let rest: f64 = left_lanes.remainder().iter().zip(right_lanes.remainder()).map(|(l, r)| l * r).sum();
    for (left, right) in left_lanes.zip(right_lanes) {
        for lane in 0..4 {
            lanes[lane] += left[lane] * right[lane];
        }
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}
