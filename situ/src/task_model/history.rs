//! Traversal histories: which primitives a demonstration went through.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::demonstration::{Demonstration, Kind};
use crate::place::{NodeId, SegmentId};
use crate::segment::Segment;
use crate::state::State;
use crate::trail::PastStep;

/// One demonstration and the primitives it traversed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// The demonstration's name.
    pub name: Arc<str>,
    /// Its origin: the segment whose node ran last before the demonstration; `None` for START.
    pub after: Option<SegmentId>,
    /// Whether it was given for the whole task or to mend a failure.
    pub kind: Kind,
    /// A segment of the primitive that was under way before the demonstration and did not run to its end, if one was.
    pub interrupted: Option<SegmentId>,
    /// The choices that led to the failure, in order; empty where nobody wrote them down.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trail: Vec<PastStep>,
    /// Its segments.
    pub segments: Vec<Arc<Segment>>,
    /// The node of each segment that has been placed so far.
    pub nodes: Vec<NodeId>,
    /// The world after it.
    pub final_state: State,
    /// Whether it leads to END.
    pub carried_to_end: bool,
}

impl History {
    /// A demonstration cut into its segments. None of them is placed yet.
    pub fn new(demonstration: &Demonstration, segments: Vec<Segment>, after: Option<SegmentId>) -> Self {
        Self {
            name: demonstration.name().clone(),
            after,
            kind: demonstration.kind(),
            interrupted: None,
            trail: Vec::new(),
            segments: segments.into_iter().map(Arc::new).collect(),
            nodes: Vec::new(),
            final_state: demonstration.final_state().clone(),
            carried_to_end: demonstration.carried_to_end(),
        }
    }

    /// The number of keyframes of each segment, in order.
    pub fn lengths(&self) -> Vec<usize> {
        self.segments.iter().map(|segment| segment.keyframes.len()).collect()
    }
}
