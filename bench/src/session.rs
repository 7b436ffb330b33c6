//! The protocol of one run: teach the original task, change it, correct the model until it succeeds.
//!
//! Every random draw has a stream named by what it is for, and no name holds the method: every method meets the same starts, the
//! same noise of execution and the same teacher.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use situ::demonstration::{Demonstration, Kind, Schema};
use situ::edit::Edit;
use situ::method::{self, Learned, Method, Role};
use situ::random::stream;
use situ_tasks::{Episode, Setting};
use situ_teachers::{Teacher, convert};

use crate::archive::Archive;
use crate::correction::Robot;
use crate::demonstration_file::Before;
use crate::error::BenchError;
use crate::evaluation::{Evaluation, Until};
use crate::protocol::Protocol;
use crate::record::{Effort, Joint, Key, Outcome, Rate, Run, Stage};

/// Attempts at a demonstration before the teacher gives up: a novice fails about one in five, so this is one in hundreds.
const ATTEMPTS: u32 = 4;

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
#[derive(Clone)]
pub struct Taught {
    original: Arc<Setting>,
    pub(crate) demonstrations: Vec<Demonstration>,
    effort: Effort,
    rate: Rate,
    /// The round of the evaluation that gave the rate.
    round: u32,
    /// Whether the success rate reached the target.
    pub reached: bool,
}

impl Surroundings<'_> {
    pub(crate) fn stream(&self, setting: &Setting, what: &str, numbers: &[u32]) -> u64 {
        let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
        stream(self.seed, &format!("{}/{}/{what}/{}", setting.label(), self.teacher.profile().name, numbers.join("/")))
    }

    pub(crate) fn learner_seed(&self) -> u64 {
        stream(self.seed, "learner")
    }

    pub(crate) fn check_interrupt(&self) -> Result<(), BenchError> {
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
                    archive.write(
                        &format!("{}/full-{index}", self.folder(setting)),
                        &demonstration,
                        schema,
                        &Before::default(),
                    )?;
                }
                return Ok(Some((demonstration, effort_of(&shown.effort))));
            }
        }
        Ok(None)
    }

    /// The archive's folder for a setting.
    pub(crate) fn folder(&self, setting: &Setting) -> String {
        format!("{}/{}-seed-{}", setting.label(), self.teacher.profile().name, self.seed)
    }

    /// Teaches the original task: demonstrations until the success rate reaches the target, or the budget is used up.
    pub fn teach(&self, original: &Arc<Setting>, method: &dyn Method) -> Result<Taught, BenchError> {
        let schema = convert::schema(original)?;
        let mut taught = Taught {
            original: Arc::clone(original),
            demonstrations: Vec::new(),
            effort: Effort::default(),
            rate: Rate { successes: 0, rollouts: 0 },
            round: 0,
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
            taught.round = index;
            if self.is_reached(&evaluation) {
                taught.reached = true;
                break;
            }
        }
        Ok(taught)
    }

    /// The same lesson with the success rate of a method that makes a model of its own of it.
    pub fn taught_to(&self, taught: &Taught, method: &dyn Method) -> Result<Taught, BenchError> {
        if !taught.reached {
            return Ok(taught.clone());
        }
        let model = method.teach(&convert::schema(&taught.original)?, &taught.demonstrations, self.learner_seed())?;
        let rate = self.evaluate(&*model, &taught.original, taught.round, Until::Done)?.rate;
        Ok(Taught { rate, ..taught.clone() })
    }

    /// The original model on the changed task: what a method starts from. Nothing is rolled out where there is no such model.
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
        let mut run = begun(self.key(setting, method), taught);
        if !method.edits().contains(&run.key.edit) {
            run.outcome = Outcome::NotApplicable;
            return Ok(run);
        }
        if !taught.reached {
            return Ok(run);
        }
        run.before = Some(before.rate);
        let last = match method.role() {
            Role::Control => before.clone(),
            Role::Correct => {
                let folder = method.name().replace(':', "-");
                let mut robot = Robot::taught(self, &taught.original, method, taught, folder)?;
                let last = self.correct(&mut robot, setting, before, &mut run)?;
                run.retained = Some(self.retained(robot.model(), taught, !run.corrections.is_empty())?);
                run.structure = robot.structure();
                if !run.corrections.is_empty() && self.protocol.joint.iter().any(|name| name == method.name()) {
                    run.joint = Some(self.joint(&robot, setting, taught)?);
                }
                last
            }
            Role::FromScratch => self.taught_anew(setting, method, &mut run)?,
        };
        self.finish(&mut run, last);
        Ok(run)
    }

    /// The runs of one method on a sequence of settings, each with the model as the one before left it. Nothing for a method that is
    /// taught anew: it would meet each setting as if it were alone.
    pub fn run_sequence(
        &self,
        name: &str,
        settings: &[Arc<Setting>],
        method: &dyn Method,
        taught: &Taught,
    ) -> Result<Vec<Run>, BenchError> {
        if method.role() == Role::FromScratch {
            return Ok(Vec::new());
        }
        let mut runs = Vec::new();
        let mut robot = None;
        let mut corrected = false;
        for (index, setting) in settings.iter().enumerate() {
            let mut run = begun(self.stage_key(name, index, setting, method), taught);
            if taught.reached {
                let robot = match &mut robot {
                    Some(robot) => robot,
                    None => {
                        let folder = format!("{name}-{}", method.name().replace(':', "-"));
                        robot.insert(Robot::taught(self, &taught.original, method, taught, folder)?)
                    }
                };
                let before = self.evaluate(robot.model(), setting, 0, Until::Done)?;
                run.before = Some(before.rate);
                // What it cannot mend it is not corrected for; the model goes on to the next stage as it is.
                let is_applicable = method.edits().contains(&run.key.edit);
                let last = match method.role() {
                    _ if !is_applicable => before,
                    Role::Correct => self.correct(robot, setting, &before, &mut run)?,
                    Role::FromScratch | Role::Control => before,
                };
                corrected |= !run.corrections.is_empty();
                run.retained = Some(self.retained(robot.model(), taught, corrected)?);
                for earlier in &settings[..index] {
                    let evaluation = self.evaluate(robot.model(), earlier, 0, Until::Done)?;
                    run.earlier.insert(earlier.variation.clone().unwrap_or_default(), evaluation.rate);
                }
                self.finish(&mut run, last);
                if !is_applicable {
                    run.outcome = Outcome::NotApplicable;
                }
            }
            runs.push(run);
        }
        Ok(runs)
    }

    /// Success on the original task, from the starts at which it was learned. A model that was not corrected is as it was.
    fn retained(&self, model: &dyn Learned, taught: &Taught, corrected: bool) -> Result<Rate, BenchError> {
        if !corrected {
            return Ok(taught.rate);
        }
        Ok(self.evaluate(model, &taught.original, taught.round, Until::Done)?.rate)
    }

    /// The same lesson learned at once by full retraining. Both models meet starts by which no correction was called for or left out, or
    /// the corrected one, which was corrected until it succeeded, would be favoured.
    fn joint(&self, robot: &Robot<'_>, setting: &Arc<Setting>, taught: &Taught) -> Result<Joint, BenchError> {
        let (schema, seed) = (convert::schema(setting)?, self.learner_seed());
        let model = robot.lesson().taught_to(&*method::joint(), &schema, seed)?;
        let fresh = self.protocol.budget.corrections + 1;
        Ok(Joint {
            separate: self.evaluate(robot.model(), setting, fresh, Until::Done)?.rate,
            joint: self.evaluate(&*model, setting, fresh, Until::Done)?.rate,
            retained: self.retained(&*model, taught, true)?,
            structure: robot.lesson().score(&model.graph()),
        })
    }

    fn finish(&self, run: &mut Run, last: Evaluation) {
        run.outcome = match () {
            () if last.spoilt => Outcome::Spoilt { why: "a rollout's physics was no longer sound".to_owned() },
            () if self.is_reached(&last) => Outcome::Reached,
            () => Outcome::Censored,
        };
        run.after = Some(last.rate);
        run.ended = last.ended;
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
            stage: None,
        }
    }

    /// The name of a run that is a stage of a sequence.
    pub fn stage_key(&self, sequence: &str, index: usize, setting: &Setting, method: &dyn Method) -> Key {
        let stage = Stage { sequence: sequence.to_owned(), number: index as u32 + 1 };
        Key { stage: Some(stage), ..self.key(setting, method) }
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

/// A run of which nothing is known but what teaching the original task took.
fn begun(key: Key, taught: &Taught) -> Run {
    Run {
        key,
        outcome: Outcome::Untaught,
        original: taught.effort,
        before: None,
        after: None,
        effort: Effort::default(),
        corrections: Vec::new(),
        ended: BTreeMap::new(),
        original_rate: Some(taught.rate),
        retained: None,
        structure: None,
        joint: None,
        earlier: BTreeMap::new(),
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

pub(crate) fn effort_of(effort: &situ_teachers::Effort) -> Effort {
    Effort { demonstrations: 1, keyframes: effort.keyframes, seconds: effort.seconds, metres: effort.metres }
}
