//! One correction of a run.

use serde::{Deserialize, Serialize};
use situ::edit::{Difference, Edit};
use situ::trace::{Branch, Counters, MatchedIn, Step, Trace};

use super::count::count;
use super::effort::TotalEffort;
use super::rate::Rate;

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
}

impl From<&Step> for StepSummary {
    fn from(step: &Step) -> Self {
        Self {
            reference: step.reference.clone(),
            applicable: count(step.applicable),
            model_size: count(step.model_size),
            candidates: count(step.candidates),
            matched_in: step.matched_in,
            branch: step.branch,
        }
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
    /// The edit that the method made.
    pub edit_made: Edit,
    /// Nodes added.
    pub nodes_added: u32,
    /// Edges added.
    pub edges_added: u32,
    /// Nodes modified.
    pub nodes_modified: u32,
    /// Nodes merged away.
    pub nodes_merged: u32,
    /// The local updates; none for a full retraining.
    pub steps: Vec<StepSummary>,
    /// The exact work of the update.
    pub counters: Counters,
    /// Success on the changed task after the correction, where it was evaluated.
    pub after: Option<Rate>,
    /// Wall-clock seconds of the update: the only clock.
    pub update_seconds: f64,
}

impl CorrectionRecord {
    /// A correction that is not evaluated yet, from the learner's trace and the difference of the two models.
    pub fn new(
        failure: String,
        last: String,
        effort: TotalEffort,
        difference: &Difference,
        trace: &Trace,
        update_seconds: f64,
    ) -> Self {
        Self {
            failure,
            last,
            effort,
            edit_made: difference.edit(),
            nodes_added: count(difference.nodes_added.len()),
            edges_added: count(difference.edges_added.len()),
            nodes_modified: count(difference.nodes_modified.len()),
            nodes_merged: count(difference.nodes_merged),
            steps: trace.steps.iter().map(StepSummary::from).collect(),
            counters: trace.counters,
            after: None,
            update_seconds,
        }
    }
}
