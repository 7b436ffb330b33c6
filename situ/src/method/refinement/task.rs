//! A task model with primitives that are refined one by one, under an automaton that stays as it was taught.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Isometry3;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::attribution::Attribution;
use super::refine::Refine;
use crate::correction::Correction;
use crate::decisions::Decisions;
use crate::error::SituError;
use crate::graph::Graph;
use crate::keyframe::interpolate::resample;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::policy::{Execution, draw};
use crate::keyframe::pose::exp;
use crate::method::{KeyframeAutomaton, Learned};
use crate::place::{NodeId, Place, SegmentId};
use crate::segment::{RelativeKeyframe, Segment};
use crate::segmentation::by_reference_object;
use crate::state::State;
use crate::task_model::TaskModel;
use crate::trace::Trace;

/// The original automaton, and the refined primitives beside it.
#[derive(Clone, Debug)]
pub(super) struct RefinedTask<R: Refine> {
    refine: R,
    /// It never changes, so copies share it.
    model: Arc<TaskModel<KeyframeLearner>>,
    learner: KeyframeLearner,
    decisions: Decisions,
    /// The lengths of the segments of all corrections, in keyframes, the ignored ones too. They number the segments.
    corrections: Vec<Vec<usize>>,
    corrected: BTreeMap<NodeId, Corrected<R::Primitive>>,
}

/// A node that corrections were about.
#[derive(Clone, Debug, Serialize)]
struct Corrected<P> {
    /// The segments of the corrections.
    segments: Vec<SegmentId>,
    primitive: P,
}

impl<R: Refine> RefinedTask<R> {
    pub(super) fn new(refine: R, original: &KeyframeAutomaton) -> Self {
        let (model, learner) = (Arc::clone(&original.model), original.learner());
        let decisions = Decisions::mended();
        Self { refine, model, learner, decisions, corrections: Vec::new(), corrected: BTreeMap::new() }
    }

    /// The node as it is now. If no correction was about it before, it is made from the original.
    fn corrected(&self, id: NodeId, trace: &mut Trace) -> Result<Corrected<R::Primitive>, SituError> {
        if let Some(known) = self.corrected.get(&id) {
            return Ok(known.clone());
        }
        let node = self.model.node(id)?;
        let way = node.newest();
        let segments: Vec<&Segment> = way.segments.iter().map(|id| &**self.model.segment(*id)).collect();
        let primitive = self.refine.fit(&way.policy, &segments, &mut trace.counters)?;
        Ok(Corrected { segments: Vec::new(), primitive })
    }
}

impl<R: Refine> Learned for RefinedTask<R> {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, mut interrupted, demonstration, .. } = correction;
        demonstration.check_features(self.learner.features())?;
        let history = self.model.history(&correction, by_reference_object(demonstration))?;
        let number = (self.model.histories().len() + self.corrections.len()) as u32;
        let mut trace = Trace::default();
        let mut touched: BTreeMap<NodeId, Corrected<R::Primitive>> = BTreeMap::new();
        let mut a = last;
        if let Some(rule) = &self.decisions.modify {
            let attribution = Attribution { model: &self.model, learner: &self.learner, rule };
            for (index, segment) in (0..).zip(&history.segments) {
                let about = attribution.of(a, interrupted.take(), segment, &mut trace.counters)?;
                let Some(id) = about else { continue };
                let mut node = match touched.remove(&id) {
                    Some(node) => node,
                    None => self.corrected(id, &mut trace)?,
                };
                self.refine.correct(&mut node.primitive, segment, &mut trace.counters)?;
                node.segments.push(SegmentId { demonstration: number, index });
                touched.insert(id, node);
                a = Place::Node(id);
            }
        }
        // This comes last, so that an error leaves the model as it was.
        trace.counters.nodes_touched += touched.len() as u64;
        self.corrected.append(&mut touched);
        self.corrections.push(history.lengths());
        Ok(trace)
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        Ok(self.model.ranked_children(last, state))
    }

    fn next(&self, last: Place, state: &State) -> Result<Option<(Place, f64)>, SituError> {
        Ok(self.model.most_probable_child(last, state))
    }

    fn keyframes(
        &self,
        node: NodeId,
        _: usize,
        _: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let policy = &self.model.node(node)?.newest().policy;
        let reference = policy.reference().clone();
        let Some(corrected) = self.corrected.get(&node) else {
            return Ok((reference, policy.keyframes(execution, rng)));
        };
        let mut execute = |keyframe: super::RefinedKeyframe| match execution {
            Execution::Mean => keyframe.mean,
            Execution::Sample => {
                RelativeKeyframe { pose: exp(&keyframe.mean.pose, &draw(&keyframe.scatter, rng)), ..keyframe.mean }
            }
        };
        Ok((reference, self.refine.keyframes(&corrected.primitive).into_iter().map(&mut execute).collect()))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        let mut graph = Graph::of(&self.model, &self.learner);
        graph.lengths.extend(self.corrections.iter().cloned());
        let parameters = self.learner.parameters();
        for node in &mut graph.nodes {
            let Some(corrected) = self.corrected.get(&node.id) else { continue };
            let keyframes = self.refine.keyframes(&corrected.primitive);
            let means: Vec<Isometry3<f64>> = keyframes.iter().map(|keyframe| keyframe.mean.pose).collect();
            node.paths = vec![resample(&means, parameters.signature_points, parameters.metres_per_radian)];
            node.segments.extend(&corrected.segments);
        }
        Ok(graph)
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        #[derive(Serialize)]
        struct Whole<'a, P: Serialize> {
            model: &'a TaskModel<KeyframeLearner>,
            corrections: usize,
            corrected: &'a BTreeMap<NodeId, Corrected<P>>,
        }
        let whole = Whole { model: &self.model, corrections: self.corrections.len(), corrected: &self.corrected };
        serde_json::to_value(whole).expect("a model's keys are numbers or strings and its numbers finite")
    }
}
