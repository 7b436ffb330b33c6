//! Where a robot stopped before it was corrected.
//!
//! A model names its primitives by nodes, and a node may be gone after the next correction. A segment stays what it is.
//! So a stop is kept by segments, and this is the one place that turns the nodes of a model into segments and back.

use situ::graph::Graph;
use situ::place::{NodeId, Place, SegmentId};

/// Where a robot stopped. Each primitive is named by the first segment that its node held then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StopPoint {
    /// The primitive that ran last to its end; `None` for START.
    pub last: Option<SegmentId>,
    /// The primitive that was under way, if one was.
    pub interrupted: Option<SegmentId>,
}

/// A node that holds no segment: nothing outside its model can name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nameless(pub NodeId);

/// A segment that no node of a model holds, and which of the two primitives of a stop it names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unheld {
    /// `after` or `interrupted`, as the keys of a demonstration file.
    pub key: &'static str,
    /// The segment.
    pub segment: SegmentId,
}

impl StopPoint {
    /// The stop of a robot with this model.
    ///
    /// # Errors
    /// A node that holds no segment.
    pub fn of(model: &Graph, last: Place, interrupted: Option<NodeId>) -> Result<Self, Nameless> {
        let held = |id: NodeId| {
            let node = model.nodes.iter().find(|node| node.id == id);
            node.and_then(|node| node.segments.first().copied()).ok_or(Nameless(id))
        };
        let last = if let Place::Node(id) = last { Some(held(id)?) } else { None };
        Ok(Self { last, interrupted: interrupted.map(held).transpose()? })
    }

    /// The same stop in a model: the place that ran last and the primitive that was under way.
    ///
    /// # Errors
    /// A segment that no node of the model holds.
    pub fn in_model(&self, model: &Graph) -> Result<(Place, Option<NodeId>), Unheld> {
        let holders = model.holders();
        let [last, interrupted] =
            [("after", self.last), ("interrupted", self.interrupted)].map(|(key, segment)| match segment {
                None => Ok(None),
                Some(segment) => match holders.get(&segment) {
                    Some(node) => Ok(Some(node.id)),
                    None => Err(Unheld { key, segment }),
                },
            });
        Ok((last?.map_or(Place::Start, Place::Node), interrupted?))
    }
}

/// The ledger's name for the place that ran last: the reference object of its primitive, or `START`.
pub fn reference(model: &Graph, last: Place) -> String {
    let node = model.nodes.iter().find(|node| last == Place::Node(node.id));
    node.map_or_else(|| last.to_string(), |node| node.reference.to_string())
}

#[cfg(test)]
mod tests {
    use situ::graph::GraphNode;

    use super::*;

    fn segment(demonstration: u32, index: u32) -> SegmentId {
        SegmentId { demonstration, index }
    }

    fn model(nodes: &[(u32, &[SegmentId])]) -> Graph {
        let node = |(id, segments): &(u32, &[SegmentId])| GraphNode {
            id: NodeId(*id),
            reference: format!("object-{id}").into(),
            segments: segments.to_vec(),
            path: Vec::new(),
        };
        Graph { nodes: nodes.iter().map(node).collect(), edges: Vec::new(), lengths: Vec::new() }
    }

    #[test]
    fn a_stop_outlives_the_nodes_of_its_model() {
        let before = model(&[(0, &[segment(0, 0)]), (1, &[segment(0, 1), segment(1, 1)])]);
        let stop = StopPoint::of(&before, Place::Node(NodeId(1)), Some(NodeId(0))).unwrap();
        assert_eq!(stop, StopPoint { last: Some(segment(0, 1)), interrupted: Some(segment(0, 0)) });
        let after = model(&[(7, &[segment(0, 1)]), (8, &[segment(0, 0), segment(1, 1)])]);
        assert_eq!(stop.in_model(&after), Ok((Place::Node(NodeId(7)), Some(NodeId(8)))));
        let start = StopPoint::of(&before, Place::Start, None).unwrap();
        assert_eq!(start.in_model(&after), Ok((Place::Start, None)));
        assert_eq!(reference(&after, Place::Node(NodeId(7))), "object-7");
        assert_eq!(reference(&after, Place::Start), "START");
    }

    /// A primitive without a name, and one that is gone, used to become START unsaid.
    #[test]
    fn what_has_no_name_or_no_node_is_refused() {
        let before = model(&[(0, &[segment(0, 0)]), (1, &[])]);
        assert_eq!(StopPoint::of(&before, Place::Node(NodeId(1)), None), Err(Nameless(NodeId(1))));
        assert_eq!(StopPoint::of(&before, Place::Start, Some(NodeId(2))), Err(Nameless(NodeId(2))));
        let stop = StopPoint { last: Some(segment(3, 1)), interrupted: None };
        assert_eq!(stop.in_model(&before), Err(Unheld { key: "after", segment: segment(3, 1) }));
        let stop = StopPoint { last: None, interrupted: Some(segment(3, 2)) };
        assert_eq!(stop.in_model(&before), Err(Unheld { key: "interrupted", segment: segment(3, 2) }));
    }
}
