//! How far a model's structure is what the teacher meant: pairs of keyframes in one node, and transitions between
//! skills.
//!
//! The truth is the teacher's narration. Methods need not hear it to be scored. Nodes are scored by pairs, as
//! clusterings are (Rand 1971; Manning, Raghavan and Schütze 2008, section 16.3): two keyframes belong together where
//! the teacher calls both the same. Edges are scored by the names, so that models with other nodes can be compared. An
//! edge is right where the skill that its first node ends with was followed, in some demonstration, by the skill that
//! its second node begins with. Two skills that follow each other inside a node are an edge, too.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::demonstration::{Demonstration, Keyframe};
use crate::graph::{Graph, GraphNode};
use crate::place::{NodeId, Place, SegmentId};

/// What two sets have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Agreement {
    /// Elements of both.
    pub both: u64,
    /// Elements of the model's.
    pub model: u64,
    /// Elements of the truth's.
    pub truth: u64,
}

impl Agreement {
    /// The harmonic mean of precision and recall; `None` where neither set has an element.
    pub fn f1(&self) -> Option<f64> {
        let all = self.model + self.truth;
        (all > 0).then(|| 2.0 * self.both as f64 / all as f64)
    }
}

/// The score of a model's structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// The model's nodes.
    pub nodes: u32,
    /// The model's edges, those from START and to END among them.
    pub edges: u32,
    /// Nodes that hold, in the main, a skill which an earlier node holds as well.
    pub duplicates: u32,
    /// Skills that some node holds in the main.
    pub skills: u32,
    /// Pairs of keyframes in one node.
    pub pairs: Agreement,
    /// Transitions between skills.
    pub transitions: Agreement,
}

/// A skill by the teacher's name for it, or an end of the task.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Label {
    Start,
    Skill(Arc<str>),
    End,
}

/// What the teacher meant by everything that was shown.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// The labels of each demonstration, one for each keyframe.
    shown: Vec<Vec<Arc<str>>>,
    transitions: BTreeSet<(Label, Label)>,
    /// Whether some keyframe has no name. Then no model can be scored.
    is_silent: bool,
}

impl Truth {
    /// A demonstration of the whole task.
    pub fn original(&mut self, demonstration: &Demonstration) {
        self.show(demonstration, Some(Label::Start));
    }

    /// A correction after `last` had run, in the model that is corrected.
    pub fn correction(&mut self, demonstration: &Demonstration, last: Place, corrected: &Graph) {
        let after = match last {
            Place::Start => Some(Label::Start),
            Place::End => None,
            Place::Node(id) => corrected
                .nodes
                .iter()
                .find(|node| node.id == id)
                .and_then(|node| self.label(corrected, node, |labels| labels.last()).map(Label::Skill)),
        };
        self.show(demonstration, after);
    }

    fn show(&mut self, demonstration: &Demonstration, after: Option<Label>) {
        let names = demonstration.keyframes().iter().map(|keyframe| keyframe.narration.clone());
        let labels: Vec<Arc<str>> = names.clone().flatten().collect();
        self.is_silent |= names.len() != labels.len();
        let skill = |label: Option<&Arc<str>>| label.cloned().map(Label::Skill);
        self.transitions.extend(after.zip(skill(labels.first())));
        self.transitions.extend(changes(&labels));
        if demonstration.carried_to_end() {
            self.transitions.extend(skill(labels.last()).map(|last| (last, Label::End)));
        }
        self.shown.push(labels);
    }

    /// The score of a model that was shown exactly this; `None` where the teacher did not name everything.
    pub fn score(&self, graph: &Graph) -> Option<Structure> {
        if self.is_silent {
            return None;
        }
        let mut known = BTreeSet::new();
        let (mut duplicates, mut unnamed) = (0, 0);
        let mut pairs = Agreement { truth: self.pairs(), ..Agreement::default() };
        let mut transitions = BTreeSet::new();
        let mut ends: BTreeMap<Place, (Label, Label)> = BTreeMap::new();
        ends.insert(Place::Start, (Label::Start, Label::Start));
        ends.insert(Place::End, (Label::End, Label::End));
        for node in &graph.nodes {
            let counts = count(self.segments(graph, node).flatten());
            pairs.model += in_pairs(counts.values().sum());
            pairs.both += counts.values().map(|count| in_pairs(*count)).sum::<u64>();
            duplicates += most(&counts).map_or(0, |label| u32::from(!known.insert(label)));
            transitions.extend(self.segments(graph, node).flat_map(changes));
            if let (Some(first), Some(last)) =
                (self.label(graph, node, |labels| labels.first()), self.label(graph, node, |labels| labels.last()))
            {
                ends.insert(Place::Node(node.id), (Label::Skill(first), Label::Skill(last)));
            }
        }
        for (from, to) in &graph.edges {
            match (ends.get(from), ends.get(to)) {
                (Some((_, from)), Some((to, _))) => _ = transitions.insert((from.clone(), to.clone())),
                // A node that holds nothing of what was shown: no teacher meant an edge of it.
                _ => unnamed += 1,
            }
        }
        Some(Structure {
            nodes: graph.nodes.len() as u32,
            edges: graph.edges.len() as u32,
            duplicates,
            skills: known.len() as u32,
            pairs,
            transitions: Agreement {
                both: transitions.intersection(&self.transitions).count() as u64,
                model: transitions.len() as u64 + unnamed,
                truth: self.transitions.len() as u64,
            },
        })
    }

    /// The skill that each node holds in the main. A node that holds nothing of what was shown has none.
    pub fn skills(&self, graph: &Graph) -> BTreeMap<NodeId, Arc<str>> {
        let skill = |node: &GraphNode| {
            let skill = most(&count(self.segments(graph, node).flatten()))?;
            Some((node.id, skill.clone()))
        };
        graph.nodes.iter().filter_map(skill).collect()
    }

    fn pairs(&self) -> u64 {
        count(self.shown.iter().flatten()).values().map(|count| in_pairs(*count)).sum()
    }

    /// The labels of each segment that a node holds. A segment that was never shown has none.
    fn segments<'a>(&'a self, graph: &'a Graph, node: &'a GraphNode) -> impl Iterator<Item = &'a [Arc<str>]> {
        node.segments.iter().map(|id: &SegmentId| {
            let (demonstration, index) = (id.demonstration as usize, id.index as usize);
            let lengths = graph.lengths.get(demonstration).and_then(|lengths| lengths.get(..=index));
            let labels = self.shown.get(demonstration).zip(lengths).and_then(|(labels, lengths)| {
                let end: usize = lengths.iter().sum();
                labels.get(end - lengths[index]..end)
            });
            labels.unwrap_or(&[])
        })
    }

    /// The label that most of a node's segments have at this place; where several are equal, the first by name.
    fn label(&self, graph: &Graph, node: &GraphNode, place: fn(&[Arc<str>]) -> Option<&Arc<str>>) -> Option<Arc<str>> {
        most(&count(self.segments(graph, node).filter_map(place))).cloned()
    }
}

/// What the teacher calls most of these keyframes; of equals the first by name. `None` where nothing is named.
pub fn main_skill(keyframes: &[Keyframe]) -> Option<Arc<str>> {
    most(&count(keyframes.iter().filter_map(|keyframe| keyframe.narration.as_ref()))).cloned()
}

/// Where the label changes, from which to which.
fn changes(labels: &[Arc<str>]) -> impl Iterator<Item = (Label, Label)> {
    let pairs = labels.windows(2).filter(|pair| pair[0] != pair[1]);
    pairs.map(|pair| (Label::Skill(pair[0].clone()), Label::Skill(pair[1].clone())))
}

fn count<'a>(labels: impl Iterator<Item = &'a Arc<str>>) -> BTreeMap<&'a Arc<str>, u64> {
    let mut counts = BTreeMap::new();
    for label in labels {
        *counts.entry(label).or_default() += 1;
    }
    counts
}

fn most<'a>(counts: &BTreeMap<&'a Arc<str>, u64>) -> Option<&'a Arc<str>> {
    counts.iter().reduce(|best, other| if other.1 > best.1 { other } else { best }).map(|(label, _)| *label)
}

/// Pairs among so many.
fn in_pairs(count: u64) -> u64 {
    count * count.saturating_sub(1) / 2
}
