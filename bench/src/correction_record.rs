//! What the ledger holds of a correction and of the update that it led to.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::trace::{Branch, Counters, MatchedIn, Obedience, Step};

use crate::tally::{Rate, TotalEffort, count, is_default, is_zero};

/// One local update of a correction, as the tables need it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepSummary {
    /// The segment's reference object.
    pub reference: String,
    /// |Z|.
    pub applicable: u32,
    /// |T| before the step.
    pub model_size: u32,
    /// Primitives compared with the segment.
    pub candidates: u32,
    /// Where the match was found.
    pub matched_in: MatchedIn,
    /// The branch of Algorithm 2.
    pub branch: Branch,
    /// Whether A1.6 alone found a primitive that holds the segment's skill, as the teacher calls it; `None` where no
    /// primitive held it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retrieved: Option<bool>,
}

impl StepSummary {
    /// The summary of a step.
    pub fn of(step: &Step, retrieved: Option<bool>) -> Self {
        Self {
            retrieved,
            reference: step.reference.clone(),
            applicable: count(step.applicable.len()),
            model_size: count(step.model_size),
            candidates: count(step.candidates),
            matched_in: step.matched_in,
            branch: step.branch,
        }
    }
}

impl CorrectionRecord {
    /// The set of edits that it made: a new node brings its own edges, so an edge addition is one between known places.
    /// Never empty: where nothing changed, it is [`Edit::None`].
    pub fn edits(&self) -> BTreeSet<Edit> {
        // Where something is shown by doing it over again, the way back is no edit of its own.
        let is_shown_again = self.nodes_added + self.nodes_modified > 0;
        let edges = self.edges_added.saturating_sub(if is_shown_again { self.edges_back } else { 0 });
        let made = [
            (Edit::NodeAddition, self.nodes_added),
            (Edit::EdgeAddition, edges),
            (Edit::NodeModification, self.nodes_modified),
        ];
        let edits: BTreeSet<Edit> = made.into_iter().filter(|(_, count)| *count > 0).map(|(edit, _)| edit).collect();
        if edits.is_empty() { BTreeSet::from([Edit::None]) } else { edits }
    }
}

/// One correction of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrectionRecord {
    /// The name of the trigger that called the teacher.
    pub failure: String,
    /// The reference object of the primitive that ran last, or `START`.
    pub last: String,
    /// The effort of its demonstration.
    pub effort: TotalEffort,
    /// Whether the demonstration shows what changed.
    pub shows_change: bool,
    /// The edit that the method made.
    pub edit_made: Edit,
    /// Nodes added.
    pub nodes_added: u32,
    /// Edges added.
    pub edges_added: u32,
    /// Those of them that lead back to what the robot had already done in the rollout that failed.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub edges_back: u32,
    /// Nodes modified.
    pub nodes_modified: u32,
    /// Nodes merged away.
    pub nodes_merged: u32,
    /// Whether the model obeys.
    #[serde(default, skip_serializing_if = "is_default")]
    pub obedience: Obedience,
    /// The local updates; none for a full retraining.
    pub steps: Vec<StepSummary>,
    /// The exact work of the update.
    pub counters: Counters,
    /// The evaluation after the correction, which decided whether another one was asked for. It ends early where the
    /// target is out of reach, so it is no success rate to publish.
    pub decided_by: Rate,
    /// Wall-clock seconds of the update: the only clock.
    pub update_seconds: f64,
}
