//! One update of a synthetic automaton.

use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::trace::Counters;

use super::key::Identity;

/// One update of a synthetic automaton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostRecord {
    /// The protocol.
    pub protocol: String,
    /// The series of the protocol.
    pub series: String,
    /// The method.
    pub method: String,
    /// Nodes of the automaton before the update.
    pub nodes: u32,
    /// Original demonstrations that taught it.
    pub originals: u32,
    /// The edit that was planted.
    pub edit: Edit,
    /// The seed of the automaton. Together with the number of the correction it is the seed of the correction.
    pub seed: u64,
    /// The number of the correction among those of the same edit; left out where it is 0, the first.
    #[serde(default, skip_serializing_if = "is_first")]
    pub correction: u32,
    /// |Z| at each step.
    pub applicable: Vec<u32>,
    /// |T| at each step.
    pub model_size: Vec<u32>,
    /// The exact work of the update.
    pub counters: Counters,
    /// The edit that the method made.
    pub edit_made: Edit,
    /// Wall-clock seconds of the update: the only clock.
    pub update_seconds: f64,
}

impl CostRecord {
    /// The name that no other record has.
    pub fn identity(&self) -> Identity {
        Identity::Cost {
            protocol: self.protocol.clone(),
            series: self.series.clone(),
            method: self.method.clone(),
            edit: self.edit,
            nodes: self.nodes,
            originals: self.originals,
            seed: self.seed,
            correction: self.correction,
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_first(correction: &u32) -> bool {
    *correction == 0
}
