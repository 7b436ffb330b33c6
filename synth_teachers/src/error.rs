//! What can go wrong with teachers, and where.

use std::path::PathBuf;

use thiserror::Error;

/// An error of this crate; each variant says where.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TeacherError {
    /// A profile of this name is not known.
    #[error("unknown teacher `{name}`: known are {known}")]
    UnknownProfile {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A profile file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A mistake in a profile file.
    #[error("{}:{line}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A profile file that is no TOML, or of another kind.
    #[error(transparent)]
    Document(#[from] situ_tasks::TaskError),
    /// A file with a profile whose name is taken.
    #[error("{}: there is a teacher `{name}` already: expected another name", path.display())]
    DuplicateProfile {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A demonstration that the learner's types refuse.
    #[error(transparent)]
    Situ(#[from] situ::error::SituError),
    /// A reference object that is not in the world.
    #[error("skill `{skill}`: its reference object `{reference}` is not in the world")]
    NoReference {
        /// The skill.
        skill: String,
        /// The object.
        reference: String,
    },
}
