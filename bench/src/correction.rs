//! Correcting a robot: it fails, a teacher steps in, the method folds the correction in, until the task succeeds.

use std::collections::BTreeSet;
use std::sync::Arc;

use situ::correction::{Correction as Corrected, Told};
use situ::demonstration::{Demonstration, Kind, Schema};
use situ::edit::difference;
use situ::method::{Learned, Method};
use situ::place::{NodeId, Place};
use situ::structure::Structure;
use situ_tasks::{Episode, EpisodeSnapshot, Setting, Skill};
use situ_teachers::{Onset, convert};

use crate::cost;
use crate::error::BenchError;
use crate::evaluation::{Evaluation, Until};
use crate::lesson::Lesson;
use crate::record::{Correction, Effort, Run};
use crate::rollout::{Ended, Rollout, Watched, rollout};
use crate::session::{Surroundings, Taught, effort_of};

/// Attempts at a correction before the teacher gives up: a novice fails about one in five, so this is one in hundreds.
const ATTEMPTS: u32 = 4;

/// A robot under correction: its task model, and what it was shown.
pub struct Robot<'a> {
    method: &'a dyn Method,
    model: Box<dyn Learned>,
    lesson: Lesson,
    /// The archive's folder for its corrections, below that of the setting.
    folder: String,
}

/// A failure, as the teacher finds it.
struct Failure {
    snapshot: EpisodeSnapshot,
    trigger: String,
    last: Place,
    last_reference: Option<String>,
    interrupted: Option<NodeId>,
}

impl<'a> Robot<'a> {
    /// A robot that was taught the original task. `folder` names its corrections in an archive.
    ///
    /// # Errors
    /// Where the method cannot learn the demonstrations.
    pub fn taught(
        surroundings: &Surroundings<'_>,
        original: &Setting,
        method: &'a dyn Method,
        taught: &Taught,
        folder: String,
    ) -> Result<Self, BenchError> {
        let model = method.teach(&convert::schema(original)?, &taught.demonstrations, surroundings.learner_seed())?;
        Ok(Self { method, model, lesson: Lesson::new(method, &taught.demonstrations), folder })
    }

    /// Its task model.
    pub fn model(&self) -> &dyn Learned {
        &*self.model
    }

    /// What it was shown.
    pub fn lesson(&self) -> &Lesson {
        &self.lesson
    }

    /// How far its structure is what the teacher meant.
    pub fn structure(&self) -> Option<Structure> {
        self.lesson.score(&self.model.graph())
    }
}

impl Surroundings<'_> {
    /// Corrects the robot on a setting until the target is reached or the budget is used up, `before` being its evaluation there.
    /// What it took is added to the run. Returns the last evaluation.
    pub fn correct(
        &self,
        robot: &mut Robot<'_>,
        setting: &Arc<Setting>,
        before: &Evaluation,
        run: &mut Run,
    ) -> Result<Evaluation, BenchError> {
        let schema = convert::schema(setting)?;
        let budget = self.protocol.budget.corrections;
        let mut last = before.clone();
        let mut told = Told { changed: changed(setting) };
        for round in 0..budget {
            if self.is_reached(&last) {
                break;
            }
            let Some((failure, demonstration, effort)) =
                self.correction(robot.model(), setting, &schema, &last, round)?
            else {
                // No failure from which this teacher can still show the way: more corrections will not come.
                last = self.evaluate(robot.model(), setting, round, Until::Done)?;
                break;
            };
            let graph = robot.model.graph();
            if let Some(archive) = self.archive {
                let path = format!("{}/{}-correction-{round}", self.folder(setting), robot.folder);
                let before = robot.lesson.before(&graph, failure.last, failure.interrupted);
                archive.write(&path, &demonstration, &schema, &before)?;
            }
            let met = Corrected {
                interrupted: failure.interrupted,
                told: Some(&told),
                ..Corrected::after(failure.last, &demonstration)
            };
            let (trace, update_seconds) = cost::timed(|| robot.model.correct(met));
            let trace = trace?;
            for name in demonstration.keyframes().iter().filter_map(|keyframe| keyframe.narration.as_ref()) {
                told.changed.remove(name);
            }
            robot.lesson.corrected(robot.method, &graph, failure.last, failure.interrupted, demonstration);
            let made = difference(&graph, &robot.model.graph());
            last = self.evaluate(robot.model(), setting, round + 1, self.until(round, budget))?;
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

    /// The same rollout again, with the teacher watching: the failure, as the teacher finds it, who may come too early or too late.
    fn watch(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        index: u32,
    ) -> Result<Option<Failure>, BenchError> {
        let watch = |watched| -> Result<Option<(Episode, Rollout)>, BenchError> {
            let Some(mut episode) = self.start(setting, round, index)? else { return Ok(None) };
            let (execute, mut rng) = self.execution(setting, round, index, watched);
            let rollout = rollout(model, &mut episode, execute, &mut rng, &mut |_| {})?;
            Ok(Some((episode, rollout)))
        };
        let onset = self.teacher.onset(self.stream(setting, "onset", &[round, index]));
        let Some((mut episode, mut rollout)) = watch(Watched::AfterMissing(u32::from(onset == Onset::Late)))? else {
            return Ok(None);
        };
        // The primitive before the one in which it went wrong: the robot begins anew and is stopped there.
        if let (Onset::Early, Some(last)) = (onset, rollout.primitives.len().checked_sub(1))
            && let Some(early) = watch(Watched::UntilPrimitive(last))?
        {
            (episode, rollout) = early;
        }
        if rollout.success || rollout.ended == Ended::Spoilt {
            return Ok(None);
        }
        let trigger = if rollout.ended == Ended::End { "wrong outcome".to_owned() } else { rollout.ended.to_string() };
        let snapshot = episode.snapshot();
        let Rollout { last, last_reference, interrupted, .. } = rollout;
        Ok(Some(Failure { snapshot, trigger, last, last_reference, interrupted }))
    }
}

/// The skills that a setting does in another way than the original task.
fn changed(setting: &Setting) -> BTreeSet<Arc<str>> {
    let is_changed = |skill: &&Skill| {
        let original = setting.original_skills.iter().find(|original| original.name == skill.name);
        original.is_some_and(|original| original.keyframes != skill.keyframes)
    };
    setting.skills.iter().filter(is_changed).map(|skill| skill.name.as_str().into()).collect()
}
