//! The conditions of a run, which all its parts share.
//!
//! Every random draw has a stream that is named by its purpose. No name holds the method: every method meets the same
//! starts, the same noise of execution and the same teacher. Names of starts and of noise hold no teacher either.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use situ::method::Method;
use situ::random::stream;
use situ::state::Schema;
use situ_tasks::Setting;
use situ_teachers::Teacher;

use crate::archive::Archive;
use crate::error::BenchError;
use crate::memo::Memo;
use crate::protocol::Protocol;
use crate::record::Key;
use crate::spending::{RunPhase, Spending, Steps};

/// The conditions that all runs of one task, teacher and seed share.
#[derive(Clone, Copy)]
pub struct Conditions<'a> {
    /// The protocol.
    pub protocol: &'a Protocol,
    /// The teacher.
    pub teacher: &'a Teacher,
    /// What the runs are made of ([`crate::content`]).
    pub content: &'a str,
    /// The seed of the run: the root of all its streams.
    pub seed: u64,
    /// The task family.
    pub task: &'a str,
    /// The features of every observed state, in the original task and in all its variations.
    pub schema: &'a Schema,
    /// Set when the user wants to stop.
    pub interrupted: &'a AtomicBool,
    /// Where the demonstrations are written, if anywhere.
    pub archive: Option<&'a Archive>,
    /// What has been simulated already.
    pub memo: &'a Memo<'a>,
    /// Where the time goes.
    pub spending: &'a Spending,
    /// The part of the run to which the time counts.
    pub phase: RunPhase,
    /// The steps of the run's physics so far, those that the memo had among them.
    pub steps: &'a AtomicU64,
}

impl Conditions<'_> {
    /// The same conditions, in another part of the run.
    pub(crate) fn during(self, phase: RunPhase) -> Self {
        Self { phase, ..self }
    }

    /// Does a piece of work on this thread, and counts what is spent on it. `steps` reads the steps off its result.
    pub(crate) fn spend<T>(&self, work: impl FnOnce() -> T, steps: impl FnOnce(&T) -> Steps) -> T {
        self.spending.spend(self.task, self.phase, work, |result| {
            let steps = steps(result);
            self.steps.fetch_add(steps.simulated + steps.replayed, Ordering::Relaxed);
            steps
        })
    }

    /// Asked between two pieces of work, and never while one is under way: what it says must not depend on the threads.
    ///
    /// # Errors
    /// [`BenchError::OutOfSteps`] where the run has used up its budget of steps.
    pub(crate) fn check_steps(&self) -> Result<(), BenchError> {
        let most = self.protocol.budget.steps;
        if self.steps.load(Ordering::Relaxed) > most { Err(BenchError::OutOfSteps { most }) } else { Ok(()) }
    }

    /// The seed of one random draw on a setting: `purpose` and `numbers` name it. Every teacher's robot meets the same
    /// starts.
    pub(crate) fn stream(&self, setting: &Setting, purpose: &str, numbers: &[u32]) -> u64 {
        let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
        stream(self.seed, &format!("{}/{purpose}/{}", setting.label(), numbers.join("/")))
    }

    /// The same for a draw of the teacher's.
    pub(crate) fn teacher_stream(&self, setting: &Setting, purpose: &str, numbers: &[u32]) -> u64 {
        self.stream(setting, &format!("{}/{purpose}", self.teacher.profile().name), numbers)
    }

    /// The seed of a method's random draws.
    pub(crate) fn learner_seed(&self) -> u64 {
        stream(self.seed, "learner")
    }

    /// # Errors
    /// [`BenchError::Interrupted`] where the user wants to stop.
    pub(crate) fn check_interrupt(&self) -> Result<(), BenchError> {
        if self.interrupted.load(Ordering::Relaxed) { Err(BenchError::Interrupted) } else { Ok(()) }
    }

    /// The archive's folder for a setting.
    pub(crate) fn folder(&self, setting: &Setting) -> String {
        format!("{}/{}-seed-{}", setting.label(), self.teacher.profile().name, self.seed)
    }

    /// The name of a run.
    pub fn key(&self, setting: &Setting, method: &dyn Method) -> Key {
        Key::of(&self.protocol.name, setting, &self.teacher.profile().name, method, self.seed).made_of(self.content)
    }

    /// The name of a run that is a stage of a sequence.
    pub fn stage_key(&self, sequence: &str, index: usize, setting: &Setting, method: &dyn Method) -> Key {
        self.key(setting, method).at(sequence, index)
    }
}
