//! The candidates: the edits that are compared.

use std::fmt;

use serde::{Serialize, Serializer};

use super::automaton::{Automaton, emission};
use super::parameters::ItmcdParameters;
use super::starhmm::StarhmmStep;
use crate::edit::Edit;
use crate::error::SituError;
use crate::place::{NodeId, Place};

/// An edit of the automaton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Candidate {
    /// The structure stays, and so does what every node does.
    Nothing,
    /// A transition between two places without an edge.
    Edge {
        /// Its first place.
        from: Place,
        /// Its second place.
        to: Place,
    },
    /// A new node between two places.
    Node {
        /// The place before it.
        from: Place,
        /// Its id.
        new: NodeId,
        /// The place after it.
        to: Place,
        /// The index of the segment of the correction that it is made of.
        segment: usize,
    },
    /// Another policy for a node.
    Modify {
        /// The node.
        node: NodeId,
        /// The index of the segment of the correction that replaces its policy.
        segment: usize,
    },
}

impl Candidate {
    /// The type of the edit.
    pub fn edit(&self) -> Edit {
        match self {
            Self::Nothing => Edit::None,
            Self::Edge { .. } => Edit::EdgeAddition,
            Self::Node { .. } => Edit::NodeAddition,
            Self::Modify { .. } => Edit::NodeModification,
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => formatter.write_str("none"),
            Self::Edge { from, to } => write!(formatter, "edge({from} -> {to})"),
            Self::Node { from, new, to, segment } => {
                write!(formatter, "node({from} -> {new} -> {to}) by segment {segment}")
            }
            Self::Modify { node, segment } => write!(formatter, "modify({node}) by segment {segment}"),
        }
    }
}

impl Serialize for Candidate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// All candidates for a correction that fails at `segment`, after `at`. `contexts` has one context per segment. `order`
/// lists what can come after a new node, the most plausible first; it decides if the data do not.
pub(super) fn all(
    automaton: &Automaton,
    contexts: &[usize],
    (at, segment): (Place, usize),
    new: NodeId,
    order: &[Place],
) -> Vec<Candidate> {
    let nodes: Vec<Place> = automaton.versions.keys().map(|id| Place::Node(*id)).collect();
    let mut candidates = vec![Candidate::Nothing];
    for (id, phases) in &automaton.versions {
        let context = phases.last().map(|phase| automaton.model.phases[*phase].context);
        // Without a segment of the node's object there is nothing to fit a policy to.
        let shown = (0..contexts.len()).filter(|index| Some(contexts[*index]) == context);
        candidates.extend(shown.map(|segment| Candidate::Modify { node: *id, segment }));
    }
    for from in [Place::Start].iter().chain(&nodes) {
        for to in nodes.iter().chain([&Place::End]) {
            if !automaton.edges.contains(&(*from, *to)) {
                candidates.push(Candidate::Edge { from: *from, to: *to });
            }
        }
    }
    candidates.extend(order.iter().map(|to| Candidate::Node { from: at, new, to: *to, segment }));
    candidates
}

/// The automaton after an edit: the warm start of the fit. Its new parts are fitted to the segment that showed them,
/// and the rest is unchanged. `last` is what ran before the correction.
pub(super) fn apply(
    automaton: &Automaton,
    candidate: Candidate,
    last: Place,
    sequence: usize,
    shown: &[Vec<StarhmmStep>],
    parameters: &ItmcdParameters,
) -> Result<Automaton, SituError> {
    let mut edited = automaton.clone();
    let fitted = |segment: usize| emission(&shown[segment].iter().collect::<Vec<_>>(), parameters);
    match candidate {
        Candidate::Nothing => {}
        Candidate::Edge { from, to } => edited.add_edge(from, to),
        Candidate::Node { from, new, to, segment } => {
            edited.add_node(new, shown[segment][0].context, fitted(segment)?);
            edited.add_edge(from, Place::Node(new));
            edited.add_edge(Place::Node(new), to);
        }
        Candidate::Modify { node, segment } => {
            edited.add_version(node, fitted(segment)?, sequence);
            if last == Place::Node(node) {
                // To show another way of doing what ran last, the teacher does it once more.
                edited.add_edge(last, last);
            }
        }
    }
    Ok(edited)
}
