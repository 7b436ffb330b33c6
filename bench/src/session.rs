//! The session of one run: the original task was taught, it changes, and the model is corrected until it succeeds.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::method::{self, Learned, Method, Role};
use situ_tasks::Setting;

use crate::conditions::Conditions;
use crate::correction::Robot;
use crate::error::BenchError;
use crate::evaluation::{Evaluation, Until};
use crate::record::{Key, Outcome, Pooled, Rate, RunRecord, TotalEffort};
use crate::spending::RunPhase;
use crate::teaching::OriginalTask;

impl Conditions<'_> {
    /// The original model on the changed task, from which a method starts. Where there is no such model, nothing is
    /// rolled out.
    pub fn before(
        &self,
        task: &OriginalTask,
        setting: &Arc<Setting>,
        method: &dyn Method,
    ) -> Result<Evaluation, BenchError> {
        let Some(original) = &task.original else { return Ok(Evaluation::none(0)) };
        self.evaluate(&*method.take_over(original)?, setting, 0, Until::Done)
    }

    /// A run of one method on one setting.
    pub fn run(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        task: &OriginalTask,
        before: &Evaluation,
    ) -> Result<RunRecord, BenchError> {
        let mut run = begun(self.key(setting, method), task);
        if !method.edits().contains(&run.key.edit) {
            run.outcome = Outcome::NotApplicable;
            return Ok(run);
        }
        let Some(original) = &task.original else { return Ok(run) };
        run.before = Some(before.rate);
        let last = match method.role() {
            Role::Control => before.clone(),
            Role::Correct => {
                let folder = method.name().replace(':', "-");
                let mut robot = Robot::new(method, original, &task.demonstrations, folder)?;
                let last = self.correct(&mut robot, setting, before, &mut run)?;
                run.retained = Some(self.retained(robot.model(), task, !run.corrections.is_empty())?);
                run.structure = robot.structure();
                if !run.corrections.is_empty() && self.protocol.pooled.iter().any(|name| name == method.name()) {
                    run.pooled = Some(self.during(RunPhase::Pool).pooled(&robot, setting, task)?);
                }
                last
            }
            Role::FromScratch => self.during(RunPhase::Teach).teach_anew(setting, method, &mut run.effort)?,
        };
        self.finish(&mut run, last);
        Ok(run)
    }

    /// The runs of one method on a sequence of settings. Each begins with the model that the one before left. There are
    /// none for a method that is taught anew, because it would meet each setting as if that were alone.
    pub fn run_sequence(
        &self,
        name: &str,
        settings: &[Arc<Setting>],
        method: &dyn Method,
        task: &OriginalTask,
    ) -> Result<Vec<RunRecord>, BenchError> {
        if method.role() == Role::FromScratch {
            return Ok(Vec::new());
        }
        let mut runs = Vec::new();
        let mut robot = None;
        let mut corrected = false;
        for (index, setting) in settings.iter().enumerate() {
            let mut run = begun(self.stage_key(name, index, setting, method), task);
            if let Some(original) = &task.original {
                let robot = match &mut robot {
                    Some(robot) => robot,
                    None => {
                        let folder = format!("{name}-{}", method.name().replace(':', "-"));
                        robot.insert(Robot::new(method, original, &task.demonstrations, folder)?)
                    }
                };
                let before = self.evaluate(robot.model(), setting, 0, Until::Done)?;
                run.before = Some(before.rate);
                // Where the method cannot make the edit, it is not corrected, and the model goes on to the next stage
                // as it is.
                let is_applicable = method.edits().contains(&run.key.edit);
                let last = match method.role() {
                    _ if !is_applicable => before,
                    Role::Correct => self.correct(robot, setting, &before, &mut run)?,
                    Role::FromScratch | Role::Control => before,
                };
                corrected |= !run.corrections.is_empty();
                run.retained = Some(self.retained(robot.model(), task, corrected)?);
                for earlier in &settings[..index] {
                    let evaluation = self.during(RunPhase::Retain).evaluate(robot.model(), earlier, 0, Until::Done)?;
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

    /// Success on the original task, from the starts of the evaluation after it was learned. A model that was not
    /// corrected has the same success as then.
    fn retained(&self, model: &dyn Learned, task: &OriginalTask, corrected: bool) -> Result<Rate, BenchError> {
        if !corrected {
            return Ok(task.rate);
        }
        Ok(self.during(RunPhase::Retain).evaluate(model, &task.setting, task.round, Until::Done)?.rate)
    }

    /// The comparison with the pooled model, which full retraining makes of the same demonstrations at once. Both
    /// models meet fresh starts, which did not decide about any correction. Otherwise the corrected model, which was
    /// corrected until it succeeded, would be favoured.
    fn pooled(&self, robot: &Robot<'_>, setting: &Arc<Setting>, task: &OriginalTask) -> Result<Pooled, BenchError> {
        let pooled = method::pooled();
        let taken = task.original.as_ref().filter(|_| robot.method().original() == pooled.original());
        let model = taken
            .map_or_else(|| self.learned(&*pooled, &task.demonstrations), |original| Ok(pooled.take_over(original)?))?;
        let model = robot.lesson().taught_to(pooled.name(), model)?;
        let fresh = self.protocol.budget.corrections + 1;
        Ok(Pooled {
            separate: self.evaluate(robot.model(), setting, fresh, Until::Done)?.rate,
            pooled: self.evaluate(&*model, setting, fresh, Until::Done)?.rate,
            retained: self.retained(&*model, task, true)?,
            structure: robot.lesson().score(&model.graph()),
        })
    }

    fn finish(&self, run: &mut RunRecord, last: Evaluation) {
        run.outcome = match () {
            () if last.spoilt => Outcome::Spoilt { why: "a rollout's physics was no longer sound".to_owned() },
            () if self.is_reached(&last) => Outcome::Reached,
            () => Outcome::Censored,
        };
        run.after = Some(last.rate);
        run.ended = last.ended;
    }
}

/// A run at its beginning. Only the effort of teaching the original task is known.
fn begun(key: Key, task: &OriginalTask) -> RunRecord {
    RunRecord {
        key,
        outcome: Outcome::Untaught,
        original: task.effort,
        before: None,
        after: None,
        effort: TotalEffort::default(),
        corrections: Vec::new(),
        ended: BTreeMap::new(),
        original_rate: Some(task.rate),
        retained: None,
        structure: None,
        pooled: None,
        earlier: BTreeMap::new(),
    }
}
