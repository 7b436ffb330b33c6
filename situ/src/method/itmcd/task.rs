//! A keyframe task model that is corrected by the edit that AICc chooses.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::automaton::{Automaton, Retired, steps};
use super::candidate::Candidate;
use super::frames::Frames;
use super::parameters::ItmcdParameters;
use super::selection::{Plan, Round, Shown, select};
use crate::correction::Correction;
use crate::decisions::Decisions;
use crate::demonstration::{Demonstration, RelativeKeyframe, Schema, Segment, State};
use crate::error::SituError;
use crate::graph::Graph;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::KeyframeParameters;
use crate::keyframe::policy::Execution;
use crate::method::Learned;
use crate::method::original::keyframe_automaton;
use crate::place::{NodeId, Place};
use crate::primitive::Learner;
use crate::segmentation::by_reference_object;
use crate::situ::{Target, commit, end};
use crate::task_model::{History, TaskModel};
use crate::trace::{Branch, Counters, MatchedIn, Step, Trace};

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
    /// How many demonstrations the model held at each correction that was refused: those are in none of its histories, and still count where
    /// its graph names a segment.
    refused: Vec<u32>,
}

impl ItmcdTask {
    /// The original model, which is that of every keyframe method.
    ///
    /// # Errors
    /// As [`crate::method::Method::teach`]; [`SituError::Parameter`] where fewer than two points stand for a segment.
    pub fn teach(
        schema: &Schema,
        demonstrations: &[Demonstration],
        parameters: ItmcdParameters,
    ) -> Result<Self, SituError> {
        if parameters.points < 2 {
            let (parameter, value) = ("points", parameters.points as f64);
            return Err(SituError::Parameter { parameter, value, rule: "must be at least 2" });
        }
        Ok(Self {
            model: keyframe_automaton(schema, demonstrations)?,
            learner: KeyframeLearner::new(schema, KeyframeParameters::default()),
            decisions: Decisions::mended(),
            scales: schema.features().iter().map(|feature| feature.scale).collect(),
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

    /// Folds the correction in as SITU does (Algorithm 2 from line 5 on), but that the plan says what each segment is; then the edges that
    /// the plan wants and the correction did not walk.
    fn fold(&mut self, last: Place, shown: History, plan: &Plan, nodes: &[NodeId]) -> Result<Trace, SituError> {
        let carried_to_end = shown.carried_to_end;
        let candidates: usize = plan.rounds.iter().map(|round| round.evaluations.len()).sum();
        let (mut modified, mut unmade) = (BTreeSet::new(), BTreeSet::new());
        for edit in plan.edits() {
            match edit {
                Candidate::Modify { node, .. } => modified.insert(node),
                Candidate::Node { new, .. } => unmade.insert(new),
                Candidate::Nothing | Candidate::Edge { .. } => continue,
            };
        }
        // A planned node that no segment was placed in is not made; the ids of those behind it move up.
        let mut made: BTreeMap<NodeId, NodeId> = BTreeMap::new();
        let (mut a, mut trace) = (last, Trace::default());
        let index = self.model.histories().len() as u32;
        for (d, planned) in self.model.begin(shown).into_iter().zip(nodes) {
            let segment = self.model.segment(d).clone();
            let (model_size, mut counters) = (self.model.len(), Counters::default());
            // A node that this correction makes has no older way to replace.
            let replaces = modified.remove(planned);
            let mut own = || self.learner.fit_policy(&[&segment], &mut counters);
            let target = if unmade.remove(planned) {
                Target::New(own()?)
            } else {
                let z = made.get(planned).copied().unwrap_or(*planned);
                if replaces {
                    let old = self.model.node(z)?.policy_segments.clone();
                    self.retired.entry(z).or_default().push(old);
                    Target::Modify(z, own()?)
                } else {
                    Target::Existing(z)
                }
            };
            let branch = target.branch();
            let matched_in = if branch == Branch::New { MatchedIn::None } else { MatchedIn::Reference };
            let (node, edge_added) =
                commit(a, d, target, &mut self.model, &self.learner, &self.decisions, &mut counters)?;
            if branch == Branch::New {
                made.insert(*planned, node);
            }
            trace.counters += counters;
            trace.steps.push(Step {
                reference: segment.reference.to_string(),
                // Nothing is indexed: the edits of every primitive are weighed.
                applicable: model_size,
                model_size,
                candidates,
                matched_in,
                branch,
                node,
                after: a,
                edge_added,
                merged: Vec::new(),
                counters,
            });
            a = Place::Node(node);
        }
        if carried_to_end {
            end(a, index, &mut self.model, &self.learner, &self.decisions, &mut trace.counters)?;
        }
        for edit in plan.edits() {
            let actual = |place: Place| match place {
                Place::Node(name) if unmade.contains(&name) => None,
                Place::Node(name) => Some(Place::Node(made.get(&name).copied().unwrap_or(name))),
                other => Some(other),
            };
            let (from, to) = match edit {
                Candidate::Edge { from, to } => (actual(from), actual(to)),
                Candidate::Node { new, to, .. } => (actual(Place::Node(new)), actual(to)),
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
        let Correction { last, interrupted, demonstration, told: _ } = correction;
        demonstration.check_features(self.scales.len())?;
        let after = self.model.origin(last)?;
        interrupted.map(|id| self.model.node(id)).transpose()?;
        let shown = History::new(demonstration, by_reference_object(demonstration), after);
        let mut counters = Counters::default();
        let plan = self.plan(last, &shown, &mut counters)?;
        let mut trace = Trace::default();
        match &plan.nodes {
            Some(nodes) => trace = self.fold(last, shown, &plan, nodes)?,
            None => self.refused.push(self.model.histories().len() as u32),
        }
        // The search is the work of the whole correction, not of a segment.
        trace.counters += counters;
        self.rounds = plan.rounds;
        Ok(trace)
    }

    fn next(&self, last: Place, state: &State) -> Option<(Place, f64)> {
        self.model.most_probable_child(last, state)
    }

    fn keyframes(
        &self,
        node: NodeId,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let policy = &self.model.node(node)?.policy;
        Ok((policy.reference().clone(), policy.keyframes(execution, rng)))
    }

    fn graph(&self) -> Graph {
        let mut graph = Graph::of(&self.model, &self.learner);
        for segment in graph.nodes.iter_mut().flat_map(|node| &mut node.segments) {
            let held = segment.demonstration;
            segment.demonstration += self.refused.iter().filter(|at| **at <= held).count() as u32;
        }
        graph
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
