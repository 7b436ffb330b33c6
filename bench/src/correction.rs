//! Correcting a robot: it fails, a teacher steps in, the method folds the correction in, until the task succeeds.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use situ::correction::{Correction, Oracle};
use situ::demonstration::{Demonstration, Kind};
use situ::edit::{Difference, difference};
use situ::graph::Graph;
use situ::method::{Learned, Method, Original};
use situ::place::{NodeId, Place};
use situ::structure::Structure;
use situ_tasks::{Setting, Skill};
use situ_teachers::Onset;

use crate::conditions::Conditions;
use crate::correction_record::{CorrectionRecord, StepSummary};
use crate::cost;
use crate::ended::Ended;
use crate::error::BenchError;
use crate::evaluation::Evaluation;
use crate::lesson::Lesson;
use crate::memo::Cursor;
use crate::protocol::Corrections;
use crate::record::RunRecord;
use crate::retrieval::retrieved;
use crate::rollout::{Rollout, Watched};
use crate::spending::{RunPhase, Steps};
use crate::starts::Starts;
use crate::stop::{self, StopPoint, Stopped};
use crate::tally::{Rate, TotalEffort, count};
use crate::teaching::ATTEMPTS;
use crate::witness::{Intervened, Witness};

/// A robot under correction: its task model, and all demonstrations that it was shown.
pub struct Robot<'a> {
    method: &'a dyn Method,
    model: Box<dyn Learned>,
    lesson: Lesson,
    /// The archive's folder for its corrections, below that of the setting.
    folder: String,
}

/// A failure, as the teacher finds it.
struct Failure<'a> {
    cursor: Cursor<'a>,
    trigger: String,
    stop: Stopped,
}

/// A failure, the teacher's demonstration from there, and the effort of it and of all tries before it that failed.
struct Shown<'a> {
    /// The rollout that failed.
    index: u32,
    failure: Failure<'a>,
    /// The seed of the teacher's draws.
    seed: u64,
    demonstration: Demonstration,
    effort: TotalEffort,
}

/// How the corrections came to an end.
pub struct CorrectionsEnd {
    /// The evaluation that decided about it.
    pub(crate) last: Evaluation,
    /// Whether there was no failure from which the teacher could show the way.
    pub(crate) gave_up: bool,
}

impl<'a> Robot<'a> {
    /// A robot that takes over a model of the original task, taught by these demonstrations. `folder` names its
    /// corrections in an archive.
    ///
    /// # Errors
    /// Where the model is of another kind than the method's.
    pub fn new(
        method: &'a dyn Method,
        original: &Original,
        demonstrations: &[Demonstration],
        folder: String,
    ) -> Result<Self, BenchError> {
        let model = method.take_over(original)?;
        Ok(Self { method, model, lesson: Lesson::new(demonstrations), folder })
    }

    /// The method that corrects it.
    pub fn method(&self) -> &'a dyn Method {
        self.method
    }

    /// Its task model.
    pub fn model(&self) -> &dyn Learned {
        &*self.model
    }

    /// The demonstrations that it was shown.
    pub fn lesson(&self) -> &Lesson {
        &self.lesson
    }

    /// How far its structure is the one that the teacher meant.
    ///
    /// # Errors
    /// Those of the model.
    pub fn structure(&self) -> Result<Option<Structure>, BenchError> {
        Ok(self.lesson.score(&self.model.graph()?))
    }

    /// Folds a correction in; returns its record. Skills that the teacher named are no longer among those that the
    /// oracle says to have changed.
    fn correct(
        &mut self,
        shown: Shown<'_>,
        setting: &Setting,
        oracle: &mut Oracle,
    ) -> Result<CorrectionRecord, BenchError> {
        let shows_change = shows_change(setting, &shown.demonstration);
        let Shown { failure: Failure { trigger, stop, .. }, demonstration, effort, .. } = shown;
        let before = self.model.graph()?;
        let correction = Correction { oracle: Some(&*oracle), ..stop.correction(&demonstration) };
        let (trace, update_seconds) = cost::timed(|| self.model.correct(correction));
        let trace = trace?;
        let after = self.model.graph()?;
        let lengths = after.lengths.last().map_or(&[][..], Vec::as_slice);
        let retrieved = retrieved(self.lesson.skills(&before), &trace, &demonstration, lengths);
        for name in demonstration.keyframes().iter().filter_map(|keyframe| keyframe.narration.as_ref()) {
            oracle.changed.remove(name);
        }
        self.lesson.corrected(&before, &stop, demonstration);
        let made = difference(&before, &after);
        let edges_back = edges_back(&made, &before, &after, &stop);
        Ok(CorrectionRecord {
            failure: trigger,
            last: stop::reference(&before, stop.last),
            effort,
            shows_change,
            edit_made: made.edit(),
            nodes_added: count(made.nodes_added.len()),
            edges_added: count(made.edges_added.len()),
            edges_back,
            nodes_modified: count(made.nodes_modified.len()),
            nodes_merged: count(made.nodes_merged),
            obedience: trace.obedience,
            steps: trace.steps.iter().zip(retrieved).map(|(step, found)| StepSummary::of(step, found)).collect(),
            counters: trace.counters,
            decided_by: Rate::default(),
            update_seconds,
        })
    }
}

impl<'a> Conditions<'a> {
    /// Corrects the robot on a setting until the target is reached or the budget is used up. `before` is the evaluation
    /// that called for it, with its round. The effort is added to the run. The witness sees each correction.
    ///
    /// # Errors
    /// An error of the task, the teacher, the method or the archive; [`BenchError::Interrupted`].
    pub fn correct(
        &self,
        robot: &mut Robot<'_>,
        setting: &Arc<Setting>,
        (first_round, before): (u32, &Evaluation),
        run: &mut RunRecord,
        witness: &mut dyn Witness,
    ) -> Result<CorrectionsEnd, BenchError> {
        let mut last = before.clone();
        let mut oracle = Oracle { changed: changed(setting) };
        for round in self.rounds(first_round) {
            if self.protocol.corrections == Corrections::UntilReached && self.is_reached(&last) {
                break;
            }
            let mut failed = TotalEffort::default();
            let conditions = self.during(RunPhase::Correct);
            let Some(shown) = conditions.shown(robot.model(), (setting, round), &mut last, &mut failed)? else {
                run.effort += failed;
                return Ok(CorrectionsEnd { last, gave_up: true });
            };
            self.archive_correction(robot, setting, &shown, round)?;
            witness.corrects(&Intervened {
                round,
                index: shown.index,
                trigger: &shown.failure.trigger,
                episode: shown.failure.cursor.episode(),
                name: shown.demonstration.name(),
                seed: shown.seed,
            });
            run.effort += shown.effort;
            let correction = self
                .during(RunPhase::Correct)
                .spend(|| robot.correct(shown, setting, &mut oracle), |_| Steps::default())?;
            last = self.decide(robot.model(), setting, round + 1)?;
            run.corrections.push(CorrectionRecord { decided_by: last.rate, ..correction });
        }
        Ok(CorrectionsEnd { last, gave_up: false })
    }

    /// The rounds of corrections, at the most.
    fn rounds(&self, first: u32) -> Range<u32> {
        match self.protocol.corrections {
            Corrections::UntilReached => first..first + self.protocol.budget.demonstrations,
            Corrections::Once => first..first + 1,
        }
    }

    /// Writes a correction into the archive, where there is one.
    fn archive_correction(
        &self,
        robot: &Robot<'_>,
        setting: &Setting,
        shown: &Shown<'_>,
        round: u32,
    ) -> Result<(), BenchError> {
        let Some(archive) = self.archive else { return Ok(()) };
        let Shown { failure, demonstration, .. } = shown;
        let stop = StopPoint::of(&robot.model.graph()?, &failure.stop);
        let before = robot.lesson.before(demonstration.name(), stop)?;
        let path = format!("{}/{}-correction-{round}", self.folder(setting), robot.folder);
        archive.write(&path, demonstration, self.schema, &before)
    }

    /// What the teacher shows, and the failure from which. The teacher of whole demonstrations begins again from
    /// another start after a try that failed; so one who corrects begins again from another failure of the last
    /// evaluation, as long as there is one, and gives up after as many tries. Tries that failed are added to `failed`,
    /// and are part of the effort of the demonstration.
    fn shown(
        &self,
        model: &dyn Learned,
        (setting, round): (&Arc<Setting>, u32),
        last: &mut Evaluation,
        failed: &mut TotalEffort,
    ) -> Result<Option<Shown<'a>>, BenchError> {
        let mut found: Vec<(u32, Failure<'a>)> = Vec::new();
        let mut looked_at = 0;
        for attempt in 0..ATTEMPTS {
            self.check_interrupt()?;
            let is_first = found.is_empty();
            found.extend(self.next_failure(model, (setting, round), last, &mut looked_at, is_first)?);
            if found.is_empty() {
                return Ok(None);
            }
            let place = attempt as usize % found.len();
            let (index, failure) = &found[place];
            let seed = self.teacher_stream(setting, "correct", &[round, *index, attempt]);
            let name = format!("{}-correction-{round}", setting.label());
            let show = |episode| self.demonstrated(&name, Kind::Corrective, episode, seed);
            let shown = failure.cursor.shown(attempt, show)?;
            let demonstration = shown.demonstration.clone().filter(|_| shown.clean);
            *failed += TotalEffort::of_try(&shown.effort, demonstration.is_some());
            if let Some(demonstration) = demonstration {
                let (index, failure) = found.swap_remove(place);
                return Ok(Some(Shown { index, failure, seed, demonstration, effort: *failed }));
            }
        }
        Ok(None)
    }

    /// The next failure of the last evaluation that the teacher meets when watching. Where the evaluation stopped early
    /// and there is none among its failures, it goes on if one is needed.
    fn next_failure(
        &self,
        model: &dyn Learned,
        (setting, round): (&Arc<Setting>, u32),
        last: &mut Evaluation,
        looked_at: &mut usize,
        is_needed: bool,
    ) -> Result<Option<(u32, Failure<'a>)>, BenchError> {
        loop {
            while let Some(index) = last.correctable(self.protocol.corrections).get(*looked_at).copied() {
                *looked_at += 1;
                if let Some(failure) = self.watch(model, setting, round, index)? {
                    return Ok(Some((index, failure)));
                }
            }
            let conditions = self.during(RunPhase::Evaluate);
            if !is_needed || !conditions.evaluate_on(model, setting, Starts::Round(round), last)? {
                return Ok(None);
            }
        }
    }

    /// The same rollout again, now with the teacher watching, and the failure as the teacher finds it. The teacher may
    /// come too early or too late.
    fn watch(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        index: u32,
    ) -> Result<Option<Failure<'a>>, BenchError> {
        let watch = |watched| self.roll_out(model, setting, (Starts::Round(round), index), watched, &mut ());
        let onset = self.teacher.onset(self.teacher_stream(setting, "onset", &[round, index]));
        let Some((mut rollout, mut cursor)) = watch(Watched::AfterMissing(u32::from(onset == Onset::Late)))? else {
            return Ok(None);
        };
        // Too early is one primitive before the one that went wrong: the robot begins anew and is stopped there.
        if let (Onset::Early, Some(last)) = (onset, rollout.primitives.checked_sub(1))
            && let Some(early) = watch(Watched::UntilPrimitive(last))?
        {
            (rollout, cursor) = early;
        }
        if rollout.success || rollout.ended == Ended::Spoilt {
            return Ok(None);
        }
        let trigger = if rollout.ended == Ended::End { "wrong outcome".to_owned() } else { rollout.ended.to_string() };
        let Rollout { last, interrupted, trail, .. } = rollout;
        Ok(Some(Failure { cursor, trigger, stop: Stopped { last, interrupted, trail } }))
    }
}

/// How many of the added edges lead back to what the robot had already done before it stopped.
fn edges_back(made: &Difference, before: &Graph, after: &Graph, stop: &Stopped) -> u32 {
    let (held_before, holders) = (before.holders(), after.holders());
    let is_done = |id: NodeId| stop.trail.iter().any(|step| step.node == id);
    let done: BTreeSet<Place> = held_before
        .iter()
        .filter(|(_, node)| is_done(node.id))
        .filter_map(|(segment, _)| Some(Place::Node(holders.get(segment)?.id)))
        .collect();
    count(made.edges_added.iter().filter(|(_, to)| done.contains(to)).count())
}

/// Whether a demonstration shows what changed: a skill that the original task has not, or does in another way. Where
/// all skills are those of the original task, what changed is when each is due, and any of them shows it.
fn shows_change(setting: &Setting, demonstration: &Demonstration) -> bool {
    let new: BTreeSet<&str> =
        setting.skills.iter().filter(|skill| !setting.is_original(skill)).map(|skill| &*skill.name).collect();
    let mut named = demonstration.keyframes().iter().filter_map(|keyframe| keyframe.narration.as_deref());
    new.is_empty() || named.any(|name| new.contains(name))
}

/// The skills that a setting does in another way than the original task.
fn changed(setting: &Setting) -> BTreeSet<Arc<str>> {
    let is_changed = |skill: &&Skill| {
        let original = setting.original_skills.iter().find(|original| original.name == skill.name);
        original.is_some_and(|original| original.keyframes != skill.keyframes)
    };
    setting.skills.iter().filter(is_changed).map(|skill| skill.name.as_str().into()).collect()
}
