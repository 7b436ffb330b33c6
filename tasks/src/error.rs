//! What can go wrong with a task, and where.

use std::path::PathBuf;

use situ_sim::SimError;

/// A mistake in a task file, an unknown name, or a start that does not come out as the file declares.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TaskError {
    /// Something in a task file is wrong.
    #[error("{}:{line}: `{key}`: {expected}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The line of the mistake, counted from 1.
        line: usize,
        /// The key, as a path from the file's root: `skill[2].keyframes[0].close`.
        key: String,
        /// What was found, and what was expected.
        expected: String,
    },
    /// A file or a folder could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No task of this name is known.
    #[error("there is no task `{name}`; the known tasks are {known}")]
    UnknownTask {
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The task has no variation of this name.
    #[error("task `{task}` has no variation `{name}`; it has {known}")]
    UnknownVariation {
        /// The task.
        task: String,
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// Two files define a task of the same name.
    #[error("{}: the task `{name}` exists already; expected another name", file.display())]
    DuplicateTask {
        /// The second file.
        file: PathBuf,
        /// The name.
        name: String,
    },
    /// No random start kept the objects far enough apart.
    #[error("task {task}, seed {seed}: no free place for `{object}` in its region after {tries} draws")]
    Crowded {
        /// Task and variation.
        task: String,
        /// The seed of the episode.
        seed: u64,
        /// The object that found no place.
        object: String,
        /// How many places were tried.
        tries: usize,
    },
    /// Two things start inside each other.
    #[error(
        "task {task}, seed {seed}: `{first}` and `{second}` start {millimetres:.1} mm inside each other; expected regions that keep them apart, or `apart`"
    )]
    Overlap {
        /// Task and variation.
        task: String,
        /// The seed of the episode.
        seed: u64,
        /// One of the two; `table` and `hand` are names, too.
        first: String,
        /// The other, which was placed later.
        second: String,
        /// How deep.
        millimetres: f64,
    },
    /// After settling, the start conditions that the file declares do not hold.
    #[error("task {task}, seed {seed}: after settling, the premise `{condition}` does not hold")]
    Premise {
        /// Task and variation.
        task: String,
        /// The seed of the episode.
        seed: u64,
        /// The condition.
        condition: String,
    },
    /// The physics refused the scene.
    #[error("task {task}: {source}")]
    World {
        /// Task and variation.
        task: String,
        /// What the physics says.
        source: SimError,
    },
}
