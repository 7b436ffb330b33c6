//! Nearest-neighbour replay: what was shown in the state that is nearest to the present one is done again.
//!
//! Nothing is clustered, averaged or classified, and no edge is heeded: it is the least that any method must beat.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::{Learned, Method, Original, Role};
use crate::correction::Correction;
use crate::demonstration::Demonstration;
use crate::error::SituError;
use crate::graph::{Graph, GraphNode};
use crate::keyframe::policy::Execution;
use crate::place::{NodeId, Place, SegmentId};
use crate::segment::{RelativeKeyframe, Segment};
use crate::segmentation::by_reference_object;
use crate::state::{Schema, State};
use crate::trace::Trace;

/// The method.
pub struct Nearest;

impl Method for Nearest {
    fn name(&self) -> &str {
        "nearest"
    }

    fn summary(&self) -> &str {
        "replays the demonstrated segment whose start state is nearest; nothing is clustered, averaged or classified"
    }

    fn source(&self) -> &str {
        "this project"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn learn_original(&self, schema: &Schema, shown: &[Demonstration], _: u64) -> Result<Original, SituError> {
        if shown.is_empty() {
            return Err(SituError::NoDemonstration);
        }
        let scales = schema.features().iter().map(|feature| feature.scale).collect();
        let mut memory = Memory { scales, shown: Vec::new() };
        for demonstration in shown {
            demonstration.check_features(schema.len())?;
            memory.remember(demonstration, Place::Start);
        }
        Ok(Original::of(memory))
    }
}

/// A demonstration as it is remembered.
#[derive(Clone, Serialize)]
struct Remembered {
    /// The primitive that ran last before it.
    after: Place,
    /// The number of its first segment among all; each segment is a primitive.
    first: u32,
    segments: Vec<Segment>,
    /// The world after it, where it was carried on to the end of the task.
    end: Option<State>,
}

/// All that was shown.
#[derive(Clone, Serialize)]
struct Memory {
    /// What counts as one unit of each feature.
    scales: Vec<f64>,
    shown: Vec<Remembered>,
}

impl Memory {
    fn len(&self) -> u32 {
        self.shown.last().map_or(0, |shown| shown.first + shown.segments.len() as u32)
    }

    fn remember(&mut self, demonstration: &Demonstration, after: Place) {
        let end = demonstration.carried_to_end().then(|| demonstration.final_state().clone());
        let segments = by_reference_object(demonstration);
        self.shown.push(Remembered { after, first: self.len(), segments, end });
    }

    /// The segments, each with the primitive that it is.
    fn primitives(&self) -> impl Iterator<Item = (NodeId, &Segment)> {
        self.shown.iter().flat_map(|shown| (shown.first..).map(NodeId).zip(&shown.segments))
    }

    fn primitive(&self, id: NodeId) -> Result<&Segment, SituError> {
        self.primitives().find(|(own, _)| *own == id).map(|(_, segment)| segment).ok_or(SituError::UnknownNode(id))
    }
}

impl Learned for Memory {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, interrupted, demonstration, .. } = correction;
        demonstration.check_features(self.scales.len())?;
        match last {
            Place::Start => {}
            Place::Node(id) => drop(self.primitive(id)?),
            Place::End => return Err(SituError::NotExecutable(last)),
        }
        interrupted.map(|id| self.primitive(id)).transpose()?;
        self.remember(demonstration, last);
        Ok(Trace::default())
    }

    /// The nearest start or end; of two that are equally near, the one that was shown later.
    fn ranked(&self, _: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        let starts = self.primitives().map(|(id, segment)| (Place::Node(id), &segment.start));
        let ends = self.shown.iter().filter_map(|shown| Some((Place::End, shown.end.as_ref()?)));
        let near = starts.chain(ends).map(|(place, shown)| (place, shown.squared_distance(state, &self.scales)));
        let nearest = near.reduce(|best, other| if other.1 <= best.1 { other } else { best });
        Ok(nearest.map(|(place, _)| (place, 1.0)).into_iter().collect())
    }

    fn keyframes(
        &self,
        node: NodeId,
        _: usize,
        _: &State,
        _: Execution,
        _: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let segment = self.primitive(node)?;
        Ok((segment.reference.clone(), segment.keyframes.clone()))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        let mut graph = Graph::default();
        for (demonstration, shown) in (0..).zip(&self.shown) {
            let mut before = shown.after;
            for (index, segment) in (0..).zip(&shown.segments) {
                let id = NodeId(shown.first + index);
                graph.nodes.push(GraphNode {
                    id,
                    reference: segment.reference.clone(),
                    segments: vec![SegmentId { demonstration, index }],
                    paths: vec![segment.keyframes.iter().map(|keyframe| keyframe.pose).collect()],
                });
                graph.edges.push((before, Place::Node(id)));
                before = Place::Node(id);
            }
            graph.edges.extend(shown.end.as_ref().map(|_| (before, Place::End)));
            graph.lengths.push(shown.segments.iter().map(|segment| segment.keyframes.len()).collect());
        }
        graph.edges.sort_unstable();
        Ok(graph)
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("finite numbers and string keys")
    }
}
