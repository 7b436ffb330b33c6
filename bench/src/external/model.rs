//! A task model that an external method holds.

use std::sync::{Arc, OnceLock};

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use situ::correction::Correction;
use situ::error::SituError;
use situ::graph::Graph;
use situ::keyframe::policy::Execution;
use situ::method::Learned;
use situ::place::{NodeId, Place};
use situ::segment::RelativeKeyframe;
use situ::segmentation::lengths;
use situ::state::{Schema, State};
use situ::trace::Trace;
use situ::trail::TrailStep;
use situ_tasks::name::shown;

use super::answers::{Corrected, Next, read};
use super::known::{Known, executed, keyframes};
use super::pool::question;
use super::process::Fault;
use super::program::Program;
use super::told::{Shown, Told};
use crate::demonstration_file::shown_keys;

/// The most places that may follow one.
const MOST_CHILDREN: usize = 100_000;

/// A task model, as far as it is here. Copies share it until one of them is corrected.
#[derive(Clone)]
pub(super) struct ExternalModel {
    program: Arc<Program>,
    schema: Arc<Schema>,
    held: Arc<Held>,
}

/// What was told, and what is known of what came of it.
struct Held {
    told: Arc<Told>,
    /// The names of places of the models before.
    before: Vec<String>,
    known: OnceLock<Result<Known, SituError>>,
}

impl ExternalModel {
    pub(super) fn new(program: Arc<Program>, schema: &Schema, told: Arc<Told>, before: Vec<String>) -> Self {
        let held = Held { told, before, known: OnceLock::new() };
        Self { program, schema: Arc::new(schema.clone()), held: Arc::new(held) }
    }

    /// The structure. It is asked for once, and not while an update is timed.
    fn known(&self) -> Result<&Known, SituError> {
        let Held { told, before, known } = &*self.held;
        let known = known.get_or_init(|| {
            let is_shared = self.program.pool.most() > 1;
            let known = self.program.pool.asked(told, |asked| Known::of(asked, told, before, is_shared));
            known.map_err(|fault| self.program.failed(fault))
        });
        known.as_ref().map_err(SituError::clone)
    }

    /// Whether its states are of this schema.
    pub(super) fn is_of(&self, schema: &Schema) -> bool {
        *self.schema == *schema
    }

    /// The name of a place that may have run last: nothing where none did.
    fn last(&self, last: Place) -> Result<Option<&str>, SituError> {
        match last {
            Place::Start => Ok(None),
            Place::Node(id) => self.known()?.name(id).map(Some).ok_or(SituError::UnknownNode(id)),
            Place::End => Err(SituError::NotExecutable(last)),
        }
    }

    /// An answer that is none.
    fn refuse(&self, what: &str, problem: &str) -> SituError {
        self.program.failed(Fault::Broken(format!("the answer to `{what}`: {problem}")))
    }
}

impl Learned for ExternalModel {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, interrupted, trail, demonstration, oracle: _ } = correction;
        demonstration.check_features(self.schema.len())?;
        let known = self.known()?;
        let name = |id: NodeId| known.name(id).ok_or(SituError::UnknownNode(id));
        let step = |step: &TrailStep| Ok(json!({"place": name(step.node)?, "state": step.state, "ended": step.end}));
        let question = question(json!({
            "do": "correct",
            "last": self.last(last)?,
            "interrupted": interrupted.map(name).transpose()?,
            "trail": trail.iter().map(step).collect::<Result<Vec<Value>, SituError>>()?,
            "demonstration": shown_keys(demonstration, &self.schema),
        }));
        let (told, before) = (&self.held.told, known.names.clone());
        let result = self.program.pool.asked(told, |asked| {
            let answer: Corrected = read("correct", asked.correct(&question)?).map_err(Fault::Broken)?;
            let counters = answer.counters().map_err(Fault::Broken)?;
            let own = answer.segments.clone().unwrap_or_else(|| lengths(demonstration));
            let shown = Shown::cut(demonstration, own).map_err(Fault::Broken)?;
            if let Some(edit) = answer.edits.iter().find(|edit| !self.program.can(**edit)) {
                return Err(Fault::Broken(format!("it made the edit {edit}, which `hello` does not name")));
            }
            let all = told.shown.iter().cloned().chain([shown]).collect();
            let after = Told::new(Some(Arc::clone(told)), question.clone(), all);
            asked.holds(&after);
            Ok((after, counters))
        });
        let (after, counters) = result.map_err(|fault| self.program.failed(fault))?;
        self.held = Arc::new(Held { told: after, before, known: OnceLock::new() });
        Ok(Trace { counters, ..Trace::default() })
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        if last == Place::End {
            return Ok(Vec::new());
        }
        let known = self.known()?;
        let question = question(json!({"do": "next", "last": self.last(last)?, "state": state}));
        let answer = self.program.pool.asked(&self.held.told, |asked| asked.ask(&question));
        let answer = answer.map_err(|fault| self.program.failed(fault))?;
        let Next { children } = read("next", answer).map_err(|problem| self.program.failed(Fault::Broken(problem)))?;
        if children.len() > MOST_CHILDREN {
            return Err(self.refuse("next", &format!("{} children: expected at most {MOST_CHILDREN}", children.len())));
        }
        let mut ranked: Vec<(Place, f64)> = Vec::with_capacity(children.len());
        for child in children {
            let place = known.place(&child.place).ok_or_else(|| {
                self.refuse("next", &format!("`{}` is no node of the last `graph`", shown(&child.place)))
            })?;
            if !(0.0..=1.0).contains(&child.probability) {
                return Err(self.refuse("next", &format!("probability {}: expected 0 to 1", child.probability)));
            }
            if ranked.last().is_some_and(|(_, former)| *former < child.probability) {
                return Err(self.refuse("next", "expected the likeliest first"));
            }
            ranked.push((place, child.probability));
        }
        Ok(ranked)
    }

    fn ways(&self, node: NodeId, _: &State) -> Result<Vec<usize>, SituError> {
        let node = self.known()?.node(node).ok_or(SituError::UnknownNode(node))?;
        Ok((0..node.paths.len()).collect())
    }

    fn keyframes(
        &self,
        node: NodeId,
        way: usize,
        state: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let name = self.known()?.name(node).ok_or(SituError::UnknownNode(node))?;
        let question = keyframes(name, state, execution, way, rng.next_u32());
        let answer = self.program.pool.asked(&self.held.told, |asked| asked.ask(&question));
        let answer = answer.map_err(|fault| self.program.failed(fault))?;
        executed(answer).map_err(|problem| self.program.failed(Fault::Broken(problem)))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        Ok(self.known()?.graph.clone())
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> Value {
        let mut told = self.held.told.to_json();
        told["names"] = json!(self.held.before);
        told["schema"] = json!(&*self.schema);
        told["half_turn"] = json!(self.schema.half_turn());
        told
    }
}
