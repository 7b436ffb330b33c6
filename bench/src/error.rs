//! The errors of the harness, each with its place.

use std::io;
use std::path::PathBuf;

use situ::error::SituError;
use situ::place::{NodeId, Place, SegmentId};
use situ_sim::SimError;
use situ_tasks::{TaskError, name};
use situ_teachers::TeacherError;
use thiserror::Error;

use crate::stop::{Nameless, Unheld};

/// An error of the harness. Each variant says where, and what would be right.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A file that was named cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file, or `standard output`.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A folder that another program writes into.
    #[error("{}: {holder} writes there: wait for it, or give another --out", folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// Who writes there.
        holder: String,
    },
    /// A line of a ledger or a baseline with a mistake.
    #[error("{}:{line}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A record that a ledger could not give back as it was.
    #[error("{}: a record was not written: {problem}", path.display())]
    Record {
        /// The ledger.
        path: PathBuf,
        /// The mistake in the record.
        problem: String,
    },
    /// Two records of one run that say different things.
    #[error("{second} and {first} are records of the same run ({run}) and differ: leave one of the ledgers out")]
    Conflict {
        /// File and line of the former record.
        first: String,
        /// File and line of the latter.
        second: String,
        /// The run.
        run: String,
    },
    /// Ledgers that differ in what made them.
    #[error(
        "{second} and {first} are of different provenance, {differing}: leave one out, or permit it with --mixed, and \
         every table says so"
    )]
    Provenance {
        /// The former ledger.
        first: String,
        /// The latter, or this program.
        second: String,
        /// What differs.
        differing: String,
    },
    /// A mistake in a demonstration file.
    #[error("{}:{line}: key `{key}`: {problem}", path.display())]
    Demonstration {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The key, such as `keyframes[2].state`; `.` is the file as a whole.
        key: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A mistake in a recording, or something that is not in it.
    #[error("{}: {place}{problem}", path.display())]
    Recording {
        /// The file or folder.
        path: PathBuf,
        /// The row and the column, with a colon after them; nothing where it is the recording as a whole.
        place: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A name that nothing has.
    #[error("no {what} is called `{name}`: expected one of {known}")]
    Unknown {
        /// The kind of thing.
        what: &'static str,
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// Arguments that do not go together.
    #[error("{0}")]
    Argument(String),
    /// A correction at a node that holds no segment. Outside the model that node has no name.
    #[error("correction `{correction}`: {node} of the model holds no segment, so its stop there cannot be written")]
    Nameless {
        /// The corrective demonstration's name.
        correction: String,
        /// The node.
        node: NodeId,
    },
    /// A correction that another model cannot place, because none of its nodes holds the segment at which the robot
    /// stopped.
    #[error(
        "correction `{correction}`: `{method}` keeps no node that holds segment {} of demonstration {} (`{key}`)",
        segment.index, segment.demonstration
    )]
    Unheld {
        /// The corrective demonstration's name.
        correction: String,
        /// The method whose model it is.
        method: String,
        /// `after` or `interrupted`: which primitive of the stop the segment names.
        key: String,
        /// The segment.
        segment: SegmentId,
    },
    /// A primitive that no hand can perform: its method made something of it that is no number, or that has no end.
    #[error("primitive {node}: {problem}")]
    Unusable {
        /// The primitive.
        node: NodeId,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// A probability that is none.
    #[error("the primitive to follow {last} has the probability {probability}: expected 0 to 1")]
    Improbable {
        /// What ran last.
        last: Place,
        /// The number.
        probability: f64,
    },
    /// A run that went on for too long.
    #[error("more than {most} steps of the physics (`budget.steps`)")]
    OutOfSteps {
        /// The budget.
        most: u64,
    },
    /// Original demonstrations that could not be learned.
    #[error("the originals from {} on: {source}", path.display())]
    Teach {
        /// The file of the first.
        path: PathBuf,
        /// The learner's error.
        source: SituError,
    },
    /// A correction that could not be learned.
    #[error("{}: {source}", path.display())]
    Learn {
        /// The demonstration's file.
        path: PathBuf,
        /// The learner's error.
        source: SituError,
    },
    /// Records or tables that are not those of the checked folder.
    #[error(
        "{} {what} differ from the checked folder, the first: {}",
        names.len(), names.first().map_or("", String::as_str)
    )]
    Differs {
        /// `records` or `tables`.
        what: &'static str,
        /// The names of those that differ.
        names: Vec<String>,
    },
    /// Instructions that could not be counted.
    #[error("valgrind: {problem}")]
    Valgrind {
        /// Its message.
        problem: String,
    },
    /// The user stopped the program.
    #[error("interrupted: every finished run is in the ledger; go on with --resume")]
    Interrupted,
    /// The user stopped the program before there was anything to write.
    #[error("interrupted: nothing was written")]
    Stopped,
    /// A picture that cannot be made.
    #[error(transparent)]
    Picture(#[from] SimError),
    /// An error of a task or its file.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// An error of a teacher or its file.
    #[error(transparent)]
    Teacher(#[from] TeacherError),
    /// An error of the learner.
    #[error(transparent)]
    Situ(#[from] SituError),
}

impl BenchError {
    /// A name that nothing has, and the names that there are.
    pub fn unknown<'a>(what: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Self::Unknown { what, name: name::shown(name), known: known.into_iter().collect::<Vec<_>>().join(", ") }
    }

    /// A correction's stop at a node that holds no segment.
    pub fn nameless(correction: &str, Nameless(node): Nameless) -> Self {
        Self::Nameless { correction: correction.to_owned(), node }
    }

    /// A correction's stop that a method's model does not hold.
    pub fn unheld(correction: &str, method: &str, Unheld { key, segment }: Unheld) -> Self {
        Self::Unheld { correction: correction.to_owned(), method: method.to_owned(), key, segment }
    }

    /// The program's exit status: 1 where the machine failed, 2 where the input was bad.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Write { .. } | Self::Record { .. } | Self::Differs { .. } | Self::Valgrind { .. } => 1,
            // 128 + SIGINT, as shells have it.
            Self::Interrupted | Self::Stopped => 130,
            _ => 2,
        }
    }
}
