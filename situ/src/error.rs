//! What can go wrong in this crate, and where.

use thiserror::Error;

use crate::place::{NodeId, Place};

/// An error of the learning crate; each variant says where.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SituError {
    /// A schema that cannot be used.
    #[error("schema, feature `{feature}`: {problem}")]
    Schema {
        /// The feature, empty where the schema as a whole is meant.
        feature: String,
        /// What is wrong, and what would be right.
        problem: &'static str,
    },
    /// A demonstration without keyframes.
    #[error("demonstration `{demonstration}` has no keyframe: a demonstration needs at least one")]
    EmptyDemonstration {
        /// Its name.
        demonstration: String,
    },
    /// No demonstration where at least one is needed.
    #[error("no demonstration: a task model is taught by at least one original demonstration")]
    NoDemonstration,
    /// A state whose length is not the schema's.
    #[error("{place}: a state of {found} numbers, expected {expected} (one a feature of the schema)")]
    StateLength {
        /// Demonstration and keyframe.
        place: String,
        /// Numbers found.
        found: usize,
        /// Numbers expected.
        expected: usize,
    },
    /// NaN or infinity.
    #[error("{place}: {what} is not a finite number in its range")]
    NotFinite {
        /// Demonstration and keyframe.
        place: String,
        /// The field.
        what: String,
    },
    /// A demonstration that does not say what a method has to be told.
    #[error("demonstration `{demonstration}`: {method} {missing}")]
    Silent {
        /// Its name.
        demonstration: String,
        /// The method.
        method: String,
        /// What it needs.
        missing: &'static str,
    },
    /// A model of the original task that another kind of method has learned.
    #[error("{method} cannot take over this model of the original task: expected {expected}")]
    OtherOriginal {
        /// The method.
        method: String,
        /// The model that it takes over.
        expected: String,
    },
    /// A method that is another program, which failed or answered what is no answer.
    #[error("{method}: {problem}")]
    Outside {
        /// The method.
        method: String,
        /// What went wrong.
        problem: String,
    },
    /// A method whose models cannot be read again.
    #[error("a model of {method} cannot be read again: teach it anew")]
    Unreadable {
        /// The method.
        method: String,
    },
    /// A model that was read and cannot be one.
    #[error("{place}: {problem}")]
    Model {
        /// The part of the model, as a key of what was read.
        place: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A node that the model does not hold.
    #[error("the task model has no node {0}")]
    UnknownNode(NodeId),
    /// A place from which nothing can be executed, used as the last executed primitive.
    #[error("{0} cannot be the last executed primitive: expected START or a node")]
    NotExecutable(Place),
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
    /// A hidden Markov model could not be fitted.
    #[error("a policy on `{reference}`: {problem}")]
    Policy {
        /// The reference object of the segments.
        reference: String,
        /// What went wrong.
        problem: String,
    },
    /// A classifier could not be fitted.
    #[error("an initiation classifier: {0}")]
    Classifier(String),
    /// A state-based transition model (STARHMM) could not be made or fitted.
    #[error("a model of phases: {0}")]
    Phases(String),
}
