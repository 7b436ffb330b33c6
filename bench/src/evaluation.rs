//! Evaluations: a model's rollouts on a setting, from fresh starts.

use std::collections::BTreeMap;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use situ::method::Learned;
use situ_tasks::{Episode, Setting, TaskError};

use crate::conditions::Conditions;
use crate::ended::Ended;
use crate::error::BenchError;
use crate::memo::{Beginning, Cursor};
use crate::record::Rate;
use crate::rollout::{Execute, Rollout, Watched, rollout};
use crate::spending::Steps;

/// Rollouts between two looks at whether the target is out of reach. The number is fixed: the rollouts must not
/// depend on the number of threads.
const BATCH: u32 = 2;

/// How long an evaluation goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// All rollouts of the protocol, as they are published.
    Done,
    /// Until the target is out of reach: between corrections.
    OutOfReach,
}

/// A model's rollouts on a setting.
#[derive(Clone)]
pub struct Evaluation {
    /// Successes.
    pub(crate) rate: Rate,
    /// How the rollouts ended, by name.
    pub(crate) ended: BTreeMap<String, u32>,
    /// The rollouts that failed.
    pub(crate) failures: Vec<u32>,
    /// Whether the physics of one of them was no longer sound.
    pub(crate) spoilt: bool,
}

impl Evaluation {
    /// An evaluation of so many rollouts without a success.
    pub(crate) fn none(rollouts: u32) -> Self {
        Self { rate: Rate { successes: 0, rollouts }, ended: BTreeMap::new(), failures: Vec::new(), spoilt: false }
    }

    /// Counts a rollout. `None` is a rollout whose start the physics refused.
    fn count(&mut self, index: u32, rollout: Option<Rollout>) {
        self.rate.rollouts += 1;
        let Some(rollout) = rollout.filter(|rollout| rollout.ended != Ended::Spoilt) else {
            self.spoilt = true;
            return;
        };
        let how = if rollout.success { "success".to_owned() } else { format!("failure: {}", rollout.ended) };
        *self.ended.entry(how).or_default() += 1;
        if rollout.success {
            self.rate.successes += 1;
        } else {
            self.failures.push(index);
        }
    }
}

impl<'a> Conditions<'a> {
    /// Rolls the model out from fresh starts, which `round` names. An evaluation `until` the target is out of reach
    /// stops after the batch in which that became certain. It then tells that the model must be corrected further, and
    /// not how well it does.
    ///
    /// # Errors
    /// An error of the task or the method; [`BenchError::Interrupted`].
    pub fn evaluate(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        until: Until,
    ) -> Result<Evaluation, BenchError> {
        let mut evaluation = Evaluation::none(0);
        while until == Until::Done || self.is_within_reach(&evaluation) {
            if !self.evaluate_on(model, setting, round, &mut evaluation)? {
                break;
            }
        }
        Ok(evaluation)
    }

    /// Goes on with an evaluation of a round by one batch of rollouts. Returns whether there was one left.
    ///
    /// # Errors
    /// As [`Conditions::evaluate`].
    pub(crate) fn evaluate_on(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        round: u32,
        evaluation: &mut Evaluation,
    ) -> Result<bool, BenchError> {
        let done = evaluation.rate.rollouts;
        let indices: Vec<u32> = (done..self.protocol.rollouts.min(done + BATCH)).collect();
        let rollouts = indices.par_iter().map(|index| {
            self.check_interrupt()?;
            let rolled_out = self.roll_out(model, setting, (round, *index), Watched::No)?;
            Ok(rolled_out.map(|(rollout, _)| rollout))
        });
        let rollouts: Vec<Option<_>> = rollouts.collect::<Result<_, BenchError>>()?;
        for (index, rollout) in indices.iter().zip(rollouts) {
            evaluation.count(*index, rollout);
        }
        Ok(!indices.is_empty())
    }

    /// Whether the target is still met if every rollout that is left succeeds.
    fn is_within_reach(&self, evaluation: &Evaluation) -> bool {
        let failures = evaluation.rate.rollouts - evaluation.rate.successes;
        f64::from(self.protocol.rollouts - failures) >= self.protocol.target * f64::from(self.protocol.rollouts)
    }

    /// A rollout of a round, and the episode as it was left. `None` where the physics refuses the start: that is
    /// spoilt, and nobody's failure.
    pub(crate) fn roll_out(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        (round, index): (u32, u32),
        watched: Watched,
    ) -> Result<Option<(Rollout, Cursor<'a>)>, BenchError> {
        let execute = Execute { execution: self.protocol.execution, confidence: self.protocol.confidence, watched };
        let mut rng = ChaCha8Rng::seed_from_u64(self.stream(setting, "execute", &[round, index]));
        let start = || match Episode::start(setting, self.stream(setting, "evaluate", &[round, index])) {
            Ok(episode) => Ok(Some(episode)),
            Err(TaskError::Premise { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        };
        let origin = Beginning { setting: setting.label(), round, index };
        let work = || {
            let Some(mut cursor) = self.memo.start(origin, start)? else { return Ok(None) };
            let rollout = rollout(model, &mut cursor, execute, &mut rng)?;
            Ok(Some((rollout, cursor)))
        };
        let steps = |result: &Result<Option<(Rollout, Cursor<'a>)>, BenchError>| match result {
            Ok(Some((_, cursor))) => cursor.steps(),
            _ => Steps::default(),
        };
        self.spend(work, steps)
    }

    /// Whether the target is met.
    pub(crate) fn is_reached(&self, evaluation: &Evaluation) -> bool {
        f64::from(evaluation.rate.successes) >= self.protocol.target * f64::from(evaluation.rate.rollouts)
    }

    /// How long the evaluation after a demonstration goes on: to its end after the last demonstration of the budget.
    pub(crate) fn until(&self, index: u32, budget: u32) -> Until {
        if index + 1 == budget { Until::Done } else { Until::OutOfReach }
    }
}
