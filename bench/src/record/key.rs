//! The names of runs and of records.

use std::fmt;

use serde::{Deserialize, Serialize};
use situ::edit::Edit;

/// Names a run: the cell (task × edit × method × teacher) and the seed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// The protocol.
    pub protocol: String,
    /// The task.
    pub task: String,
    /// How the task was changed.
    pub variation: String,
    /// The edit that the variation needs.
    pub edit: Edit,
    /// The teacher's profile.
    pub teacher: String,
    /// The method.
    pub method: String,
    /// The seed of the run.
    pub seed: u64,
    /// The stage, where the run is one of a sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<Stage>,
}

/// A stage of a sequence of variations. Each is met with the model that the one before left.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// The sequence.
    pub sequence: String,
    /// The place in it, from 1.
    pub number: u32,
}

/// Names a record among all records: no two records of a ledger share it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Identity {
    /// A run in physics.
    Run(Key),
    /// An update of a synthetic automaton.
    Cost {
        /// The protocol.
        protocol: String,
        /// The series of the protocol.
        series: String,
        /// The method.
        method: String,
        /// The edit that was planted.
        edit: Edit,
        /// Nodes of the automaton.
        nodes: u32,
        /// Its original demonstrations.
        originals: u32,
        /// The seed of the automaton.
        seed: u64,
        /// The number of the correction.
        correction: u32,
    },
}

impl fmt::Display for Identity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Run(Key { protocol, task, variation, teacher, method, seed, stage, edit: _ }) => {
                write!(formatter, "{protocol}, {task}/{variation}")?;
                if let Some(Stage { sequence, number }) = stage {
                    write!(formatter, " (stage {number} of {sequence})")?;
                }
                write!(formatter, ", {teacher}, {method}, seed {seed}")
            }
            Self::Cost { protocol, series, method, edit, nodes, originals, seed, correction } => {
                write!(
                    formatter,
                    "{protocol}, {series}, cost of {edit} at {nodes} nodes and {originals} originals, {method}, \
                     seed {seed}"
                )?;
                if *correction > 0 { write!(formatter, ", correction {correction}") } else { Ok(()) }
            }
        }
    }
}
