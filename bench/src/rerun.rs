//! A run of a protocol once more, by the same code and the same streams, so that it can be shown.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

use situ::demonstration::Kind;
use situ::error::SituError;
use situ::method::{self, Learned, Method};
use situ::place::{NodeId, Place};
use situ::state::Schema;
use situ_tasks::{Episode, Setting, World};
use situ_teachers::{Shown, Teacher};

use crate::conditions::Conditions;
use crate::error::BenchError;
use crate::evaluation::Evaluation;
use crate::lesson::Lesson;
use crate::memo::{Memo, Room};
use crate::observer::Observer;
use crate::protocol::Protocol;
use crate::record::{Outcome, RunRecord};
use crate::rollout::{Rollout, Watched};
use crate::runner::Progress;
use crate::spending::{RunPhase, Spending};
use crate::starts::Starts;
use crate::witness::{Intervened, Witness};

/// What decides a run, but for the method.
pub struct Rerun<'a> {
    /// The protocol.
    pub protocol: &'a Protocol,
    /// The teacher.
    pub teacher: &'a Teacher,
    /// The seed.
    pub seed: u64,
    /// The original task.
    pub original: &'a Arc<Setting>,
    /// The variation.
    pub setting: &'a Arc<Setting>,
    /// The features of the observed states of both.
    pub schema: &'a Schema,
    /// Set when the user wants to stop.
    pub interrupted: &'a AtomicBool,
    /// Told how the run goes on.
    pub progress: &'a dyn Progress,
}

/// A task model at a moment of a run, with names for its primitives.
pub struct NamedModel {
    /// The model.
    pub learned: Box<dyn Learned>,
    /// What each of its primitives is called.
    names: BTreeMap<NodeId, String>,
}

impl NamedModel {
    fn of(model: &dyn Learned, lesson: &Lesson) -> Result<Self, SituError> {
        let graph = model.graph()?;
        let skills = lesson.skills(&graph);
        let name = |id: NodeId, reference: &str| match skills.get(&id) {
            Some(skill) => skill.to_string(),
            None => format!("{id} on {reference}"),
        };
        let names = graph.nodes.iter().map(|node| (node.id, name(node.id, &node.reference))).collect();
        Ok(Self { learned: model.boxed(), names })
    }

    /// What a place is called: the teacher's word for it, or the node with its reference object where there is none.
    pub fn name(&self, place: Place) -> String {
        let known = place.node().and_then(|id| self.names.get(&id));
        known.cloned().unwrap_or_else(|| place.to_string())
    }
}

/// A correction that the robot was given.
pub struct GivenCorrection {
    /// The round and the rollout that failed.
    pub failure: (u32, u32),
    /// Why the robot was stopped.
    pub trigger: String,
    /// The episode as the teacher found it.
    pub episode: Episode,
    name: String,
    seed: u64,
}

/// What happened in a run.
pub struct Story {
    /// The record, as the ledger has it.
    pub record: RunRecord,
    /// The model of the original task, on which nothing was corrected.
    pub before: NamedModel,
    /// The corrections, in order.
    pub corrections: Vec<GivenCorrection>,
    /// The model after them.
    pub after: NamedModel,
    /// The rollouts that failed before, of those by which it was decided to correct the robot.
    pub failures: Vec<u32>,
    /// How many of those there were.
    pub rollouts: u32,
    /// The start that is shown.
    pub start: (Starts, u32),
}

/// What a witness keeps, and who is told how the run goes on.
struct Kept<'a> {
    progress: &'a dyn Progress,
    before: Option<(NamedModel, Evaluation)>,
    corrections: Vec<GivenCorrection>,
    after: Option<NamedModel>,
}

impl Witness for Kept<'_> {
    fn begins(&mut self, model: &dyn Learned, lesson: &Lesson, before: &Evaluation) -> Result<(), SituError> {
        self.progress.at("correcting");
        self.before = Some((NamedModel::of(model, lesson)?, before.clone()));
        Ok(())
    }

    fn corrects(&mut self, seen: &Intervened<'_>) {
        self.progress.at(&format!("correction {} is given", seen.round + 1));
        self.corrections.push(GivenCorrection {
            failure: (seen.round, seen.index),
            trigger: seen.trigger.to_owned(),
            episode: seen.episode.clone(),
            name: seen.name.to_owned(),
            seed: seen.seed,
        });
    }

    fn ends(&mut self, model: &dyn Learned, lesson: &Lesson) -> Result<(), SituError> {
        self.progress.at("rolling out the corrected model");
        self.after = Some(NamedModel::of(model, lesson)?);
        Ok(())
    }
}

impl Rerun<'_> {
    /// Does something under the conditions of the run, with a memo that knows nothing yet: all is simulated, and seen.
    fn under<R>(&self, what: impl FnOnce(&Conditions<'_>) -> Result<R, BenchError>) -> Result<R, BenchError> {
        let (room, spending) = (Room::default(), Spending::new());
        what(&Conditions {
            protocol: self.protocol,
            teacher: self.teacher,
            content: "",
            seed: self.seed,
            task: &self.original.task,
            schema: self.schema,
            interrupted: self.interrupted,
            archive: None,
            memo: &Memo::new(&room),
            spending: &spending,
            phase: RunPhase::Teach,
            steps: &AtomicU64::new(0),
        })
    }

    /// The run of a method that takes corrections.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where the original task could not be taught, or the method cannot make the edit; an
    /// error of the task, the teacher or the method; [`BenchError::Interrupted`].
    pub fn story(&self, method: &dyn Method) -> Result<Story, BenchError> {
        let mut kept = Kept { progress: self.progress, before: None, corrections: Vec::new(), after: None };
        let record = self.under(|conditions| self.record(conditions, method, &mut kept))?;
        let Kept { before: Some((before, evaluation)), corrections, after: Some(after), .. } = kept else {
            return Err(BenchError::Argument(self.unseen(method, &record.outcome)));
        };
        let failure = corrections.first().map(|given| given.failure.1).or(evaluation.failures.first().copied());
        let start = failure.map_or_else(|| self.first_start(), |index| Ok((Starts::Round(0), index)))?;
        let (failures, rollouts) = (evaluation.failures, evaluation.rate.rollouts);
        Ok(Story { record, before, corrections, after, failures, rollouts, start })
    }

    /// The run as a runner of one method does it.
    fn record(
        &self,
        conditions: &Conditions<'_>,
        method: &dyn Method,
        kept: &mut Kept<'_>,
    ) -> Result<RunRecord, BenchError> {
        let standard = method::standard();
        self.progress.at("teaching the original task");
        let mut task = conditions.teach(self.original, &*standard)?;
        // What one method is taught is no other's budget, and what it is taught is not that of its run.
        let (own, uncorrected, run) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
        if method.original() != standard.original() {
            task = Conditions { steps: &own, ..*conditions }.taught_to(&task, method)?;
        }
        self.progress.at("rolling out the original model");
        let conditions = conditions.during(RunPhase::Evaluate);
        let before = Conditions { steps: &uncorrected, ..conditions }.before(&task, self.setting, method)?;
        Conditions { steps: &run, ..conditions }.witnessed_run(self.setting, method, &task, &before, kept)
    }

    /// Why a run has nothing to show.
    fn unseen(&self, method: &dyn Method, outcome: &Outcome) -> String {
        let (setting, teacher, seed) = (self.setting.label(), &self.teacher.profile().name, self.seed);
        match outcome {
            Outcome::NotApplicable => {
                format!("--method {}: it cannot make the edit that {setting} needs, expected another", method.name())
            }
            outcome => format!(
                "{setting}, seed {seed}, teacher {teacher}: the original task was not taught ({}), expected another \
                 --seed or --teacher",
                outcome.why().unwrap_or_default()
            ),
        }
    }

    /// The first start that the physics does not refuse.
    fn first_start(&self) -> Result<(Starts, u32), BenchError> {
        let starts = (0..self.protocol.rollouts).map(|index| (Starts::Round(0), index));
        for start in starts {
            if self.under(|conditions| conditions.start(self.setting, start))?.is_some() {
                return Ok(start);
            }
        }
        let setting = self.setting.label();
        Err(BenchError::Argument(format!("{setting}, seed {}: the physics refuses every start", self.seed)))
    }

    /// The episode in which a rollout begins.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where the physics refuses it; an error of the task.
    pub fn episode(&self, start: (Starts, u32)) -> Result<Episode, BenchError> {
        let episode = self.under(|conditions| conditions.start(self.setting, start))?;
        episode.ok_or_else(|| self.refused(start))
    }

    /// Rolls a model out, and the observer sees all of it.
    ///
    /// # Errors
    /// As [`Rerun::episode`]; an error of the method.
    pub fn roll_out(
        &self,
        model: &dyn Learned,
        start: (Starts, u32),
        observer: &mut dyn Observer,
    ) -> Result<Rollout, BenchError> {
        let rolled_out = self.under(|conditions| {
            let rolled_out = conditions.roll_out(model, self.setting, start, Watched::No, observer)?;
            Ok(rolled_out.map(|(rollout, _)| rollout))
        })?;
        rolled_out.ok_or_else(|| self.refused(start))
    }

    fn refused(&self, (_, index): (Starts, u32)) -> BenchError {
        let setting = self.setting.label();
        BenchError::Argument(format!("{setting}, seed {}: the physics refuses the start {index}", self.seed))
    }

    /// What the teacher showed, once more; the observer sees all of it. Also whether the goal holds at its end.
    ///
    /// # Errors
    /// An error of the teacher.
    pub fn correct(
        &self,
        given: &GivenCorrection,
        observer: &mut dyn FnMut(&World),
    ) -> Result<(Shown, bool), BenchError> {
        let mut episode = given.episode.clone();
        let (name, kind) = (&given.name, Kind::Corrective);
        let shown = self.teacher.demonstrate(name, kind, self.schema, &mut episode, given.seed, observer)?;
        Ok((shown, episode.succeeded()))
    }
}

#[cfg(test)]
mod tests {
    use situ_tasks::{Plant, Registry};
    use situ_teachers::{Roster, convert};

    use super::*;

    impl Progress for () {
        fn at(&self, _: &str) {}
        fn finished(&self) {}
    }

    /// The smallest protocol that teaches and corrects.
    fn protocol() -> Protocol {
        let protocol = Protocol::find("quick").unwrap();
        let budget = crate::protocol::Budget { least_originals: 2, originals: 3, demonstrations: 2, ..protocol.budget };
        Protocol { budget, rollouts: 3, target: 0.6, pooled: Vec::new(), ..protocol.without_arm() }
    }

    fn corrections_are_those_of_the_record(rerun: &Rerun<'_>, story: &Story) {
        assert_eq!(story.corrections.len(), story.record.corrections.len());
        assert!(!story.corrections.is_empty(), "the cover must come off first");
        for (given, record) in story.corrections.iter().zip(&story.record.corrections) {
            let mut steps = 0;
            let (shown, is_goal) = rerun.correct(given, &mut |_| steps += 1).unwrap();
            let demonstration = shown.demonstration.unwrap();
            assert_eq!((record.effort.tries, demonstration.keyframes().len() as u32), (1, record.effort.keyframes));
            assert_eq!((given.trigger.as_str(), is_goal), (record.failure.as_str(), demonstration.carried_to_end()));
            assert!((f64::from(steps) * situ_sim::DT - record.effort.seconds).abs() < 1e-9, "every step is seen");
        }
    }

    /// What is shown of a run is what the run did: its record is the same as without a witness, the rollouts that are
    /// watched are the ones that were counted, and what the teacher shows again is as long as what was recorded.
    #[test]
    fn a_rerun_is_the_run_that_it_shows() {
        let registry = Registry::builtin().unwrap().with_plant(Plant::Hand);
        let task = registry.get("sort_blocks").unwrap();
        let (original, setting) = (task.variation(None).unwrap(), task.variation(Some("cover")).unwrap());
        let teacher = Teacher::new(Roster::builtin().unwrap().get("expert").unwrap().clone());
        let (protocol, schema) = (protocol(), convert::schema(&original).unwrap());
        let rerun = Rerun {
            protocol: &protocol,
            teacher: &teacher,
            seed: 5,
            original: &original,
            setting: &setting,
            schema: &schema,
            interrupted: &AtomicBool::new(false),
            progress: &(),
        };
        let method = method::named("situ").unwrap();
        let story = rerun.story(&*method).unwrap();
        let record = rerun.under(|conditions| {
            let task = conditions.teach(&original, &*method)?;
            let before = conditions.before(&task, &setting, &*method)?;
            conditions.run(&setting, &*method, &task, &before)
        });
        let timeless = |record: RunRecord| crate::record::Record::Run(record).without_times();
        assert_eq!(timeless(story.record.clone()), timeless(record.unwrap()));

        // The first failure is the one that is corrected, and it fails when it is watched, too.
        assert_eq!(story.start, (Starts::Round(0), story.failures[0]));
        assert_eq!(story.corrections[0].failure, (0, story.failures[0]));
        let before = rerun.roll_out(&*story.before.learned, story.start, &mut ()).unwrap();
        assert!(!before.success);
        let unseen = |model: &NamedModel, start| {
            let roll_out = |conditions: &Conditions<'_>| {
                Ok(conditions.roll_out(&*model.learned, &setting, start, Watched::No, &mut ())?.unwrap().0)
            };
            rerun.under(roll_out).unwrap()
        };
        assert_eq!(unseen(&story.before, story.start), before);
        // The corrected model succeeds as often as the record says, from the same starts.
        let fresh = (0..protocol.rollouts).map(|index| unseen(&story.after, (Starts::Fresh, index)).success);
        let after = story.record.after.unwrap();
        assert_eq!(
            (fresh.filter(|success| *success).count() as u32, protocol.rollouts),
            (after.successes, after.rollouts)
        );
        corrections_are_those_of_the_record(&rerun, &story);
        // Words where the teacher has one, the node and its object where not, and the places that are no primitives.
        let first = before.choices[0].child;
        assert!(setting.original_skills.iter().any(|skill| skill.name == story.before.name(first)));
        let wordless = NamedModel::of(&*story.before.learned, &Lesson::new(&[])).unwrap();
        let name = wordless.name(first);
        assert!(name.starts_with(&first.to_string()) && name.contains(" on "), "{name}");
        assert_eq!(wordless.name(Place::End), "END");
    }
}
