//! The session of one run: the original task was taught, it changes, and the model is corrected until it succeeds.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::Demonstration;
use situ::method::{self, Learned, Method, Role};
use situ_tasks::Setting;

use crate::calibration::BranchCalibration;
use crate::conditions::Conditions;
use crate::correction::Robot;
use crate::error::BenchError;
use crate::evaluation::Evaluation;
use crate::grade;
use crate::held_out::HeldOut;
use crate::lesson::Lesson;
use crate::record::{Key, Outcome, Pooled, RunRecord};
use crate::spending::RunPhase;
use crate::tally::{Rate, TotalEffort};
use crate::teaching::OriginalTask;
use crate::witness::Witness;

/// How the original model does on a changed task.
pub struct Uncorrected {
    /// The first round of rollouts that decide about it: 0, but where a sequence comes back to a task.
    first_round: u32,
    /// The evaluation that decides whether it is corrected, in that round.
    deciding: Evaluation,
    /// The one that is published.
    fresh: Evaluation,
    /// A demonstration of the changed task that no method is given.
    held_out: Option<Demonstration>,
}

/// How the teaching of a run ended.
struct Taught {
    /// The evaluation that decided about the end.
    last: Evaluation,
    /// The evaluation of what came of it, from fresh starts.
    fresh: Evaluation,
    /// Whether the teacher gave up.
    gave_up: bool,
    /// The calibration of the model in the rollouts of `fresh`.
    calibration: Option<BranchCalibration>,
}

impl Conditions<'_> {
    /// The original model on the changed task, from which a method starts. Where there is no such model, nothing is
    /// rolled out.
    pub fn before(
        &self,
        task: &OriginalTask,
        setting: &Arc<Setting>,
        method: &dyn Method,
    ) -> Result<Uncorrected, BenchError> {
        let Ok(original) = &task.original else {
            let none = || Evaluation::none(0);
            return Ok(Uncorrected { first_round: 0, deciding: none(), fresh: none(), held_out: None });
        };
        let before = self.before_of(&*method.take_over(original)?, setting, 0)?;
        Ok(Uncorrected { held_out: self.during(RunPhase::Teach).held_out(setting)?, ..before })
    }

    /// How a model does on a changed task, decided in this round. No demonstration is held out.
    fn before_of(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        first_round: u32,
    ) -> Result<Uncorrected, BenchError> {
        let (deciding, fresh) = (self.decide(model, setting, first_round)?, self.evaluate(model, setting)?);
        Ok(Uncorrected { first_round, deciding, fresh, held_out: None })
    }

    /// A run of one method on one setting.
    pub fn run(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        task: &OriginalTask,
        before: &Uncorrected,
    ) -> Result<RunRecord, BenchError> {
        self.witnessed_run(setting, method, task, before, &mut ())
    }

    /// The same run. The witness sees how the robot is corrected.
    pub fn witnessed_run(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        task: &OriginalTask,
        before: &Uncorrected,
        witness: &mut dyn Witness,
    ) -> Result<RunRecord, BenchError> {
        let mut run = self.begun(setting, self.key(setting, method), task);
        if !method.edits().contains(&run.key.edit) {
            run.outcome = Outcome::NotApplicable;
            return Ok(run);
        }
        let Ok(original) = &task.original else { return Ok(run) };
        // Who is taught anew has no model before.
        run.before = (method.role() != Role::FromScratch).then_some(before.fresh.rate);
        let taught = match method.role() {
            Role::Control => {
                let model = method.take_over(original)?;
                unchanged(&*model, &Lesson::new(&task.demonstrations), before, &mut run)?
            }
            Role::Correct => {
                let folder = method.name().replace(':', "-");
                let mut robot = Robot::new(method, original, &task.demonstrations, folder)?;
                let taught = self.taught_by_corrections(&mut robot, setting, before, &mut run, witness)?;
                run.retained = self.retained(robot.model(), task, !run.corrections.is_empty())?;
                run.structure = robot.structure()?;
                if !run.corrections.is_empty() && self.protocol.pooled.iter().any(|name| name == method.name()) {
                    let conditions = self.during(RunPhase::Pool);
                    run.pooled = Some(conditions.pooled(&robot, setting, task, before.held_out.as_ref())?);
                }
                taught
            }
            Role::FromScratch => self.taught_anew(setting, method, before, &mut run)?,
        };
        self.finish(&mut run, taught);
        Ok(run)
    }

    /// Corrects a robot, and evaluates what came of it.
    fn taught_by_corrections(
        &self,
        robot: &mut Robot<'_>,
        setting: &Arc<Setting>,
        before: &Uncorrected,
        run: &mut RunRecord,
        witness: &mut dyn Witness,
    ) -> Result<Taught, BenchError> {
        witness.begins(robot.model(), robot.lesson(), &before.deciding)?;
        let corrected = self.correct(robot, setting, (before.first_round, &before.deciding), run, witness)?;
        witness.ends(robot.model(), robot.lesson())?;
        let fresh =
            if run.corrections.is_empty() { before.fresh.clone() } else { self.evaluate(robot.model(), setting)? };
        let calibration = judge(robot.model(), robot.lesson(), &fresh, before, run)?;
        Ok(Taught { last: corrected.last, fresh, gave_up: corrected.gave_up, calibration })
    }

    /// Teaches the changed task alone, and evaluates what came of it.
    fn taught_anew(
        &self,
        setting: &Arc<Setting>,
        method: &dyn Method,
        before: &Uncorrected,
        run: &mut RunRecord,
    ) -> Result<Taught, BenchError> {
        let anew = self.during(RunPhase::Teach).teach_anew(setting, method, &mut run.effort)?;
        let (last, gave_up) = (anew.last, anew.gave_up);
        let Some(model) = anew.model else {
            return Ok(Taught { last, fresh: Evaluation::none(self.protocol.rollouts), gave_up, calibration: None });
        };
        let fresh = self.evaluate(&*model, setting)?;
        let lesson = Lesson::new(&anew.demonstrations);
        run.structure = lesson.score(&model.graph()?);
        let calibration = judge(&*model, &lesson, &fresh, before, run)?;
        Ok(Taught { last, fresh, gave_up, calibration })
    }

    /// The runs of one method on a sequence of settings, added to `runs` as they end. Each begins with the model that
    /// the one before left. There are none for a method that is taught anew, because it would meet each setting as if
    /// that were alone.
    pub fn run_sequence(
        &self,
        name: &str,
        settings: &[Arc<Setting>],
        method: &dyn Method,
        task: &OriginalTask,
        runs: &mut Vec<RunRecord>,
    ) -> Result<(), BenchError> {
        if method.role() == Role::FromScratch {
            return Ok(());
        }
        let mut robot = None;
        let mut corrected = false;
        for (index, setting) in settings.iter().enumerate() {
            let mut run = self.begun(setting, self.stage_key(name, index, setting, method), task);
            if let Ok(original) = &task.original {
                let robot = match &mut robot {
                    Some(robot) => robot,
                    None => {
                        let folder = format!("{name}-{}", method.name().replace(':', "-"));
                        robot.insert(Robot::new(method, original, &task.demonstrations, folder)?)
                    }
                };
                let before = self.before_of(robot.model(), setting, self.first_round(&settings[..=index]))?;
                run.before = Some(before.fresh.rate);
                // Where the method cannot make the edit, it is not corrected, and the model goes on to the next stage
                // as it is.
                let is_applicable = method.edits().contains(&run.key.edit);
                let taught = match method.role() {
                    Role::Correct if is_applicable => {
                        self.taught_by_corrections(robot, setting, &before, &mut run, &mut ())?
                    }
                    Role::Correct | Role::FromScratch | Role::Control => {
                        unchanged(robot.model(), robot.lesson(), &before, &mut run)?
                    }
                };
                corrected |= !run.corrections.is_empty();
                run.retained = self.retained(robot.model(), task, corrected)?;
                run.structure = robot.structure()?.filter(|_| method.role() == Role::Correct);
                run.earlier = self.earlier(robot.model(), &settings[..=index])?;
                self.finish(&mut run, taught);
                if !is_applicable {
                    run.outcome = Outcome::NotApplicable;
                }
            }
            runs.push(run);
        }
        Ok(())
    }

    /// The first round of the last stage. Where its task stood there before, its rounds go on after those, so that
    /// other starts decide and the teacher shows it anew. The original task stood there when it was taught.
    fn first_round(&self, stages: &[Arc<Setting>]) -> u32 {
        let Some((setting, before)) = stages.split_last() else { return 0 };
        let taught = u32::from(setting.variation.is_none());
        let times = before.iter().filter(|earlier| earlier.variation == setting.variation).count() as u32;
        let budget = &self.protocol.budget;
        (taught + times) * (budget.demonstrations.max(budget.originals) + 1)
    }

    /// Success on the variations of the stages before the last, each once, but for the last one's own.
    fn earlier(&self, model: &dyn Learned, stages: &[Arc<Setting>]) -> Result<BTreeMap<String, Rate>, BenchError> {
        let Some((last, before)) = stages.split_last() else { return Ok(BTreeMap::new()) };
        let mut rates = BTreeMap::new();
        for setting in before {
            let Some(variation) = &setting.variation else { continue };
            if setting.variation != last.variation && !rates.contains_key(variation) {
                let evaluation = self.during(RunPhase::Retain).evaluate(model, setting)?;
                rates.insert(variation.clone(), evaluation.rate);
            }
        }
        Ok(rates)
    }

    /// Success on the original task, from the fresh starts of before. A model that was not corrected has the same
    /// success as then.
    fn retained(&self, model: &dyn Learned, task: &OriginalTask, corrected: bool) -> Result<Option<Rate>, BenchError> {
        if !corrected {
            return Ok(task.rate);
        }
        Ok(Some(self.during(RunPhase::Retain).evaluate(model, &task.setting)?.rate))
    }

    /// The comparison with the pooled model, which full retraining makes of the same demonstrations at once. It meets
    /// the starts that the corrected model meets, by which nothing was decided.
    fn pooled(
        &self,
        robot: &Robot<'_>,
        setting: &Arc<Setting>,
        task: &OriginalTask,
        held_out: Option<&Demonstration>,
    ) -> Result<Pooled, BenchError> {
        let pooled = method::pooled();
        let taken = task.original.as_ref().ok().filter(|_| robot.method().original() == pooled.original());
        let model = taken
            .map_or_else(|| self.learned(&*pooled, &task.demonstrations), |original| Ok(pooled.take_over(original)?))?;
        let model = robot.lesson().taught_to(pooled.name(), model)?;
        Ok(Pooled {
            pooled: self.evaluate(&*model, setting)?.rate,
            retained: self.during(RunPhase::Retain).evaluate(&*model, &task.setting)?.rate,
            structure: robot.lesson().score(&model.graph()?),
            held_out: held_out.and_then(|demonstration| HeldOut::of(&*model, demonstration)),
        })
    }

    fn finish(&self, run: &mut RunRecord, taught: Taught) {
        let Taught { last, fresh, gave_up, calibration } = taught;
        run.outcome = match () {
            () if last.spoilt || fresh.spoilt => {
                Outcome::Spoilt { why: "a rollout's physics was no longer sound".to_owned() }
            }
            () if self.is_reached(&last) => Outcome::Reached,
            () if gave_up => Outcome::GaveUp {
                why: format!(
                    "the teacher could not show the way any more: {} tries for {} demonstrations",
                    run.effort.tries, run.effort.demonstrations
                ),
            },
            () => Outcome::Censored,
        };
        run.after = Some(fresh.rate);
        run.ended = fresh.ended;
        run.calibration = calibration;
    }

    /// A run that was not done to its end. It has no model that could succeed anywhere.
    pub fn failed(
        &self,
        setting: &Setting,
        method: &dyn Method,
        task: &OriginalTask,
        before: Option<&Uncorrected>,
        outcome: Outcome,
    ) -> RunRecord {
        let none = Rate { rollouts: self.protocol.rollouts, ..Rate::default() };
        let keeps_original = method.role() != Role::FromScratch;
        RunRecord {
            outcome,
            before: before.filter(|_| keeps_original).map(|before| before.fresh.rate),
            after: Some(none),
            retained: keeps_original.then_some(none),
            ..self.begun(setting, self.key(setting, method), task)
        }
    }

    /// A run at its beginning. Only the effort of teaching the original task is known.
    fn begun(&self, setting: &Setting, key: Key, task: &OriginalTask) -> RunRecord {
        let why = task.original.as_ref().err().cloned().unwrap_or_default();
        RunRecord {
            key,
            outcome: Outcome::Untaught { why },
            self_loop: setting.accepts_edges.iter().any(|[from, to]| from == to),
            grade: grade::grade(&self.protocol.grade, setting, &self.teacher.profile().name),
            budget: self.protocol.budget.demonstrations,
            target: self.protocol.target,
            original: task.effort,
            before: None,
            after: None,
            effort: TotalEffort::default(),
            corrections: Vec::new(),
            ended: BTreeMap::new(),
            original_rate: task.rate,
            retained: None,
            structure: None,
            pooled: None,
            calibration: None,
            held_out: None,
            earlier: BTreeMap::new(),
        }
    }
}

/// Nothing was taught.
fn unchanged(
    model: &dyn Learned,
    lesson: &Lesson,
    before: &Uncorrected,
    run: &mut RunRecord,
) -> Result<Taught, BenchError> {
    let calibration = judge(model, lesson, &before.fresh, before, run)?;
    Ok(Taught { last: before.deciding.clone(), fresh: before.fresh.clone(), gave_up: false, calibration })
}

/// Holds a model against the demonstration that was held out. Returns its calibration in the rollouts of an evaluation.
fn judge(
    model: &dyn Learned,
    lesson: &Lesson,
    evaluation: &Evaluation,
    before: &Uncorrected,
    run: &mut RunRecord,
) -> Result<Option<BranchCalibration>, BenchError> {
    run.held_out = before.held_out.as_ref().and_then(|demonstration| HeldOut::of(model, demonstration));
    let graph = model.graph()?;
    Ok(BranchCalibration::of(&evaluation.choices, &graph, &lesson.skills(&graph)))
}
