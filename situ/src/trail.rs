//! The trail of a rollout that failed: in which states the robot began which primitive, up to the failure (decision
//! D23). A robot that logs what it does has one; the listing knows the primitive that ran last alone.

use serde::{Deserialize, Serialize};

use crate::place::{NodeId, SegmentId};
use crate::state::State;

/// How a primitive that was chosen ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepEnd {
    /// It ran to its end.
    Finished,
    /// It was begun, and aborted or stopped under way.
    Interrupted,
    /// It was chosen, and stopped before it began.
    Prevented,
}

/// One choice of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct TrailStep {
    /// The world in which the primitive was chosen.
    pub state: State,
    /// The primitive.
    pub node: NodeId,
    /// How it ended.
    pub end: StepEnd,
}

/// The same as a model writes it down. Nodes merge and get other names; a segment stays with the primitive that holds
/// it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PastStep {
    /// The world in which the primitive was chosen.
    pub state: State,
    /// A segment of the primitive.
    pub of: SegmentId,
    /// How it ended.
    pub end: StepEnd,
}
