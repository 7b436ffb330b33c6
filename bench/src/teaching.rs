//! Teaching by whole demonstrations: the original task to all methods, and the changed task to those that learn it
//! anew.

use std::sync::Arc;

use situ::demonstration::{Demonstration, Kind};
use situ::method::{Learned, Method, Original};
use situ_tasks::{Episode, Setting, TaskError};
use situ_teachers::Shown;

use crate::conditions::Conditions;
use crate::demonstration_file::Before;
use crate::error::BenchError;
use crate::evaluation::{Evaluation, Until};
use crate::record::{Rate, TotalEffort};
use crate::spending::Steps;

/// Attempts at a demonstration before the teacher gives up. A novice fails about one in five, so all of them fail once
/// in hundreds.
pub(crate) const ATTEMPTS: u32 = 4;

/// An original task as the robot of one seed was taught it.
#[derive(Clone)]
pub struct OriginalTask {
    pub(crate) setting: Arc<Setting>,
    pub(crate) demonstrations: Vec<Demonstration>,
    /// The effort of teaching it.
    pub(crate) effort: TotalEffort,
    /// Success of the model that it led to.
    pub(crate) rate: Rate,
    /// The round of the evaluation that gave the rate.
    pub(crate) round: u32,
    /// The model, which every method with the same original takes over; `None` where the success rate did not reach the
    /// target.
    pub(crate) original: Option<Original>,
}

impl Conditions<'_> {
    /// Teaches the original task: demonstrations until the success rate reaches the target, or the budget is used up.
    ///
    /// # Errors
    /// An error of the task, the teacher or the method; [`BenchError::Interrupted`].
    pub fn teach(&self, original: &Arc<Setting>, method: &dyn Method) -> Result<OriginalTask, BenchError> {
        let mut task = OriginalTask {
            setting: Arc::clone(original),
            demonstrations: Vec::new(),
            effort: TotalEffort::default(),
            rate: Rate::default(),
            round: 0,
            original: None,
        };
        let budget = self.protocol.budget;
        for index in 0..budget.originals {
            let Some((demonstration, effort)) = self.demonstrate(original, index)? else { break };
            task.demonstrations.push(demonstration);
            task.effort += effort;
            if index + 1 < budget.least_originals {
                continue;
            }
            let learn = || method.learn_original(self.schema, &task.demonstrations, self.learner_seed());
            let model = self.spend(learn, |_| Steps::default())?;
            let evaluation = self.evaluate(&*method.take_over(&model)?, original, index, Until::OutOfReach)?;
            task.rate = evaluation.rate;
            task.round = index;
            if self.is_reached(&evaluation) {
                task.original = Some(model);
                break;
            }
        }
        Ok(task)
    }

    /// The same demonstrations, with the success rate of a method that makes a model of its own of them.
    ///
    /// # Errors
    /// As [`Conditions::teach`].
    pub fn taught_to(&self, task: &OriginalTask, method: &dyn Method) -> Result<OriginalTask, BenchError> {
        if task.original.is_none() {
            return Ok(task.clone());
        }
        let original = method.learn_original(self.schema, &task.demonstrations, self.learner_seed())?;
        let rate = self.evaluate(&*method.take_over(&original)?, &task.setting, task.round, Until::Done)?.rate;
        Ok(OriginalTask { rate, original: Some(original), ..task.clone() })
    }

    /// Teaches the changed task to a method that takes no corrections. The effort is added to `spent`. Returns the
    /// last evaluation.
    pub(crate) fn teach_anew(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        spent: &mut TotalEffort,
    ) -> Result<Evaluation, BenchError> {
        let budget = self.protocol.budget.from_scratch;
        let mut demonstrations = Vec::new();
        let mut last = Evaluation::none(self.protocol.rollouts);
        for index in 0..budget {
            let Some((demonstration, effort)) = self.demonstrate(setting, index)? else {
                if !demonstrations.is_empty() {
                    let model = self.learned(method, &demonstrations)?;
                    last = self.evaluate(&*model, setting, index, Until::Done)?;
                }
                break;
            };
            demonstrations.push(demonstration);
            *spent += effort;
            let model = self.learned(method, &demonstrations)?;
            last = self.evaluate(&*model, setting, index + 1, self.until(index, budget))?;
            if self.is_reached(&last) {
                break;
            }
        }
        Ok(last)
    }

    /// A method's model of whole demonstrations.
    pub(crate) fn learned(
        &self,
        method: &dyn Method,
        demonstrations: &[Demonstration],
    ) -> Result<Box<dyn Learned>, BenchError> {
        let learn = || method.teach(self.schema, demonstrations, self.learner_seed());
        Ok(self.spend(learn, |_| Steps::default())?)
    }

    /// What the teacher shows from where the episode stands.
    pub(crate) fn demonstrated(
        &self,
        name: &str,
        kind: Kind,
        mut episode: Episode,
        seed: u64,
    ) -> Result<Shown, BenchError> {
        let before = episode.steps();
        let show = || {
            let shown = self.teacher.demonstrate(name, kind, self.schema, &mut episode, seed, &mut |_| {});
            (shown, episode.steps())
        };
        let (shown, _) = self.spend(show, |(_, after)| Steps { simulated: after - before, replayed: 0 });
        Ok(shown?)
    }

    /// One whole demonstration of the setting. An attempt that fails is repeated from another start. `None` where the
    /// teacher gives up.
    fn demonstrate(
        &self,
        setting: &Arc<Setting>,
        index: u32,
    ) -> Result<Option<(Demonstration, TotalEffort)>, BenchError> {
        for attempt in 0..ATTEMPTS {
            self.check_interrupt()?;
            let start = || Episode::start(setting, self.stream(setting, "teach", &[index, attempt]));
            let steps = |episode: &Result<Episode, TaskError>| Steps {
                simulated: episode.as_ref().map_or(0, Episode::steps),
                replayed: 0,
            };
            let episode = self.spend(start, steps)?;
            let seed = self.stream(setting, "teacher", &[index, attempt]);
            let name = format!("{}-{index}", setting.label());
            let shown = self.demonstrated(&name, Kind::Original, episode, seed)?;
            if let (true, Some(demonstration)) = (shown.clean, shown.demonstration) {
                if let Some(archive) = self.archive {
                    let path = format!("{}/full-{index}", self.folder(setting));
                    archive.write(&path, &demonstration, self.schema, &Before::default())?;
                }
                return Ok(Some((demonstration, TotalEffort::from(&shown.effort))));
            }
        }
        Ok(None)
    }
}
