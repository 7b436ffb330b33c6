//! The automaton of the labels. It has a node for each behaviour that ends at one place of one object, and an edge
//! wherever one run followed another.
//!
//! The original finds coordinate frames: it clusters the ends of each behaviour's runs in the frame of every object.
//! Demonstrations here name their reference object, so a run takes the object that most of its frames name. Only the
//! clusters remain to be found. Runs of one behaviour belong to two nodes if they end on two objects, far apart on one
//! object, or with different gripper commands. This is a *reconstruction*.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::recording::Frame;
use super::run::{Run, Stretch, runs};
use super::skill::Skill;
use crate::demonstration::Demonstration;
use crate::keyframe::classifier::scaled;
use crate::place::{NodeId, Place, SegmentId};
use crate::state::State;
use crate::trace::Counters;

/// Goals that are further apart than this are two goals, metres. Those of a careful teacher differ by one or two
/// centimetres.
const GOALS_APART: f64 = 0.05;

/// A demonstration as the method keeps it.
#[derive(Clone, Debug)]
pub(super) struct Recorded {
    pub(super) demonstration: Demonstration,
    pub(super) frames: Vec<Frame>,
    /// The runs of the node after which the demonstration begins; `None` at START. A correction replaces the nodes, but
    /// the frames stay.
    pub(super) after: Option<Vec<Stretch>>,
}

/// A node of the automaton.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Node {
    pub(super) skill: Skill,
    /// Its runs, in order.
    pub(super) runs: Vec<Run>,
    /// The segments by reference object of which most frames are this node's. There may be none.
    pub(super) segments: Vec<SegmentId>,
}

/// The automaton.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Automaton {
    /// The node with the id i is at i.
    pub(super) nodes: Vec<Node>,
    /// What follows START, and what follows each node.
    start: Branch,
    branches: Vec<Branch>,
    /// The typical difference of each feature of a state.
    scales: Vec<f64>,
}

impl Automaton {
    /// The automaton of all demonstrations and the labels of their frames. Nodes are in the order in which they first
    /// occur.
    pub(super) fn of(shown: &[Recorded], labels: &[Vec<usize>], scales: Vec<f64>, counters: &mut Counters) -> Self {
        let mut members: Vec<Vec<(Run, &[Frame])>> = Vec::new();
        let mut sequences: Vec<Vec<(usize, Run)>> = Vec::new();
        for (number, (one, labels)) in (0..).zip(shown.iter().zip(labels)) {
            let mut sequence = Vec::new();
            for run in runs(number, &one.demonstration, &one.frames, labels) {
                let id = alike(&members, &run, &one.frames).unwrap_or(members.len());
                if id == members.len() {
                    members.push(Vec::new());
                }
                members[id].push((run.clone(), &one.frames));
                sequence.push((id, run));
            }
            sequences.push(sequence);
        }
        let mut segments = vec![Vec::new(); members.len()];
        for (segment, id) in holders(shown, &sequences) {
            segments[id].push(segment);
        }
        let mut nodes: Vec<Node> = Vec::with_capacity(members.len());
        for (members, segments) in members.iter().zip(segments) {
            let taught: Vec<(&Run, &[Frame])> = members.iter().map(|(run, frames)| (run, *frames)).collect();
            counters.segments_touched += taught.len() as u64;
            counters.nodes_touched += 1;
            let skill = Skill::fit(taught[0].0.reference.clone(), &taught);
            nodes.push(Node { skill, runs: members.iter().map(|(run, _)| run.clone()).collect(), segments });
        }
        let branches = vec![Branch::default(); nodes.len()];
        let mut automaton = Self { nodes, start: Branch::default(), branches, scales };
        automaton.connect(shown, &sequences);
        let forks = automaton.branches.iter().chain([&automaton.start]).filter(|branch| branch.children().len() > 1);
        counters.classifier_fits += forks.count() as u64;
        automaton
    }

    /// Adds the edges with their examples. The example of a run is the state of the world where the run's object is
    /// first named.
    fn connect(&mut self, shown: &[Recorded], sequences: &[Vec<(usize, Run)>]) {
        for (one, sequence) in shown.iter().zip(sequences) {
            let demonstration = &one.demonstration;
            let state = |index: usize| {
                demonstration.keyframes().get(index).map_or(demonstration.final_state(), |keyframe| &keyframe.state)
            };
            let mut before = one.after.as_deref().and_then(|stretches| self.node_of(stretches));
            for (id, run) in sequence {
                self.follow(before, Place::Node(NodeId(*id as u32)), state(one.frames[run.first].state));
                before = Some(*id);
            }
            if demonstration.carried_to_end() {
                self.follow(before, Place::End, demonstration.final_state());
            }
        }
    }

    fn follow(&mut self, before: Option<usize>, next: Place, state: &State) {
        let branch = before.map_or(&mut self.start, |id| &mut self.branches[id]);
        branch.add(next, state, &self.scales);
    }

    /// The node that has most of the frames in which these stretches end, the first of equals. Only ends count, because
    /// what ran last ran to its end.
    fn node_of(&self, stretches: &[Stretch]) -> Option<usize> {
        let common = |node: &Node| -> usize {
            node.runs.iter().flat_map(|run| stretches.iter().map(|stretch| run.stretch.overlap(&stretch.tail()))).sum()
        };
        let counts = self.nodes.iter().map(common).enumerate();
        counts.reduce(|best, other| if other.1 > best.1 { other } else { best }).map(|(id, _)| id)
    }

    /// The node with this id.
    pub(super) fn node(&self, id: NodeId) -> Option<&Node> {
        self.nodes.get(id.0 as usize)
    }

    /// What follows a place in a state, and how probable that is.
    pub(super) fn next(&self, last: Place, state: &State) -> Option<(Place, f64)> {
        let branch = match last {
            Place::Start => &self.start,
            Place::Node(id) => self.branches.get(id.0 as usize)?,
            Place::End => return None,
        };
        branch.next(state, &self.scales)
    }

    /// The edges, in order.
    pub(super) fn edges(&self) -> Vec<(Place, Place)> {
        let nodes = (0..).zip(&self.branches).map(|(id, branch)| (Place::Node(NodeId(id)), branch));
        let branches = [(Place::Start, &self.start)].into_iter().chain(nodes);
        branches.flat_map(|(place, branch)| branch.children().into_iter().map(move |child| (place, child))).collect()
    }
}

/// The node that a run belongs to, if there is one. It must have this behaviour and this object, and its first run must
/// end near this run's end, with the same kind of gripper command. Of several nodes, the nearest.
fn alike(members: &[Vec<(Run, &[Frame])>], run: &Run, frames: &[Frame]) -> Option<usize> {
    let end = |run: &Run, frames: &[Frame]| {
        let last = &frames[run.stretch.end - 1];
        (frames[run.first].object.inv_mul(&last.pose), core::mem::discriminant(&last.command))
    };
    let (goal, told) = end(run, frames);
    let near = members.iter().enumerate().filter_map(|(id, members)| {
        let (first, frames) = members.first()?;
        let (other, other_told) = end(first, frames);
        let way = other.translation.vector - goal.translation.vector;
        let far = libm::sqrt(way.dot(&way));
        let same = first.label == run.label && first.reference == run.reference && other_told == told;
        (same && far <= GOALS_APART).then_some((id, far))
    });
    near.reduce(|best, other| if other.1 < best.1 { other } else { best }).map(|(id, _)| id)
}

/// The node that holds each segment by reference object: the node with most of the segment's frames, the first of
/// equals.
fn holders(shown: &[Recorded], sequences: &[Vec<(usize, Run)>]) -> Vec<(SegmentId, usize)> {
    let mut holders = Vec::new();
    for (demonstration, (one, sequence)) in (0..).zip(shown.iter().zip(sequences)) {
        let mut counts: BTreeMap<u32, BTreeMap<usize, usize>> = BTreeMap::new();
        for (id, run) in sequence {
            for frame in &one.frames[run.stretch.start..run.stretch.end] {
                *counts.entry(frame.segment).or_default().entry(*id).or_default() += 1;
            }
        }
        for (index, counts) in counts {
            let most = counts.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best });
            holders.extend(most.map(|(id, _)| (SegmentId { demonstration, index }, id)));
        }
    }
    holders
}

/// A distance that is added on both sides of the probability, in scales of the schema, so that no example decides
/// alone.
const DOUBT: f64 = 1.0;

/// What followed a place, each time, and in which state. Distances are L1, with each feature in its scale of the
/// schema.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct Branch {
    examples: Vec<(Place, Vec<f64>)>,
}

impl Branch {
    /// Adds one example.
    fn add(&mut self, next: Place, state: &State, scales: &[f64]) {
        self.examples.push((next, scaled(state, scales)));
    }

    /// The places that can follow, in order.
    fn children(&self) -> BTreeSet<Place> {
        self.examples.iter().map(|(place, _)| *place).collect()
    }

    /// What follows in this state, and how probable that is. An only child is certain. Of several children, that of the
    /// nearest example is taken, the first of equals. Its probability is (1 + b) / (2 + a + b), from ½ to 1, where a is
    /// the distance of the nearest example and b that of the nearest example of another child. The original's
    /// classifier gives no probability.
    fn next(&self, state: &State, scales: &[f64]) -> Option<(Place, f64)> {
        let state = scaled(state, scales);
        let distance = |example: &[f64]| example.iter().zip(&state).map(|(left, right)| (left - right).abs()).sum();
        let nearest = |among: &dyn Fn(Place) -> bool| {
            let examples = self.examples.iter().filter(|(place, _)| among(*place));
            let far: Vec<(Place, f64)> = examples.map(|(place, example)| (*place, distance(example))).collect();
            far.into_iter().reduce(|best, other| if other.1 < best.1 { other } else { best })
        };
        let (place, own) = nearest(&|_| true)?;
        let probability = match nearest(&|other| other != place) {
            None => 1.0,
            Some((_, other)) => (DOUBT + other) / (2.0 * DOUBT + own + other),
        };
        Some((place, probability))
    }
}
