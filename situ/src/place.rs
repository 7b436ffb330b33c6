//! The names of things in a task model: nodes, places, segments and samples.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

/// Names a node. Ids are never used again, so a new id is a new node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct NodeId(pub u32);

impl fmt::Display for NodeId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "z{}", self.0)
    }
}

/// A place in the automaton: a node, or one of the two virtual ends (decision D11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// Before anything has run.
    Start,
    /// A primitive.
    Node(NodeId),
    /// The task is over.
    End,
}

impl Place {
    /// The node, if the place is one.
    pub fn node(self) -> Option<NodeId> {
        if let Self::Node(id) = self { Some(id) } else { None }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start => formatter.write_str("START"),
            Self::Node(id) => id.fmt(formatter),
            Self::End => formatter.write_str("END"),
        }
    }
}

/// Names a segment: the demonstration's index in the model, the segment's index in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SegmentId {
    /// Index of the demonstration, in the order in which the model saw them.
    pub demonstration: u32,
    /// Index of the segment in its demonstration.
    pub index: u32,
}

/// Names a state sample of a classifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleId {
    /// The start state of a segment.
    Start(SegmentId),
    /// The final state of a demonstration that was carried on to the end.
    Final(u32),
    /// The state in which a primitive was chosen on the trail that led to a correction (decision D23).
    Chosen {
        /// Index of the correction, among the demonstrations.
        demonstration: u32,
        /// Index of the choice on its trail.
        index: u32,
    },
}

impl SampleId {
    /// Index of the demonstration, or of the correction with the trail, that it is of.
    pub const fn demonstration(self) -> u32 {
        match self {
            Self::Start(SegmentId { demonstration, .. })
            | Self::Final(demonstration)
            | Self::Chosen { demonstration, .. } => demonstration,
        }
    }
}

/// The state samples that a classifier is fitted to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Samples {
    /// Where the primitive began (at END: where a task was over).
    pub positives: BTreeSet<SampleId>,
    /// Where something else began.
    pub negatives: BTreeSet<SampleId>,
}
