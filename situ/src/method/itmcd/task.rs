//! A keyframe task model that is corrected by the edit that AICc chooses.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::automaton::{Automaton, Retired, steps};
use super::candidate::Candidate;
use super::frames::Frames;
use super::parameters::ItmcdParameters;
use super::planned::Planned;
use super::selection::{Plan, Round, Shown, select};
use crate::correction::Correction;
use crate::decisions::Decisions;
use crate::error::SituError;
use crate::fold::fold;
use crate::graph::Graph;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::policy::Execution;
use crate::method::{KeyframeAutomaton, Learned};
use crate::place::{NodeId, Place};
use crate::segment::{RelativeKeyframe, Segment};
use crate::segmentation::by_reference_object;
use crate::state::State;
use crate::task_model::{History, TaskModel};
use crate::trace::{Counters, Trace};

/// A task model, and what the last correction was found to need.
#[derive(Clone)]
pub struct ItmcdTask {
    model: TaskModel<KeyframeLearner>,
    learner: KeyframeLearner,
    decisions: Decisions,
    scales: Vec<f64>,
    parameters: ItmcdParameters,
    retired: Retired,
    rounds: Vec<Round>,
    /// How many demonstrations the model held at each correction that was refused. These corrections are in none of its
    /// histories, and still count where its graph names a segment.
    refused: Vec<u32>,
}

impl ItmcdTask {
    /// Takes over the original model, which is that of every keyframe method.
    ///
    /// # Errors
    /// [`SituError::Parameter`] where fewer than two points stand for a segment.
    pub fn new(original: &KeyframeAutomaton, parameters: ItmcdParameters) -> Result<Self, SituError> {
        if parameters.points < 2 {
            let (parameter, value) = ("points", parameters.points as f64);
            return Err(SituError::Parameter { parameter, value, rule: "must be at least 2" });
        }
        Ok(Self {
            model: TaskModel::clone(&original.model),
            learner: original.learner(),
            decisions: Decisions::replacing(),
            scales: original.schema.features().iter().map(|feature| feature.scale).collect(),
            parameters,
            retired: Retired::new(),
            rounds: Vec::new(),
            refused: Vec::new(),
        })
    }

    /// The rounds of the last correction: every candidate, its AICc and its weight.
    pub fn rounds(&self) -> &[Round] {
        &self.rounds
    }

    /// Weighs the edits against each other.
    fn plan(&self, last: Place, shown: &History, counters: &mut Counters) -> Result<Plan, SituError> {
        let histories = || self.model.histories().iter().chain([shown]);
        let segments: Vec<&Segment> =
            histories().flat_map(|history| &history.segments).map(|segment| &**segment).collect();
        let ends = histories().map(|history| &history.final_state);
        let states: Vec<&State> = segments.iter().map(|segment| &segment.start).chain(ends).collect();
        let frames = Frames::new(&segments, &states, self.scales.clone(), &self.parameters);
        let (automaton, sequences) = Automaton::of(&self.model, &self.retired, &frames, &self.parameters)?;
        let after = shown.segments.iter().skip(1).map(|segment| &segment.start).chain([&shown.final_state]);
        let order = after.map(|state| {
            let mut places: Vec<(f64, Place)> = self
                .model
                .nodes()
                .map(|(id, _)| Place::Node(id))
                .chain([Place::End])
                .map(|place| (self.model.probability(place, state), place))
                .collect();
            counters.classifier_evaluations += places.len() as u64;
            places.sort_by(|left, right| right.0.total_cmp(&left.0).then(left.1.cmp(&right.1)));
            places.into_iter().map(|(_, place)| place).collect()
        });
        let shown = Shown {
            last,
            entry_features: frames.entry_features(&shown.segments[0].start),
            order: order.collect(),
            segments: steps(&frames, shown, |_, segment| frames.context(segment)),
            ends: shown.carried_to_end,
        };
        select(automaton, sequences, &shown, self.model.next_id(), &self.parameters, counters)
    }

    /// Folds the correction in: the plan says what each segment is, and the rest is Algorithm 2. Then the edges follow
    /// that the plan wants and the correction did not walk.
    fn fold(
        &mut self,
        correction: Correction<'_>,
        shown: History,
        plan: &Plan,
        nodes: &[NodeId],
    ) -> Result<Trace, SituError> {
        let mut planned = Planned::new(plan, nodes);
        let Self { model, learner, decisions, .. } = self;
        let trace = fold(correction, shown, model, learner, decisions, &mut planned)?;
        for (node, old) in std::mem::take(&mut planned.retired) {
            self.retired.entry(node).or_default().push(old);
        }
        for edit in plan.edits() {
            let (from, to) = match edit {
                Candidate::Edge { from, to } => (planned.actual(from), planned.actual(to)),
                Candidate::Node { new, to, .. } => (planned.actual(Place::Node(new)), planned.actual(to)),
                Candidate::Nothing | Candidate::Modify { .. } => continue,
            };
            if let (Some(from), Some(to)) = (from, to) {
                self.model.add_edge(from, to);
            }
        }
        Ok(trace)
    }
}

impl Learned for ItmcdTask {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, demonstration, .. } = correction;
        demonstration.check_features(self.scales.len())?;
        let shown = self.model.history(&correction, by_reference_object(demonstration))?;
        let mut counters = Counters::default();
        let plan = self.plan(last, &shown, &mut counters)?;
        let mut trace = Trace::default();
        match &plan.nodes {
            Some(nodes) => trace = self.fold(correction, shown, &plan, nodes)?,
            None => self.refused.push(self.model.histories().len() as u32),
        }
        // The search is the work of the whole correction, not of a segment.
        trace.counters += counters;
        self.rounds = plan.rounds;
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
        Ok((policy.reference().clone(), policy.keyframes(execution, rng)))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        let mut graph = Graph::of(&self.model, &self.learner);
        for segment in graph.nodes.iter_mut().flat_map(|node| &mut node.segments) {
            let held = segment.demonstration;
            segment.demonstration += self.refused.iter().filter(|at| **at <= held).count() as u32;
        }
        for (before, at) in self.refused.iter().enumerate() {
            graph.lengths.insert(*at as usize + before, Vec::new());
        }
        Ok(graph)
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::json!({
            "model": &self.model, "retired": &self.retired, "rounds": &self.rounds, "refused": &self.refused,
        })
    }
}
