//! How a teacher does, whatever is learned of it: whole demonstrations, corrections from where the original script
//! fails, and whether a model of the original task needs no edit where a task file says so.

use std::sync::Arc;

use situ::demonstration::Kind;
use situ::method;
use situ_tasks::script::{self, Ending};
use situ_tasks::{Episode, Setting};

use crate::conditions::Conditions;
use crate::error::BenchError;
use crate::tally::{Rate, TotalEffort};
use crate::teaching::ATTEMPTS;

/// Success of one model of the original task, from fresh starts: there, and in changed tasks.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorbed {
    /// In the original task.
    pub original: Rate,
    /// In each changed task; `None` where the physics of a rollout was no longer sound.
    pub changed: Vec<Option<Rate>>,
}

impl Conditions<'_> {
    /// The effort of one correction from where the original script fails, all tries. `None` where the watching teacher
    /// does not stop the script, and the arm finds all its ways.
    ///
    /// # Errors
    /// An error of the task or the teacher; [`BenchError::Interrupted`].
    pub fn effort_of_correction(&self, setting: &Arc<Setting>) -> Result<Option<TotalEffort>, BenchError> {
        let mut episode = Episode::start(setting, self.stream(setting, "script", &[0]))?;
        let ending = script::watched(&mut episode, &mut |_| {}).ending;
        if !matches!(ending, Ending::Stopped | Ending::OutOfReach | Ending::NoPlan) {
            return Ok(None);
        }
        let mut effort = TotalEffort::default();
        for attempt in 0..ATTEMPTS {
            self.check_interrupt()?;
            let seed = self.teacher_stream(setting, "script-correct", &[attempt]);
            let shown = self.demonstrated(&setting.label(), Kind::Corrective, episode.clone(), seed)?;
            let given = shown.clean && shown.demonstration.is_some();
            effort += TotalEffort::of_try(&shown.effort, given);
            if given {
                break;
            }
        }
        Ok(Some(effort))
    }

    /// Teaches the original task as a run does, and rolls the model out there and in changed tasks, from fresh starts.
    /// `None` where the teacher does not bring the model to the target.
    ///
    /// # Errors
    /// An error of the task, the teacher or the method; [`BenchError::Interrupted`].
    pub fn absorbed(&self, original: &Arc<Setting>, changed: &[Arc<Setting>]) -> Result<Option<Absorbed>, BenchError> {
        let standard = method::standard();
        let task = self.teach(original, &*standard)?;
        let (Ok(model), Some(rate)) = (&task.original, task.rate) else { return Ok(None) };
        let learned = standard.take_over(model)?;
        let rolled_out = changed.iter().map(|setting| {
            let evaluation = self.evaluate(&*learned, setting)?;
            Ok((!evaluation.spoilt).then_some(evaluation.rate))
        });
        Ok(Some(Absorbed { original: rate, changed: rolled_out.collect::<Result<_, BenchError>>()? }))
    }
}
