//! The parameters of a regression, and what can go wrong with one.

use thiserror::Error;

use crate::vector::EIGHT;

/// The dimension in which the Newton step is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The smaller of the two.
    Auto,
    /// That of the features, d: O(n d² + d³).
    Primal,
    /// That of the samples, n: O(n² d) once, then O(n³) per step.
    Dual,
}

/// The parameters of [`super::fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogisticParameters {
    /// The ridge λ on the mean loss, above 0.
    pub ridge: f64,
    /// Whether both classes have the same total weight, for any counts.
    pub balanced: bool,
    /// The number that `true` is regressed on, above 0 and below 1.
    pub positive: f64,
    /// The number that `false` is regressed on, above 0 and below 1.
    pub negative: f64,
    /// The fit stops when no component of the gradient is above this.
    pub tolerance: f64,
    /// The greatest number of Newton steps.
    pub max_iterations: usize,
    /// The dimension in which the steps are solved.
    pub path: Path,
}

impl Default for LogisticParameters {
    /// Decision D2c: λ = 0.002, classes balanced, targets 0.95 and 0.05.
    fn default() -> Self {
        Self {
            ridge: 0.002,
            balanced: true,
            positive: 0.95,
            negative: 0.05,
            tolerance: 1e-9,
            max_iterations: 50,
            path: Path::Auto,
        }
    }
}

impl LogisticParameters {
    pub(super) fn check(&self) -> Result<(), LogisticError> {
        let inside = |value: f64| value > 0.0 && value < 1.0;
        let rules = [
            ("ridge", self.ridge, self.ridge.is_finite() && self.ridge > 0.0, "must be above 0"),
            ("tolerance", self.tolerance, self.tolerance > 0.0, "must be above 0"),
            ("positive", self.positive, inside(self.positive), "must be above 0 and below 1"),
            ("negative", self.negative, inside(self.negative), "must be above 0 and below 1"),
        ];
        match rules.into_iter().find(|(_, _, holds, _)| !holds) {
            None => Ok(()),
            Some((parameter, value, _, rule)) => Err(LogisticError::Parameter { parameter, value, rule }),
        }
    }

    /// The target t_i and the share s_i of each sample, padded with zeros; the shares sum to 1.
    pub(super) fn targets_and_shares(&self, labels: &[bool]) -> (Vec<f64>, Vec<f64>) {
        let positives = labels.iter().filter(|label| **label).count();
        let negatives = labels.len() - positives;
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
        (of_each(self.positive, self.negative), of_each(positive, negative))
    }
}

/// Why a regression could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum LogisticError {
    /// There is no sample.
    #[error("no sample: a classifier is fitted to at least one")]
    NoSample,
    /// A row, a label or a start has another length.
    #[error("{what}: {found} numbers, expected {expected}")]
    Length {
        /// What has the wrong length.
        what: &'static str,
        /// The length that it has.
        found: usize,
        /// The length that it should have.
        expected: usize,
    },
    /// A number in the data is NaN or infinite.
    #[error("sample {sample}, feature {feature} is not finite")]
    NotFinite {
        /// Index of the sample.
        sample: usize,
        /// Index of the feature.
        feature: usize,
    },
    /// A parameter is out of its range.
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
