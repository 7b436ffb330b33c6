//! The task model `T`: an automaton whose nodes are primitives, and the traversal histories of the data beneath it.

mod distances;
mod edges;
mod fit;
mod history;
mod journal;
mod node;
mod reconnect;
mod restore;
mod samples;
pub mod screen;
mod undo;
mod ways;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::correction::Correction;
use crate::error::SituError;
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::primitive::{Initiation, Learner};
use crate::segment::Segment;
use crate::state::State;
use crate::trace::Counters;
use crate::trail::PastStep;

use distances::Distances;
use edges::Edges;
pub use history::History;
use journal::Journal;
pub use node::{End, Node, Way};
use screen::Screen;

/// The automaton `T`.
///
/// Every edge stands for two consecutive places in a history; [`TaskModel::children`] and [`TaskModel::parents`] are
/// inverse to each other.
///
/// Written, it says everything but what follows from the rest; read, it is not whole before [`TaskModel::restored`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(bound(serialize = "L::Policy: Serialize, L::Classifier: Serialize, L::Calibration: Serialize"))]
#[serde(bound(deserialize = "Node<L>: DeserializeOwned, End<L>: DeserializeOwned, L::Calibration: DeserializeOwned"))]
pub struct TaskModel<L: Learner> {
    nodes: BTreeMap<NodeId, Node<L>>,
    end: End<L>,
    edges: Edges,
    histories: Vec<History>,
    /// The demonstrations whose origin is a segment.
    #[serde(skip)]
    followers: BTreeMap<SegmentId, Vec<u32>>,
    #[serde(skip)]
    by_reference: BTreeMap<Arc<str>, BTreeSet<NodeId>>,
    #[serde(skip)]
    screen: Screen,
    #[serde(skip)]
    distances: Distances,
    #[serde(skip)]
    journal: Option<Journal<L>>,
    next: u32,
    calibration: L::Calibration,
}

impl<L: Learner> TaskModel<L> {
    /// A model that knows nothing but its calibration.
    pub fn new(calibration: L::Calibration) -> Self {
        Self {
            nodes: BTreeMap::new(),
            end: End { samples: Samples::default(), classifier: None },
            edges: Edges::default(),
            histories: Vec::new(),
            followers: BTreeMap::new(),
            by_reference: BTreeMap::new(),
            screen: Screen::default(),
            distances: Distances::default(),
            journal: None,
            next: 0,
            calibration,
        }
    }

    /// κ, the number of primitives.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the model holds no primitive.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The calibration made when the originals were taught (decision D8).
    pub fn calibration(&self) -> &L::Calibration {
        &self.calibration
    }

    /// The nodes in the order of their ids.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (NodeId, &Node<L>)> {
        self.nodes.iter().map(|(id, node)| (*id, node))
    }

    /// The id that the next node will have.
    pub fn next_id(&self) -> NodeId {
        NodeId(self.next)
    }

    /// A node.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn node(&self, id: NodeId) -> Result<&Node<L>, SituError> {
        self.nodes.get(&id).ok_or(SituError::UnknownNode(id))
    }

    fn node_mut(&mut self, id: NodeId) -> Result<&mut Node<L>, SituError> {
        self.keep(id);
        self.nodes.get_mut(&id).ok_or(SituError::UnknownNode(id))
    }

    /// Writes a node down as it is, before its first change.
    fn keep(&mut self, id: NodeId) {
        if let Some(journal) = &mut self.journal {
            journal.nodes.entry(id).or_insert_with(|| self.nodes.get(&id).cloned());
        }
    }

    fn end_mut(&mut self) -> &mut End<L> {
        if let Some(journal) = &mut self.journal {
            journal.end.get_or_insert_with(|| self.end.clone());
        }
        &mut self.end
    }

    /// The pseudo-node END.
    pub fn end(&self) -> &End<L> {
        &self.end
    }

    /// The demonstrations in the order in which the model saw them.
    pub fn histories(&self) -> &[History] {
        &self.histories
    }

    /// The nodes with this reference object, in the order of their ids.
    pub fn nodes_of(&self, reference: &str) -> impl Iterator<Item = NodeId> {
        self.by_reference.get(reference).into_iter().flatten().copied()
    }

    /// `children(place)`, in order.
    pub fn children(&self, place: Place) -> impl Iterator<Item = Place> + Clone {
        self.edges.children(place)
    }

    /// `parent(place)`, in order.
    pub fn parents(&self, place: Place) -> impl Iterator<Item = Place> + Clone {
        self.edges.parents(place)
    }

    /// All edges, in order.
    pub fn edges(&self) -> impl Iterator<Item = (Place, Place)> {
        self.edges.all()
    }

    /// A segment.
    ///
    /// # Panics
    /// Where the id is of another model.
    pub fn segment(&self, id: SegmentId) -> &Arc<Segment> {
        &self.histories[id.demonstration as usize].segments[id.index as usize]
    }

    /// The state of a sample.
    ///
    /// # Panics
    /// Where the id is of another model.
    pub fn state(&self, sample: SampleId) -> &State {
        match sample {
            SampleId::Start(id) => &self.segment(id).start,
            SampleId::Final(index) => &self.histories[index as usize].final_state,
            SampleId::Chosen { demonstration, index } => {
                &self.histories[demonstration as usize].trail[index as usize].state
            }
        }
    }

    /// The node that holds a segment, once it has been placed.
    pub fn node_of(&self, id: SegmentId) -> Option<NodeId> {
        self.histories.get(id.demonstration as usize)?.nodes.get(id.index as usize).copied()
    }

    /// `{ z_j ∈ T | c_j(s) = 1 }` (A1.6): the primitives whose classifier is activated, in the order of their ids.
    pub fn applicable(&self, state: &State, counters: &mut Counters) -> Vec<NodeId> {
        counters.classifier_evaluations += self.nodes.len() as u64;
        let mut passing = self.screen.passing(state);
        passing.retain(|id| self.nodes[id].classifier.is_applicable(state));
        passing
    }

    /// The distances between the policies of these nodes, in ascending order of their ids: (0,1), (0,2), …, (1,2), …
    /// Between nodes of several ways it is that of the nearest. A distance is kept until a policy of the two changes.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn distances_among(
        &mut self,
        learner: &L,
        ids: &[NodeId],
        counters: &mut Counters,
    ) -> Result<Vec<f64>, SituError> {
        let mut among = Vec::with_capacity(ids.len() * ids.len().saturating_sub(1) / 2);
        for (index, lower) in ids.iter().enumerate() {
            for higher in &ids[index + 1..] {
                let distance = match self.distances.get(*lower, *higher) {
                    Some(distance) => distance,
                    None => {
                        let (left, right) = (self.node(*lower)?.policies(), self.node(*higher)?.policies());
                        let pairs = left.iter().flat_map(|left| right.iter().map(move |right| (*left, *right)));
                        let distances =
                            pairs.map(|(left, right)| learner.distance(left, right, Some(&self.calibration), counters));
                        let distance = distances.fold(f64::INFINITY, f64::min);
                        self.distances.keep(*lower, *higher, distance);
                        distance
                    }
                };
                among.push(distance);
            }
        }
        Ok(among)
    }

    /// The probability that `place` can begin in `state`; 0 for START and for END before anything ended.
    pub fn probability(&self, place: Place, state: &State) -> f64 {
        match place {
            Place::Start => 0.0,
            Place::Node(id) => self.nodes.get(&id).map_or(0.0, |node| node.classifier.probability(state)),
            Place::End => self.end.classifier.as_ref().map_or(0.0, |classifier| classifier.probability(state)),
        }
    }

    /// The children of `place`, each with its probability in `state`, the most probable first; in order where two tie.
    pub fn ranked_children(&self, place: Place, state: &State) -> Vec<(Place, f64)> {
        let mut ranked: Vec<_> = self.children(place).map(|child| (child, self.probability(child, state))).collect();
        ranked.sort_by(|left, right| right.1.total_cmp(&left.1));
        ranked
    }

    /// The child of `place` that is most probable in `state`, and its probability; the first in order where two tie.
    pub fn most_probable_child(&self, place: Place, state: &State) -> Option<(Place, f64)> {
        self.children(place)
            .map(|child| (child, self.probability(child, state)))
            .reduce(|best, other| if other.1 > best.1 { other } else { best })
    }

    /// Writes a demonstration down, none of its segments placed yet, and returns its segments' ids.
    pub fn begin(&mut self, history: History) -> Vec<SegmentId> {
        let demonstration = self.histories.len() as u32;
        if let Some(after) = history.after {
            self.followers.entry(after).or_default().push(demonstration);
        }
        let ids = (0..history.segments.len() as u32).map(|index| SegmentId { demonstration, index }).collect();
        self.histories.push(History { nodes: Vec::new(), ..history });
        ids
    }

    /// The segment that stands for `place` as the origin of a demonstration: the first that its node holds.
    ///
    /// # Errors
    /// [`SituError::NotExecutable`] for END, [`SituError::UnknownNode`].
    pub fn origin(&self, place: Place) -> Result<Option<SegmentId>, SituError> {
        match place {
            Place::Start => Ok(None),
            Place::Node(id) => Ok(self.node(id)?.segments.first().copied()),
            Place::End => Err(SituError::NotExecutable(place)),
        }
    }

    /// A correction as the model will write it down: cut into these segments, with its origin.
    ///
    /// # Errors
    /// Where the primitive that ran last is END or not in the model, or the interrupted one is not in the model.
    pub fn history(&self, correction: &Correction<'_>, segments: Vec<Segment>) -> Result<History, SituError> {
        let origin = self.origin(correction.last)?;
        let interrupted = correction.interrupted.map(|id| self.origin(Place::Node(id))).transpose()?.flatten();
        let mut trail = Vec::with_capacity(correction.trail.len());
        for step in correction.trail {
            let of = self.node(step.node)?.segments.first().copied();
            // A node holds a segment.
            trail.extend(of.map(|of| PastStep { state: step.state.clone(), of, end: step.end }));
        }
        Ok(History { interrupted, trail, ..History::new(correction.demonstration, segments, origin) })
    }

    /// Add-Node (A2.11) for a set of segments, with its ways.
    pub fn add_node(
        &mut self,
        segments: BTreeSet<SegmentId>,
        ways: Vec<Way<L::Policy>>,
        samples: Samples,
        classifier: L::Classifier,
    ) -> NodeId {
        let id = NodeId(self.next);
        self.next += 1;
        let first = segments.first().expect("a node holds at least one segment");
        let reference = self.segment(*first).reference.clone();
        self.keep(id);
        self.put_in(id, Node { reference, segments, ways, samples, classifier });
        id
    }

    fn put_in(&mut self, id: NodeId, node: Node<L>) {
        self.by_reference.entry(node.reference.clone()).or_default().insert(id);
        self.screen.set(id, node.classifier.ball());
        self.nodes.insert(id, node);
    }

    fn take_out(&mut self, id: NodeId) {
        let Some(node) = self.nodes.remove(&id) else { return };
        self.screen.remove(id);
        self.distances.forget(id);
        if let Some(ids) = self.by_reference.get_mut(&node.reference) {
            ids.remove(&id);
            if ids.is_empty() {
                self.by_reference.remove(&node.reference);
            }
        }
    }

    /// Notes in the history that the next segment of its demonstration was `id`.
    pub fn place(&mut self, segment: SegmentId, id: NodeId) {
        let nodes = &mut self.histories[segment.demonstration as usize].nodes;
        assert_eq!(nodes.len(), segment.index as usize, "segments are placed in order");
        nodes.push(id);
    }

    /// Add-Edge (A2.12, A2.20). Returns whether the edge is new.
    pub fn add_edge(&mut self, from: Place, to: Place) -> bool {
        let is_new = self.edges.add(from, to);
        if let Some(journal) = self.journal.as_mut().filter(|_| is_new) {
            journal.edges.push((from, to, true));
        }
        is_new
    }
}
