//! The three edit types (Gutierrez et al. 2018), and which of them two task models differ by.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::demonstration::Pose;
use crate::graph::{Graph, GraphNode};
use crate::keyframe::frechet::frechet;
use crate::place::{NodeId, Place};

/// An edit of the automaton.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edit {
    /// A new skill.
    NodeAddition,
    /// A new transition between skills.
    EdgeAddition,
    /// A skill refined.
    NodeModification,
    /// The structure, and what every primitive does, stay.
    None,
}

impl Edit {
    /// All four, in the order of the tables.
    pub const ALL: [Self; 4] = [Self::NodeAddition, Self::EdgeAddition, Self::NodeModification, Self::None];

    /// The name in files and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NodeAddition => "node-addition",
            Self::EdgeAddition => "edge-addition",
            Self::NodeModification => "node-modification",
            Self::None => "none",
        }
    }
}

impl fmt::Display for Edit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// A primitive counts as modified where its execution moved by more than this somewhere, metres: more than what one
/// spurious keyframe among four demonstrations moves a mean, less than the 8 cm of a near-variant.
pub const MODIFIED_METRES: f64 = 0.06;

/// What one model has that the other had not.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Difference {
    /// Nodes that hold no segment which the former model knew.
    pub nodes_added: Vec<NodeId>,
    /// Edges between places which the former model had, but had not joined.
    pub edges_added: Vec<(Place, Place)>,
    /// Nodes whose policy moved by more than [`MODIFIED_METRES`].
    pub nodes_modified: Vec<NodeId>,
    /// Nodes of the former model that are now one with another.
    pub nodes_merged: usize,
}

impl Difference {
    /// The edit as one word. A new node brings its edges, and a modification may bring an edge. So additions of nodes
    /// come first, then modifications, then additions of edges.
    pub fn edit(&self) -> Edit {
        if !self.nodes_added.is_empty() {
            Edit::NodeAddition
        } else if !self.nodes_modified.is_empty() {
            Edit::NodeModification
        } else if !self.edges_added.is_empty() {
            Edit::EdgeAddition
        } else {
            Edit::None
        }
    }
}

/// The difference from `before` to `after`, which has seen the same demonstrations in the same order, and perhaps more.
///
/// Nodes are matched by the segments they hold, not by their ids, so models of different methods can be compared.
/// The cost grows with the size of the models: it is a measurement, not part of an update.
pub fn difference(before: &Graph, after: &Graph) -> Difference {
    let (held_before, held_after) = (before.holders(), after.holders());
    // Where each place of `before` went: the nodes of `after` that hold its segments.
    let mut image: BTreeMap<Place, BTreeSet<Place>> =
        [Place::Start, Place::End].into_iter().map(|place| (place, BTreeSet::from([place]))).collect();
    for node in &before.nodes {
        let places =
            node.segments.iter().filter_map(|segment| held_after.get(segment)).map(|node| Place::Node(node.id));
        image.insert(Place::Node(node.id), places.collect());
    }
    let nowhere = BTreeSet::new();
    let mut known_edges = BTreeSet::new();
    for (from, to) in &before.edges {
        for from in image.get(from).unwrap_or(&nowhere) {
            known_edges.extend(image.get(to).unwrap_or(&nowhere).iter().map(|to| (*from, *to)));
        }
    }
    let mut difference = Difference::default();
    for node in &after.nodes {
        let mut ancestors: Vec<&GraphNode> =
            node.segments.iter().filter_map(|id| held_before.get(id).copied()).collect();
        ancestors.sort_by_key(|ancestor| ancestor.id);
        ancestors.dedup_by_key(|ancestor| ancestor.id);
        if ancestors.is_empty() {
            difference.nodes_added.push(node.id);
            continue;
        }
        difference.nodes_merged += ancestors.len() - 1;
        // A merge pools what was near; so the nearest of all ways that were counts.
        let known = || ancestors.iter().flat_map(|ancestor| &ancestor.paths);
        let is_new = |path: &[Pose]| known().all(|known| frechet(known, path) > MODIFIED_METRES);
        if node.paths.len() > known().count() || node.paths.iter().any(|path| is_new(path)) {
            difference.nodes_modified.push(node.id);
        }
    }
    let is_known = |place: &Place| !matches!(place, Place::Node(id) if difference.nodes_added.contains(id));
    let is_added = |edge: &&(Place, Place)| !known_edges.contains(*edge) && is_known(&edge.0) && is_known(&edge.1);
    difference.edges_added = after.edges.iter().filter(is_added).copied().collect();
    difference
}
