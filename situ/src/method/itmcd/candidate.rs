//! The edits that are weighed against each other.

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
    /// The structure, and what every node does, stay.
    Nothing,
    /// A transition between places that none joined.
    Edge {
        /// Where it begins.
        from: Place,
        /// Where it leads.
        to: Place,
    },
    /// A node in between.
    Node {
        /// What runs before it.
        from: Place,
        /// Its id.
        new: NodeId,
        /// What can run after it.
        to: Place,
        /// The segment of the correction that it is made of.
        segment: usize,
    },
    /// Another policy for a node.
    Modify {
        /// The node.
        node: NodeId,
        /// The segment of the correction that replaces its policy.
        segment: usize,
    },
}

impl Candidate {
    /// Its type.
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

/// All candidates for a correction that fails at `segment`, after `at`; `last` is what ran before the correction.
/// `contexts`: of its segments. `order`: what can come after a new node, the most plausible first, for it decides where
/// the data say nothing.
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
        // Without a segment of its object there is nothing to fit a policy to.
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

/// The automaton after an edit, its new parts fitted to the segment that showed them, the rest as it was: the warm
/// start.
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
                // Another way of doing what ran last is shown by doing it once more.
                edited.add_edge(last, last);
            }
        }
    }
    Ok(edited)
}
