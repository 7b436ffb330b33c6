//! Why a model could not be fitted.

use thiserror::Error;

/// Why a model could not be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum StarhmmError {
    /// A sequence, a vector or an index does not fit the others.
    #[error("sequence {sequence}: {problem}")]
    Shape {
        /// Index of the sequence.
        sequence: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// The indices or vectors of the model do not fit together.
    #[error("the model: {0}")]
    Model(&'static str),
    /// No path of phases makes this sequence.
    #[error("sequence {sequence} is impossible under the structure")]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
    },
}
