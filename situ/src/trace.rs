//! What an update did, step by step, in exact counters (decision D17).

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::place::{NodeId, Place};

/// Exact counts of work. They depend on the input alone, never on the machine, so a difference is a verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Hidden Markov models fitted, policies and signatures alike, and the models of phases of `itmcd`.
    pub hmm_fits: u64,
    /// Iterations of expectation maximisation over all fits.
    pub em_iterations: u64,
    /// Divergences between two models.
    pub divergences: u64,
    /// Initiation classifiers fitted.
    pub classifier_fits: u64,
    /// Initiation classifiers evaluated (the scan of A1.6 and the search of D10).
    pub classifier_evaluations: u64,
    /// Nodes created, refitted or removed.
    pub nodes_touched: u64,
    /// Segments read to fit a policy or a signature.
    pub segments_touched: u64,
    /// Newton steps of the logistic regressions inside expectation maximisation. Only `itmcd` has any. The steps of an
    /// initiation classifier are part of its fit and are not counted. Left out where there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub logistic_steps: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Counters {
    /// The counters by name that mean something for every method, in the order of the tables.
    pub fn named(&self) -> [(&'static str, u64); 7] {
        [
            ("hmm_fits", self.hmm_fits),
            ("em_iterations", self.em_iterations),
            ("divergences", self.divergences),
            ("classifier_fits", self.classifier_fits),
            ("classifier_evaluations", self.classifier_evaluations),
            ("nodes_touched", self.nodes_touched),
            ("segments_touched", self.segments_touched),
        ]
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.hmm_fits += other.hmm_fits;
        self.em_iterations += other.em_iterations;
        self.divergences += other.divergences;
        self.classifier_fits += other.classifier_fits;
        self.classifier_evaluations += other.classifier_evaluations;
        self.nodes_touched += other.nodes_touched;
        self.segments_touched += other.segments_touched;
        self.logistic_steps += other.logistic_steps;
    }
}

/// Where the node that a segment matched was found (decision D10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MatchedIn {
    /// Among the candidates: the applicable primitives `Z`, unless decision D10 has others.
    Index,
    /// Among the other nodes of the segment's reference object.
    Reference,
    /// In no cluster. The segment is new, or decision D18 takes it for another way of doing a known primitive.
    #[default]
    None,
}

/// The branch of Algorithm 2 that a segment took.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Branch {
    /// Lines 5 to 13: a new primitive.
    New,
    /// Lines 14 to 21: an existing primitive.
    Existing,
    /// Decisions D18 to D20: an existing primitive of which the segment shows another way.
    Modify,
}

/// One segment's local update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The segment's reference object.
    pub reference: String,
    /// `Z`: the primitives applicable in the segment's start state, in order, by the names that they had then.
    pub applicable: Vec<NodeId>,
    /// |T|: primitives in the model before the step.
    pub model_size: usize,
    /// Primitives compared with the segment.
    pub candidates: usize,
    /// Where the match was found.
    pub matched_in: MatchedIn,
    /// The branch taken.
    pub branch: Branch,
    /// The primitive that now holds the segment.
    pub node: NodeId,
    /// The primitive (or START) that ran before it.
    pub after: Place,
    /// Whether the edge from `after` to `node` is new.
    pub edge_added: bool,
    /// Groups merged by Cluster and Local-Reconnect: old ids, and the id that replaces them.
    pub merged: Vec<(Vec<NodeId>, NodeId)>,
    /// The work of this step.
    pub counters: Counters,
}

impl Step {
    /// The step of a segment on this object, in a model of this size, before anything was done.
    pub(crate) fn new(reference: &str, model_size: usize) -> Self {
        Self {
            reference: reference.to_owned(),
            applicable: Vec::new(),
            model_size,
            candidates: 0,
            matched_in: MatchedIn::None,
            branch: Branch::New,
            node: NodeId(0),
            after: Place::Start,
            edge_added: false,
            merged: Vec::new(),
            counters: Counters::default(),
        }
    }
}

/// Where the model had to be made to do what was shown, in the very state in which it was shown (decision D22).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Obedience {
    /// Positives of a place that was chosen wrongly, and that are samples no longer.
    pub retired: u32,
    /// Segments that a later one of the same correction contradicts in a state that looks alike: the later won.
    pub aliased: u32,
    /// Segments in whose state something else is chosen all the same.
    pub disobeyed: u32,
}

/// What one update did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// One step for each segment; empty for a full retraining and for the refinement of single primitives, which have
    /// none.
    pub steps: Vec<Step>,
    /// Whether the model obeys. All 0 for a method that does not ask.
    #[serde(default)]
    pub obedience: Obedience,
    /// All the work, the steps' and what belongs to no step (END).
    pub counters: Counters,
}
