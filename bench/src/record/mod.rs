//! One line of the ledger: a run in physics, or the cost of an update of a synthetic automaton.
//!
//! Every field is a function of the protocol, the key and the code. Only the fields named `update_seconds` hold the
//! clock. [`Record::without_times`] sets those to 0, so that two ledgers can be compared byte for byte.

mod correction;
mod cost;
mod count;
mod effort;
mod key;
mod outcome;
mod rate;
mod run;

use serde::{Deserialize, Serialize};

pub use correction::{CorrectionRecord, StepSummary};
pub use cost::CostRecord;
pub use count::count;
pub use effort::TotalEffort;
pub use key::{Identity, Key, Stage};
pub use outcome::Outcome;
pub use rate::Rate;
pub use run::{Pooled, RunRecord};

/// The version of the ledger's lines.
pub const SCHEMA: u64 = 1;

/// A line of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[expect(clippy::large_enum_variant, reason = "nearly all records are runs: boxes would save no memory")]
pub enum Record {
    /// One run in physics.
    Run(RunRecord),
    /// One update of a synthetic automaton.
    Cost(CostRecord),
}

impl Record {
    /// The run, where it is one and stands alone: no stage of a sequence, whose model has seen other changes before.
    pub fn single_run(&self) -> Option<&RunRecord> {
        match self {
            Self::Run(run) if run.key.stage.is_none() => Some(run),
            _ => None,
        }
    }

    /// The name that no other record has; it gives the order of a canonical ledger.
    pub fn identity(&self) -> Identity {
        match self {
            Self::Run(run) => Identity::Run(run.key.clone()),
            Self::Cost(cost) => cost.identity(),
        }
    }

    /// The same record with its clock times set to 0. Two runs of one protocol must not differ in it.
    pub fn without_times(&self) -> Self {
        let mut record = self.clone();
        match &mut record {
            Self::Run(run) => run.corrections.iter_mut().for_each(|correction| correction.update_seconds = 0.0),
            Self::Cost(cost) => cost.update_seconds = 0.0,
        }
        record
    }
}
