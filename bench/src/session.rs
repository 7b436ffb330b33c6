//! The protocol of one run: teach the original task, change it, correct the model until it succeeds.
//!
//! Every random draw has a stream named by what it is for, and no name holds the method: every method meets the same starts, the
//! same noise of execution and the same teacher.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use situ::demonstration::{Demonstration, Kind, Schema};
use situ::edit::{Edit, difference};
use situ::graph::Graph;
use situ::method::{Learned, Method, Role};
use situ::place::Place;
use situ::random::stream;
use situ_tasks::{Episode, EpisodeSnapshot, Setting, TaskError};
use situ_teachers::{Teacher, convert};

use crate::archive::Archive;
use crate::cost;
use crate::demonstration_file::After;
use crate::error::BenchError;
use crate::protocol::Protocol;
use crate::record::{Correction, Effort, Key, Outcome, Rate, Run};
use crate::rollout::{Ended, Execute, Rollout, rollout};

/// Attempts at a demonstration before the teacher gives up: a novice fails about one in five, so this is one in hundreds.
const ATTEMPTS: u32 = 4;

/// Rollouts between two looks at whether the target is out of reach. Fixed, so that no number of threads changes what is rolled out.
const BATCH: usize = 4;

/// How long an evaluation goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// All rollouts of the protocol: what is published.
    Done,
    /// Until the target is out of reach: between corrections.
    OutOfReach,
}

/// What a run needs to know of its surroundings.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The protocol.
    pub protocol: &'a Protocol,
    /// The teacher.
    pub teacher: &'a Teacher,
    /// The seed of the run: root of all its streams.
    pub seed: u64,
    /// Set when the user wants to stop.
    pub interrupted: &'a AtomicBool,
    /// Where the demonstrations that are handed in are written, if anywhere.
    pub archive: Option<&'a Archive>,
}

/// An original task as it was taught to one seed's robot.
pub struct Taught {
    demonstrations: Vec<Demonstration>,
    effort: Effort,
    rate: Rate,
    /// Whether the success rate reached the target.
    pub reached: bool,
}

/// A model's rollouts on a setting.
#[derive(Clone)]
pub struct Evaluation {
    rate: Rate,
    ended: BTreeMap<String, u32>,
    failures: Vec<u32>,
    spoilt: bool,
}

impl Evaluation {
    /// No success in so many rollouts.
    fn none(rollouts: u32) -> Self {
        Self { rate: Rate { successes: 0, rollouts }, ended: BTreeMap::new(), failures: Vec::new(), spoilt: false }
    }

    /// Counts a rollout; `None` is one whose start the physics refused.
    fn count(&mut self, index: u32, rollout: Option<Rollout>) {
        self.rate.rollouts += 1;
        let Some(rollout) = rollout.filter(|rollout| rollout.ended != Ended::Spoilt) else {
            self.spoilt = true;
            return;
        };
        let how = if rollout.success { "success".to_owned() } else { format!("failure: {}", rollout.ended) };
        *self.ended.entry(how).or_default() += 1;
        if rollout.success {
            self.rate.successes += 1;
        } else {
            self.failures.push(index);
        }
    }
}

/// A failure, as the teacher finds it.
struct Failure {
    snapshot: EpisodeSnapshot,
    trigger: String,
    last: Place,
    last_reference: Option<String>,
}

impl Surroundings<'_> {
    fn stream(&self, setting: &Setting, what: &str, numbers: &[u32]) -> u64 {
        let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
        stream(self.seed, &format!("{}/{}/{what}/{}", setting.label(), self.teacher.profile().name, numbers.join("/")))
    }

    fn learner_seed(&self) -> u64 {
        stream(self.seed, "learner")
    }

    fn check_interrupt(&self) -> Result<(), BenchError> {
        if self.interrupted.load(Ordering::Relaxed) { Err(BenchError::Interrupted) } else { Ok(()) }
    }

    /// One full demonstration of the setting; attempts that fail are repeated from another start. `None` where the teacher gives up.
    fn demonstrate(
        &self,
        setting: &Arc<Setting>,
        schema: &Schema,
        index: u32,
    ) -> Result<Option<(Demonstration, Effort)>, BenchError> {
        for attempt in 0..ATTEMPTS {
            self.check_interrupt()?;
            let mut episode = Episode::start(setting, self.stream(setting, "teach", &[index, attempt]))?;
            let seed = self.stream(setting, "teacher", &[index, attempt]);
            let name = format!("{}-{index}", setting.label());
            let shown = self.teacher.demonstrate(&name, Kind::Original, schema, &mut episode, seed, &mut |_| {})?;
            if let (true, Some(demonstration)) = (shown.clean, shown.demonstration) {
                if let Some(archive) = self.archive {
                    archive.write(&format!("{}/full-{index}", self.folder(setting)), &demonstration, schema, None)?;
                }
                return Ok(Some((demonstration, effort_of(&shown.effort))));
            }
        }
        Ok(None)
    }

    /// The archive's folder for a setting.
    fn folder(&self, setting: &Setting) -> String {
        format!("{}/{}-seed-{}", setting.label(), self.teacher.profile().name, self.seed)
    }

    /// Rolls the model out from fresh starts; `round` names them. An evaluation `until` the target is out of reach stops after the
    /// batch in which that became certain: enough to know that the model must be corrected further, not to say how well it does.
    pub fn evaluate(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        until: Until,
    ) -> Result<Evaluation, BenchError> {
        let mut evaluation = Evaluation::none(0);
        let indices: Vec<u32> = (0..self.protocol.rollouts).collect();
        for batch in indices.chunks(BATCH) {
            let rollouts = batch.par_iter().map(|index| {
                self.check_interrupt()?;
                let Some(mut episode) = self.start(setting, round, *index)? else { return Ok(None) };
                let (execute, mut rng) = self.execution(setting, round, *index, false);
                rollout(model, &mut episode, execute, &mut rng, &mut |_| {}).map(Some)
            });
            let rollouts: Vec<Option<_>> = rollouts.collect::<Result<_, BenchError>>()?;
            for (index, rollout) in batch.iter().zip(rollouts) {
                evaluation.count(*index, rollout);
            }
            if until == Until::OutOfReach && !self.is_within_reach(&evaluation) {
                break;
            }
        }
        Ok(evaluation)
    }

    /// Whether the target is still met if every rollout that is left succeeds.
    fn is_within_reach(&self, evaluation: &Evaluation) -> bool {
        let failures = evaluation.rate.rollouts - evaluation.rate.successes;
        f64::from(self.protocol.rollouts - failures) >= self.protocol.target * f64::from(self.protocol.rollouts)
    }

    /// The start of a rollout; `None` where the physics refuses it: spoilt, nobody's failure.
    fn start(&self, setting: &Arc<Setting>, round: u32, index: u32) -> Result<Option<Episode>, BenchError> {
        match Episode::start(setting, self.stream(setting, "evaluate", &[round, index])) {
            Ok(episode) => Ok(Some(episode)),
            Err(TaskError::Premise { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn execution(&self, setting: &Setting, round: u32, index: u32, watched: bool) -> (Execute, ChaCha8Rng) {
        let execute = Execute { execution: self.protocol.execution, confidence: self.protocol.confidence, watched };
        (execute, ChaCha8Rng::seed_from_u64(self.stream(setting, "execute", &[round, index])))
    }

    /// The same rollout again, with the teacher watching: the failure, as the teacher finds it.
    fn watch(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        index: u32,
    ) -> Result<Option<Failure>, BenchError> {
        let Some(mut episode) = self.start(setting, round, index)? else { return Ok(None) };
        let (execute, mut rng) = self.execution(setting, round, index, true);
        let rollout = rollout(model, &mut episode, execute, &mut rng, &mut |_| {})?;
        if rollout.success || rollout.ended == Ended::Spoilt {
            return Ok(None);
        }
        let trigger = if rollout.ended == Ended::End { "wrong outcome".to_owned() } else { rollout.ended.to_string() };
        let snapshot = episode.snapshot();
        Ok(Some(Failure { snapshot, trigger, last: rollout.last, last_reference: rollout.last_reference }))
    }

    fn is_reached(&self, evaluation: &Evaluation) -> bool {
        f64::from(evaluation.rate.successes) >= self.protocol.target * f64::from(evaluation.rate.rollouts)
    }

    /// The evaluation after the last demonstration of a budget is whole.
    fn until(&self, index: u32, budget: u32) -> Until {
        if index + 1 == budget { Until::Done } else { Until::OutOfReach }
    }

    /// Teaches the original task: demonstrations until the success rate reaches the target, or the budget is used up.
    pub fn teach(&self, original: &Arc<Setting>, method: &dyn Method) -> Result<Taught, BenchError> {
        let schema = convert::schema(original)?;
        let mut taught = Taught {
            demonstrations: Vec::new(),
            effort: Effort::default(),
            rate: Rate { successes: 0, rollouts: 0 },
            reached: false,
        };
        let budget = self.protocol.budget;
        for index in 0..budget.originals {
            let Some((demonstration, effort)) = self.demonstrate(original, &schema, index)? else { break };
            taught.demonstrations.push(demonstration);
            taught.effort += effort;
            if index + 1 < budget.least_originals {
                continue;
            }
            let model = method.teach(&schema, &taught.demonstrations, self.learner_seed())?;
            let evaluation = self.evaluate(&*model, original, index, Until::OutOfReach)?;
            taught.rate = evaluation.rate;
            if self.is_reached(&evaluation) {
                taught.reached = true;
                break;
            }
        }
        Ok(taught)
    }

    /// The original model on the changed task: what every method starts from. Nothing is rolled out where there is no such model.
    pub fn before(
        &self,
        taught: &Taught,
        setting: &Arc<Setting>,
        method: &dyn Method,
    ) -> Result<Evaluation, BenchError> {
        if !taught.reached {
            return Ok(Evaluation::none(0));
        }
        let model = method.teach(&convert::schema(setting)?, &taught.demonstrations, self.learner_seed())?;
        self.evaluate(&*model, setting, 0, Until::Done)
    }

    /// A run of one method on one setting.
    pub fn run(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        taught: &Taught,
        before: &Evaluation,
    ) -> Result<Run, BenchError> {
        let mut run = Run {
            key: self.key(setting, method),
            outcome: Outcome::Censored,
            original: taught.effort,
            before: Some(before.rate),
            after: None,
            effort: Effort::default(),
            corrections: Vec::new(),
            ended: BTreeMap::new(),
            original_rate: Some(taught.rate),
            retained: None,
        };
        if !taught.reached {
            return Ok(Run { outcome: Outcome::Untaught, before: None, ..run });
        }
        let last = match method.role() {
            Role::Control => before.clone(),
            Role::Correct => self.correct(setting, method, taught, before, &mut run)?,
            Role::FromScratch => self.taught_anew(setting, method, &mut run)?,
        };
        run.outcome = match () {
            () if last.spoilt => Outcome::Spoilt { why: "a rollout's physics was no longer sound".to_owned() },
            () if self.is_reached(&last) => Outcome::Reached,
            () => Outcome::Censored,
        };
        run.after = Some(last.rate);
        run.ended = last.ended;
        Ok(run)
    }

    /// The name of a run.
    pub fn key(&self, setting: &Setting, method: &dyn Method) -> Key {
        Key {
            protocol: self.protocol.name.clone(),
            task: setting.task.clone(),
            variation: setting.variation.clone().unwrap_or_default(),
            edit: needed(setting),
            teacher: self.teacher.profile().name.clone(),
            method: method.name().to_owned(),
            seed: self.seed,
        }
    }

    fn correct(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        taught: &Taught,
        before: &Evaluation,
        run: &mut Run,
    ) -> Result<Evaluation, BenchError> {
        let schema = convert::schema(setting)?;
        let mut model = method.teach(&schema, &taught.demonstrations, self.learner_seed())?;
        let mut last = before.clone();
        let mut names = Names::of(&taught.demonstrations);
        for round in 0..self.protocol.budget.corrections {
            if self.is_reached(&last) {
                break;
            }
            let Some((failure, demonstration, effort)) = self.correction(&*model, setting, &schema, &last, round)?
            else {
                // No failure from which this teacher can still show the way: more corrections will not come.
                last = self.evaluate(&*model, setting, round, Until::Done)?;
                break;
            };
            let graph = model.graph();
            if let Some(archive) = self.archive {
                let path = format!("{}/{}-correction-{round}", self.folder(setting), method.name().replace(':', "-"));
                archive.write(&path, &demonstration, &schema, names.after(&graph, failure.last).as_ref())?;
            }
            names.learned(&demonstration);
            let (trace, update_seconds) = cost::timed(|| model.correct(failure.last, &demonstration));
            let trace = trace?;
            let made = difference(&graph, &model.graph());
            last = self.evaluate(&*model, setting, round + 1, self.until(round, self.protocol.budget.corrections))?;
            run.effort += effort;
            let last_reference = failure.last_reference.unwrap_or_else(|| "START".to_owned());
            let correction = Correction::new(failure.trigger, last_reference, effort, &made, &trace, update_seconds);
            run.corrections.push(Correction { after: Some(last.rate), ..correction });
        }
        Ok(last)
    }

    /// The first failure of the last evaluation from which the teacher manages to show the way, and what was shown.
    fn correction(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        schema: &Schema,
        last: &Evaluation,
        round: u32,
    ) -> Result<Option<(Failure, Demonstration, Effort)>, BenchError> {
        for index in &last.failures {
            self.check_interrupt()?;
            let Some(failure) = self.watch(model, setting, round, *index)? else { continue };
            for attempt in 0..ATTEMPTS {
                let mut episode = Episode::restore(&failure.snapshot);
                let seed = self.stream(setting, "correct", &[round, *index, attempt]);
                let name = format!("{}-correction-{round}", setting.label());
                let shown =
                    self.teacher.demonstrate(&name, Kind::Corrective, schema, &mut episode, seed, &mut |_| {})?;
                if let (true, Some(demonstration)) = (shown.clean, shown.demonstration) {
                    return Ok(Some((failure, demonstration, effort_of(&shown.effort))));
                }
            }
        }
        Ok(None)
    }

    fn taught_anew(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        run: &mut Run,
    ) -> Result<Evaluation, BenchError> {
        let schema = convert::schema(setting)?;
        let mut demonstrations = Vec::new();
        let mut last = Evaluation::none(self.protocol.rollouts);
        for index in 0..self.protocol.budget.from_scratch {
            let Some((demonstration, effort)) = self.demonstrate(setting, &schema, index)? else {
                if !demonstrations.is_empty() {
                    let model = method.teach(&schema, &demonstrations, self.learner_seed())?;
                    last = self.evaluate(&*model, setting, index, Until::Done)?;
                }
                break;
            };
            demonstrations.push(demonstration);
            run.effort += effort;
            let model = method.teach(&schema, &demonstrations, self.learner_seed())?;
            last = self.evaluate(&*model, setting, index + 1, self.until(index, self.protocol.budget.from_scratch))?;
            if self.is_reached(&last) {
                break;
            }
        }
        Ok(last)
    }
}

/// The names of a model's demonstrations, in the order in which it learned them.
struct Names(Vec<Arc<str>>);

impl Names {
    fn of(demonstrations: &[Demonstration]) -> Self {
        Self(demonstrations.iter().map(|demonstration| demonstration.name().clone()).collect())
    }

    fn learned(&mut self, demonstration: &Demonstration) {
        self.0.push(demonstration.name().clone());
    }

    /// What ran last before a correction, in the words of a demonstration file.
    fn after(&self, graph: &Graph, last: Place) -> Option<After> {
        let Place::Node(id) = last else { return None };
        let segment = graph.nodes.iter().find(|node| node.id == id)?.segments.first()?;
        let demonstration = self.0.get(segment.demonstration as usize)?.to_string();
        Some(After { demonstration, segment: segment.index })
    }
}

/// The edit that a setting says it needs, in the learner's words.
pub fn needed(setting: &Setting) -> Edit {
    match setting.edit {
        situ_tasks::Edit::NodeAddition => Edit::NodeAddition,
        situ_tasks::Edit::EdgeAddition => Edit::EdgeAddition,
        situ_tasks::Edit::NodeModification => Edit::NodeModification,
        situ_tasks::Edit::None => Edit::None,
    }
}

fn effort_of(effort: &situ_teachers::Effort) -> Effort {
    Effort { demonstrations: 1, keyframes: effort.keyframes, seconds: effort.seconds, metres: effort.metres }
}
