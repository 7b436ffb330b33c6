//! The structure of an external model, and what its places are called.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};
use situ::demonstration::Pose;
use situ::graph::{Graph, GraphNode};
use situ::keyframe::policy::Execution;
use situ::place::{NodeId, Place, SegmentId};
use situ::state::State;
use situ_tasks::name::shown;

use super::answers::{Executed, Saved, Structure, read};
use super::pool::{Asked, question};
use super::process::Fault;
use super::told::Told;

/// The place that is the end of a task. No primitive is called so.
const END: &str = "end";
/// The most primitives of a model.
const MOST_NODES: usize = 100_000;
/// The most ways of a primitive.
const MOST_WAYS: usize = 1000;
/// The most letters of a place's name.
const LONGEST_NAME: usize = 200;

/// What is known of a model.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) graph: Graph,
    /// The names of primitives, of this model and of those before it; the index is the id.
    pub(super) names: Vec<String>,
    ids: BTreeMap<String, NodeId>,
}

impl Known {
    /// Asks for the structure, and for the path of each way of each primitive. Ids go on from the names that were known
    /// before. Where others may want the model, it is saved, too.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn of(asked: &mut Asked<'_>, told: &Told, before: &[String], is_shared: bool) -> Result<Self, Fault> {
        let answer = asked.ask(&question(json!({"do": "graph"})))?;
        let structure: Structure = read("graph", answer).map_err(Fault::Broken)?;
        let mut known = Self::named(&structure, before).map_err(Fault::Broken)?;
        known.graph.lengths = told.shown.iter().map(|shown| shown.lengths.clone()).collect();
        let mut held = BTreeSet::new();
        for node in structure.nodes {
            let refuse = |problem: &str| Fault::Broken(format!("the answer to `graph`, `{}`: {problem}", node.place));
            let mut segments = Vec::new();
            let mut start = None;
            for (name, index) in &node.segments {
                let number = told.shown.iter().rposition(|shown| shown.name == *name);
                let number = number.ok_or_else(|| refuse(&format!("no demonstration is called `{}`", shown(name))))?;
                let state = told.shown[number].starts.get(*index as usize);
                let state = state.ok_or_else(|| refuse(&format!("`{}` has no segment {index}", shown(name))))?;
                let segment = SegmentId { demonstration: crate::tally::count(number), index: *index };
                if !held.insert(segment) {
                    return Err(refuse(&format!("segment {index} of `{}` is held twice", shown(name))));
                }
                segments.push(segment);
                start.get_or_insert(state);
            }
            segments.sort_unstable();
            if !(1..=MOST_WAYS).contains(&node.ways) {
                return Err(refuse(&format!("{} ways: expected 1 to {MOST_WAYS}", node.ways)));
            }
            let first = || told.shown.first().and_then(|shown| shown.starts.first());
            let Some(state) = start.or_else(first) else { return Err(refuse("no demonstration was shown")) };
            let (mut reference, mut paths) = (None, Vec::new());
            for way in 0..node.ways {
                let how = keyframes(&node.place, state, Execution::Mean, way, 0);
                let (object, keyframes) = executed(asked.ask(&how)?).map_err(Fault::Broken)?;
                paths.push(keyframes.iter().map(|keyframe| keyframe.pose).collect::<Vec<Pose>>());
                reference.get_or_insert(object);
            }
            let Some(reference) = reference else { continue };
            known.graph.nodes.push(GraphNode { id: known.ids[&node.place], reference, segments, paths });
        }
        known.graph.nodes.sort_by_key(|node| node.id);
        if is_shared && told.saved.get().is_none() {
            let saved = match asked.ask(&question(json!({"do": "save"}))) {
                Ok(answer) => Some(read::<Saved>("save", answer).map_err(Fault::Broken)?.model),
                Err(Fault::Refused(_)) => None,
                Err(fault) => return Err(fault),
            };
            let _ = told.saved.set(saved);
        }
        Ok(known)
    }

    /// The names and the edges.
    fn named(structure: &Structure, before: &[String]) -> Result<Self, String> {
        let refuse = |problem: String| Err(format!("the answer to `graph`: {problem}"));
        if structure.nodes.len() > MOST_NODES {
            return refuse(format!("{} nodes, expected at most {MOST_NODES}", structure.nodes.len()));
        }
        let mut names = before.to_vec();
        let former: BTreeSet<&String> = before.iter().collect();
        let mut met = BTreeSet::new();
        for node in &structure.nodes {
            let name = &node.place;
            if name.is_empty() || name == END || name.chars().count() > LONGEST_NAME {
                return refuse(format!("a place `{}`: expected a name that is not `{END}`", shown(name)));
            }
            if !met.insert(name) {
                return refuse(format!("two nodes are called `{}`", shown(name)));
            }
            if !former.contains(name) {
                names.push(name.clone());
            }
        }
        let ids: BTreeMap<String, NodeId> = names.iter().cloned().zip((0..).map(NodeId)).collect();
        let here: BTreeMap<&String, NodeId> = met.iter().map(|name| (*name, ids[*name])).collect();
        let place = |name: &String| match here.get(name) {
            Some(id) => Ok(Place::Node(*id)),
            None if name == END => Ok(Place::End),
            None => Err(format!("the answer to `graph`: an edge to or from `{}`, which is no node", shown(name))),
        };
        let mut edges = BTreeSet::new();
        for (from, to) in &structure.edges {
            let from = from.as_ref().map_or(Ok(Place::Start), place)?;
            if from == Place::End {
                return refuse(format!("an edge from `{END}`"));
            }
            edges.insert((from, place(to)?));
        }
        let graph = Graph { edges: edges.into_iter().collect(), ..Graph::default() };
        // Names of former models are no places of this one.
        let ids = here.into_iter().map(|(name, id)| (name.clone(), id)).collect();
        Ok(Self { graph, names, ids })
    }

    /// The place of this name; `None` where the model has none.
    pub(super) fn place(&self, name: &str) -> Option<Place> {
        match self.ids.get(name) {
            Some(id) => Some(Place::Node(*id)),
            None => (name == END).then_some(Place::End),
        }
    }

    /// A primitive of this model.
    pub(super) fn node(&self, id: NodeId) -> Option<&GraphNode> {
        self.graph.nodes.binary_search_by_key(&id, |node| node.id).ok().map(|index| &self.graph.nodes[index])
    }

    /// The name of a primitive of this model.
    pub(super) fn name(&self, id: NodeId) -> Option<&str> {
        self.node(id).and_then(|node| self.names.get(node.id.0 as usize)).map(String::as_str)
    }
}

/// Asks for the keyframes of one execution.
pub(super) fn keyframes(
    place: &str,
    state: &State,
    execution: Execution,
    attempt: usize,
    seed: u32,
) -> Map<String, Value> {
    let execution = match execution {
        Execution::Mean => "mean",
        Execution::Sample => "sample",
    };
    question(json!({
        "do": "keyframes", "place": place, "state": state, "execution": execution, "attempt": attempt, "seed": seed,
    }))
}

/// The answer to that.
pub(super) fn executed(
    answer: Map<String, Value>,
) -> Result<(std::sync::Arc<str>, Vec<situ::segment::RelativeKeyframe>), String> {
    read::<Executed>("keyframes", answer)?.relative().map_err(|problem| format!("the answer to `keyframes`: {problem}"))
}
