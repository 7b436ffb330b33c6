//! Where a robot stopped before it was corrected.
//!
//! A model names its primitives by nodes, and a node may be gone after the next correction. A segment stays what it is.
//! So a stop is kept by segments, and this is the one place that turns the nodes of a model into segments and back.

use situ::correction::Correction;
use situ::demonstration::Demonstration;
use situ::graph::Graph;
use situ::place::{NodeId, Place, SegmentId};
use situ::trail::{PastStep, TrailStep};

/// Where a robot stopped, and how it came there, in the places of its model.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The primitive that ran last to its end; START where none did.
    pub last: Place,
    /// The primitive that was under way, if one was.
    pub interrupted: Option<NodeId>,
    /// What it had chosen, in order; empty where nobody knows.
    pub trail: Vec<TrailStep>,
}

impl Stop {
    /// A correction from here, without an oracle.
    pub fn correction<'a>(&'a self, demonstration: &'a Demonstration) -> Correction<'a> {
        Correction { interrupted: self.interrupted, trail: &self.trail, ..Correction::after(self.last, demonstration) }
    }
}

/// Where a robot stopped. Each primitive is named by the first segment that its node held then.
#[derive(Clone, Debug, PartialEq)]
pub struct StopPoint {
    /// The primitive that ran last to its end; `None` for START.
    pub last: Option<SegmentId>,
    /// The primitive that was under way, if one was.
    pub interrupted: Option<SegmentId>,
    /// What it had chosen, in order; empty where nobody knows.
    pub trail: Vec<PastStep>,
}

/// A node that holds no segment: nothing outside its model can name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nameless(pub NodeId);

/// A segment that no node of a model holds, and which primitive of a stop it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unheld {
    /// `after`, `interrupted` or `trail[0].primitive`, as the keys of a demonstration file.
    pub key: String,
    /// The segment.
    pub segment: SegmentId,
}

impl StopPoint {
    /// The stop of a robot with this model.
    ///
    /// # Errors
    /// A node that holds no segment.
    pub fn of(model: &Graph, stop: &Stop) -> Result<Self, Nameless> {
        let held = |id: NodeId| {
            let node = model.nodes.iter().find(|node| node.id == id);
            node.and_then(|node| node.segments.first().copied()).ok_or(Nameless(id))
        };
        let last = if let Place::Node(id) = stop.last { Some(held(id)?) } else { None };
        let step = |step: &TrailStep| Ok(PastStep { state: step.state.clone(), of: held(step.node)?, end: step.end });
        let trail = stop.trail.iter().map(step).collect::<Result<_, Nameless>>()?;
        Ok(Self { last, interrupted: stop.interrupted.map(held).transpose()?, trail })
    }

    /// The same stop in a model.
    ///
    /// # Errors
    /// A segment that no node of the model holds.
    pub fn in_model(&self, model: &Graph) -> Result<Stop, Unheld> {
        let holders = model.holders();
        let node = |key: &str, segment: SegmentId| match holders.get(&segment) {
            Some(node) => Ok(node.id),
            None => Err(Unheld { key: key.to_owned(), segment }),
        };
        let last = self.last.map(|segment| node("after", segment)).transpose()?;
        let interrupted = self.interrupted.map(|segment| node("interrupted", segment)).transpose()?;
        let step = |(index, step): (usize, &PastStep)| {
            let node = node(&format!("trail[{index}].primitive"), step.of)?;
            Ok(TrailStep { state: step.state.clone(), node, end: step.end })
        };
        let trail = self.trail.iter().enumerate().map(step).collect::<Result<_, Unheld>>()?;
        Ok(Stop { last: last.map_or(Place::Start, Place::Node), interrupted, trail })
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
    use situ::state::State;
    use situ::trail::StepEnd;

    use super::*;

    fn segment(demonstration: u32, index: u32) -> SegmentId {
        SegmentId { demonstration, index }
    }

    fn model(nodes: &[(u32, &[SegmentId])]) -> Graph {
        let node = |(id, segments): &(u32, &[SegmentId])| GraphNode {
            id: NodeId(*id),
            reference: format!("object-{id}").into(),
            segments: segments.to_vec(),
            paths: Vec::new(),
        };
        Graph { nodes: nodes.iter().map(node).collect(), edges: Vec::new(), lengths: Vec::new() }
    }

    fn stop(last: Place, interrupted: Option<u32>, trail: &[u32]) -> Stop {
        let step = |id: &u32| TrailStep { state: State::new([0.5]), node: NodeId(*id), end: StepEnd::Finished };
        Stop { last, interrupted: interrupted.map(NodeId), trail: trail.iter().map(step).collect() }
    }

    #[test]
    fn a_stop_outlives_the_nodes_of_its_model() {
        let before = model(&[(0, &[segment(0, 0)]), (1, &[segment(0, 1), segment(1, 1)])]);
        let point = StopPoint::of(&before, &stop(Place::Node(NodeId(1)), Some(0), &[1, 0])).unwrap();
        assert_eq!((point.last, point.interrupted), (Some(segment(0, 1)), Some(segment(0, 0))));
        let after = model(&[(7, &[segment(0, 1)]), (8, &[segment(0, 0), segment(1, 1)])]);
        assert_eq!(point.in_model(&after), Ok(stop(Place::Node(NodeId(7)), Some(8), &[7, 8])));
        let start = StopPoint::of(&before, &stop(Place::Start, None, &[])).unwrap();
        assert_eq!(start.in_model(&after), Ok(stop(Place::Start, None, &[])));
        assert_eq!(reference(&after, Place::Node(NodeId(7))), "object-7");
        assert_eq!(reference(&after, Place::Start), "START");
    }

    /// A primitive without a name, and one that is gone, used to become START unsaid.
    #[test]
    fn what_has_no_name_or_no_node_is_refused() {
        let before = model(&[(0, &[segment(0, 0)]), (1, &[])]);
        let nameless = |of: &Stop| StopPoint::of(&before, of).unwrap_err();
        assert_eq!(nameless(&stop(Place::Node(NodeId(1)), None, &[])), Nameless(NodeId(1)));
        assert_eq!(nameless(&stop(Place::Start, Some(2), &[])), Nameless(NodeId(2)));
        assert_eq!(nameless(&stop(Place::Start, None, &[0, 1])), Nameless(NodeId(1)));
        let known = PastStep { state: State::new([0.5]), of: segment(0, 0), end: StepEnd::Prevented };
        let gone = PastStep { of: segment(3, 3), ..known.clone() };
        let none = StopPoint { last: None, interrupted: None, trail: Vec::new() };
        let unheld = |point: StopPoint| point.in_model(&before).unwrap_err();
        let key = |key: &str, segment| Unheld { key: key.to_owned(), segment };
        let last = StopPoint { last: Some(segment(3, 1)), ..none.clone() };
        assert_eq!(unheld(last), key("after", segment(3, 1)));
        let interrupted = StopPoint { interrupted: Some(segment(3, 2)), ..none.clone() };
        assert_eq!(unheld(interrupted), key("interrupted", segment(3, 2)));
        assert_eq!(unheld(StopPoint { trail: vec![known, gone], ..none }), key("trail[1].primitive", segment(3, 3)));
    }
}
