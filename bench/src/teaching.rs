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
use crate::evaluation::Evaluation;
use crate::spending::Steps;
use crate::tally::{Rate, TotalEffort};

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
    /// Success of the model that it led to, from fresh starts; `None` where there is no such model.
    pub(crate) rate: Option<Rate>,
    /// The model, which every method with the same original takes over; or why there is none.
    pub(crate) original: Result<Original, String>,
}

impl OriginalTask {
    /// One that nobody could teach.
    pub(crate) fn untaught(setting: &Arc<Setting>, why: &str) -> Self {
        Self {
            setting: Arc::clone(setting),
            demonstrations: Vec::new(),
            effort: TotalEffort::default(),
            rate: None,
            original: Err(why.to_owned()),
        }
    }
}

/// What a demonstration is for. It names the streams of its draws.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// A robot is given it.
    Teach,
    /// Models are held against it.
    HoldOut,
}

impl Purpose {
    /// The stream of the starts.
    const fn start(self) -> &'static str {
        match self {
            Self::Teach => "teach",
            Self::HoldOut => "hold-out",
        }
    }

    /// The stream of the teacher's errors.
    const fn teacher(self) -> &'static str {
        match self {
            Self::Teach => "teacher",
            Self::HoldOut => "hold-out-teacher",
        }
    }
}

/// What came of the tries at one demonstration.
struct Tried {
    /// The one that the robot is given; `None` where the teacher gives up.
    demonstration: Option<Demonstration>,
    /// The effort of all of them.
    effort: TotalEffort,
}

/// A model that was taught the changed task alone.
pub(crate) struct TaughtAnew {
    /// The model; `None` where the teacher could not show the task once.
    pub(crate) model: Option<Box<dyn Learned>>,
    /// The demonstrations that it was taught.
    pub(crate) demonstrations: Vec<Demonstration>,
    /// The evaluation that decided that it is the last.
    pub(crate) last: Evaluation,
    /// Whether the teacher gave up.
    pub(crate) gave_up: bool,
}

impl Conditions<'_> {
    /// Teaches the original task: demonstrations until the success rate reaches the target, or the budget is used up.
    ///
    /// # Errors
    /// An error of the task, the teacher or the method; [`BenchError::Interrupted`].
    pub fn teach(&self, original: &Arc<Setting>, method: &dyn Method) -> Result<OriginalTask, BenchError> {
        let mut task = OriginalTask::untaught(original, "");
        let budget = self.protocol.budget;
        let mut last = Evaluation::none(0);
        for index in 0..budget.originals {
            let Tried { demonstration, effort } = self.demonstrate(original, index, Purpose::Teach)?;
            task.effort += effort;
            let Some(demonstration) = demonstration else {
                let given = task.demonstrations.len();
                task.original = Err(format!("{ATTEMPTS} tries failed in a row, after {given} demonstrations"));
                return Ok(task);
            };
            task.demonstrations.push(demonstration);
            if index + 1 < budget.least_originals {
                continue;
            }
            let learn = || method.learn_original(self.schema, &task.demonstrations, self.learner_seed());
            let model = self.spend(learn, |_| Steps::default())?;
            let learned = method.take_over(&model)?;
            last = self.decide(&*learned, original, index)?;
            if self.is_reached(&last) {
                task.rate = Some(self.evaluate(&*learned, original)?.rate);
                task.original = Ok(model);
                return Ok(task);
            }
        }
        let Rate { successes, rollouts, .. } = last.rate;
        task.original = Err(format!("{successes} of {rollouts} rollouts after {} demonstrations", budget.originals));
        Ok(task)
    }

    /// The same demonstrations, with the success rate of a method that makes a model of its own of them.
    ///
    /// # Errors
    /// As [`Conditions::teach`].
    pub fn taught_to(&self, task: &OriginalTask, method: &dyn Method) -> Result<OriginalTask, BenchError> {
        if task.original.is_err() {
            return Ok(task.clone());
        }
        let original = method.learn_original(self.schema, &task.demonstrations, self.learner_seed())?;
        let rate = self.evaluate(&*method.take_over(&original)?, &task.setting)?.rate;
        Ok(OriginalTask { rate: Some(rate), original: Ok(original), ..task.clone() })
    }

    /// Teaches the changed task to a method that takes no corrections. The effort is added to `spent`.
    pub(crate) fn teach_anew(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        spent: &mut TotalEffort,
    ) -> Result<TaughtAnew, BenchError> {
        let mut taught = TaughtAnew {
            model: None,
            demonstrations: Vec::new(),
            last: Evaluation::none(self.protocol.rollouts),
            gave_up: false,
        };
        for index in 0..self.protocol.budget.demonstrations {
            let Tried { demonstration, effort } = self.demonstrate(setting, index, Purpose::Teach)?;
            *spent += effort;
            let Some(demonstration) = demonstration else {
                taught.gave_up = true;
                break;
            };
            taught.demonstrations.push(demonstration);
            let model = self.learned(method, &taught.demonstrations)?;
            taught.last = self.decide(&*model, setting, index + 1)?;
            taught.model = Some(model);
            if self.is_reached(&taught.last) {
                break;
            }
        }
        Ok(taught)
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

    /// A demonstration of the setting that no method is given; `None` where the teacher gives up.
    pub(crate) fn held_out(&self, setting: &Arc<Setting>) -> Result<Option<Demonstration>, BenchError> {
        Ok(self.demonstrate(setting, 0, Purpose::HoldOut)?.demonstration)
    }

    /// The effort of the first whole demonstration that a robot is given, all tries.
    pub(crate) fn effort_of_first(&self, setting: &Arc<Setting>) -> Result<TotalEffort, BenchError> {
        Ok(self.demonstrate(setting, 0, Purpose::Teach)?.effort)
    }

    /// One whole demonstration of the setting. A try that fails is repeated from another start.
    fn demonstrate(&self, setting: &Arc<Setting>, index: u32, purpose: Purpose) -> Result<Tried, BenchError> {
        let mut tried = Tried { demonstration: None, effort: TotalEffort::default() };
        for attempt in 0..ATTEMPTS {
            self.check_interrupt()?;
            let start = || Episode::start(setting, self.stream(setting, purpose.start(), &[index, attempt]));
            let steps = |episode: &Result<Episode, TaskError>| Steps {
                simulated: episode.as_ref().map_or(0, Episode::steps),
                replayed: 0,
            };
            let episode = self.spend(start, steps)?;
            let seed = self.teacher_stream(setting, purpose.teacher(), &[index, attempt]);
            let name = format!("{}-{index}", setting.label());
            let shown = self.demonstrated(&name, Kind::Original, episode, seed)?;
            tried.demonstration = shown.demonstration.filter(|_| shown.clean);
            tried.effort += TotalEffort::of_try(&shown.effort, tried.demonstration.is_some());
            if let Some(demonstration) = &tried.demonstration {
                if let (Some(archive), Purpose::Teach) = (self.archive, purpose) {
                    let path = format!("{}/full-{index}", self.folder(setting));
                    archive.write(&path, demonstration, self.schema, &Before::default())?;
                }
                break;
            }
        }
        Ok(tried)
    }
}
