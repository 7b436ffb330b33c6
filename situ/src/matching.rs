//! What Cluster and Find-Policy find for a segment.

use crate::place::NodeId;
use crate::trace::MatchedIn;

/// Clusters of primitives, as Cluster leaves them (A2.2). The default is a segment that was compared with nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clusters {
    /// A node of the segment's own cluster: the segment is an instance of it. `None` where the segment is alone.
    pub instance_of: Option<NodeId>,
    /// Groups of two or more nodes that belong together. The segment's own cluster can be among them.
    pub groups: Vec<Vec<NodeId>>,
    /// Where the segment's own cluster was found.
    pub matched_in: MatchedIn,
    /// How many nodes were compared with the segment.
    pub compared: usize,
}

/// What Find-Policy finds (`i` of A2.4): the primitive that a segment belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Match {
    /// The primitive.
    pub node: NodeId,
    /// What the segment is to it.
    pub shows: Shows,
}

/// What a segment shows of a primitive that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// One more instance of this way of it.
    Way(usize),
    /// Another way of it (decisions D18 to D20).
    AnotherWay,
}
