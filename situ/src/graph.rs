//! A task model as others see it: nodes, edges, the data beneath them, and what each primitive does.
//!
//! The one view that models of every method share: for the difference of two models, for structure scores and pictures.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use crate::demonstration::Pose;
use crate::place::{NodeId, Place, SegmentId};
use crate::primitive::Learner;
use crate::task_model::{History, Node, TaskModel};

/// A node of the graph.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphNode {
    /// Its id in the model.
    pub id: NodeId,
    /// Its reference object.
    pub reference: Arc<str>,
    /// The segments it holds, in order.
    pub segments: Vec<SegmentId>,
    /// The path of the mean execution of each of its ways, the oldest first, relative to its reference object.
    pub paths: Vec<Vec<Pose>>,
}

/// A task model's structure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// The primitives, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// The edges, START and END among their ends, in order.
    pub edges: Vec<(Place, Place)>,
    /// The number of keyframes of each segment: one list for each demonstration, in the order in which the model saw
    /// them.
    pub lengths: Vec<Vec<usize>>,
}

impl Graph {
    /// The graph of a task model.
    pub fn of<L: Learner>(model: &TaskModel<L>, learner: &L) -> Self {
        let node = |(id, node): (NodeId, &Node<L>)| GraphNode {
            id,
            reference: node.reference.clone(),
            segments: node.segments.iter().copied().collect(),
            paths: node.policies().into_iter().map(|policy| learner.path(policy)).collect(),
        };
        Self {
            nodes: model.nodes().map(node).collect(),
            edges: model.edges().collect(),
            lengths: model.histories().iter().map(History::lengths).collect(),
        }
    }

    /// The node that holds each segment.
    pub fn holders(&self) -> BTreeMap<SegmentId, &GraphNode> {
        self.nodes.iter().flat_map(|node| node.segments.iter().map(move |segment| (*segment, node))).collect()
    }

    /// The graph in the DOT language of Graphviz: one node for each primitive, besides START and END.
    pub fn to_dot(&self, name: &str) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        let mut dot = format!(
            "digraph {} {{\n  rankdir=LR;\n  START [shape=circle];\n  END [shape=doublecircle];\n",
            quoted(name)
        );
        for node in &self.nodes {
            let ways = if node.paths.len() > 1 { format!(", {} ways", node.paths.len()) } else { String::new() };
            let label = quoted(&format!("{} {}{ways}", node.id, node.reference));
            let _ = writeln!(dot, "  {} [shape=box, label={label}];", node.id);
        }
        for (from, to) in &self.edges {
            let _ = writeln!(dot, "  {from} -> {to};");
        }
        dot.push_str("}\n");
        dot
    }
}
