//! Evaluations: a model's rollouts on a setting, from fresh starts.

use std::collections::BTreeMap;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use situ::method::Learned;
use situ_tasks::{Episode, Setting, TaskError};

use crate::calibration::Choice;
use crate::conditions::Conditions;
use crate::ended::Ended;
use crate::error::BenchError;
use crate::memo::{Beginning, Cursor};
use crate::observer::Observer;
use crate::protocol::{Corrections, Protocol};
use crate::rollout::{Execute, Rollout, Watched, rollout};
use crate::spending::Steps;
use crate::starts::Starts;
use crate::tally::Rate;

/// Rollouts between two looks at whether the target is out of reach. The number is fixed: the rollouts must not
/// depend on the number of threads.
const BATCH: u32 = 2;

/// A model's rollouts on a setting.
#[derive(Clone)]
pub struct Evaluation {
    /// Successes among the rollouts whose physics was sound.
    pub(crate) rate: Rate,
    /// Rollouts, sound or not.
    begun: u32,
    /// How the rollouts ended, by name.
    pub(crate) ended: BTreeMap<String, u32>,
    /// The rollouts that failed.
    pub(crate) failures: Vec<u32>,
    /// What the executor had to choose in them.
    pub(crate) choices: Vec<Choice>,
    /// Whether the physics of one of them was no longer sound.
    pub(crate) spoilt: bool,
}

impl Evaluation {
    /// An evaluation of so many rollouts without a success.
    pub(crate) fn none(rollouts: u32) -> Self {
        let rate = Rate { rollouts, ..Rate::default() };
        Self { rate, begun: rollouts, ended: BTreeMap::new(), failures: Vec::new(), choices: Vec::new(), spoilt: false }
    }

    /// The rollouts from which a teacher may correct: those that failed, or any where the robot is corrected whether it
    /// fails or not.
    pub(crate) fn correctable(&self, corrections: Corrections) -> Vec<u32> {
        match corrections {
            Corrections::UntilReached => self.failures.clone(),
            Corrections::Once => (0..self.begun).collect(),
        }
    }

    /// Counts a rollout. `None` is a rollout whose start the physics refused. What physics spoilt is nobody's failure.
    fn count(&mut self, index: u32, rollout: Option<Rollout>) {
        self.begun += 1;
        let Some(rollout) = rollout.filter(|rollout| rollout.ended != Ended::Spoilt) else {
            self.spoilt = true;
            return;
        };
        self.rate.rollouts += 1;
        let how = if rollout.success { "success".to_owned() } else { format!("failure: {}", rollout.ended) };
        *self.ended.entry(how).or_default() += 1;
        self.rate.once += u32::from(rollout.once);
        self.choices.extend(rollout.choices);
        if rollout.success {
            self.rate.successes += 1;
        } else {
            self.failures.push(index);
        }
    }
}

impl<'a> Conditions<'a> {
    /// Rolls the model out from the starts of a round, to decide whether the target is met. It stops after the batch in
    /// which the target went out of reach: it then tells that the model must be corrected further, and not how well it
    /// does.
    ///
    /// # Errors
    /// An error of the task or the method; [`BenchError::OutOfSteps`]; [`BenchError::Interrupted`].
    pub fn decide(&self, model: &dyn Learned, setting: &Arc<Setting>, round: u32) -> Result<Evaluation, BenchError> {
        let mut evaluation = Evaluation::none(0);
        while self.is_within_reach(&evaluation)
            && self.evaluate_on(model, setting, Starts::Round(round), &mut evaluation)?
        {}
        Ok(evaluation)
    }

    /// Rolls the model out from fresh starts, by which nothing is decided: all rollouts of the protocol.
    ///
    /// # Errors
    /// As [`Conditions::decide`].
    pub fn evaluate(&self, model: &dyn Learned, setting: &Arc<Setting>) -> Result<Evaluation, BenchError> {
        let mut evaluation = Evaluation::none(0);
        while self.evaluate_on(model, setting, Starts::Fresh, &mut evaluation)? {}
        Ok(evaluation)
    }

    /// Goes on with an evaluation by one batch of rollouts. Returns whether there was one left.
    ///
    /// # Errors
    /// As [`Conditions::decide`].
    pub(crate) fn evaluate_on(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        starts: Starts,
        evaluation: &mut Evaluation,
    ) -> Result<bool, BenchError> {
        self.check_steps()?;
        let done = evaluation.begun;
        let indices: Vec<u32> = (done..self.protocol.rollouts.min(done + BATCH)).collect();
        let rollouts = indices.par_iter().map(|index| {
            self.check_interrupt()?;
            let rolled_out = self.roll_out(model, setting, (starts, *index), Watched::No, &mut ())?;
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

    /// A rollout from one of these starts, and the episode as it was left. `None` where the physics refuses the start:
    /// that is spoilt, and nobody's failure. The observer sees what the memo does not have.
    pub(crate) fn roll_out(
        &self,
        model: &dyn Learned,
        setting: &Arc<Setting>,
        (starts, index): (Starts, u32),
        watched: Watched,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Rollout, Cursor<'a>)>, BenchError> {
        let Protocol { execution, confidence, executor, .. } = self.protocol;
        let execute = Execute { execution: *execution, confidence: *confidence, executor: *executor, watched };
        let mut rng = ChaCha8Rng::seed_from_u64(self.rollout_stream(setting, "execute", (starts, index)));
        let origin = Beginning { setting: setting.label(), starts, index };
        let work = || {
            let start = self.memo.start(origin, || self.start(setting, (starts, index)))?;
            let Some(mut cursor) = start else { return Ok(None) };
            let rollout = rollout(model, &mut cursor, execute, &mut rng, observer)?;
            Ok(Some((rollout, cursor)))
        };
        let steps = |result: &Result<Option<(Rollout, Cursor<'a>)>, BenchError>| match result {
            Ok(Some((_, cursor))) => cursor.steps(),
            _ => Steps::default(),
        };
        self.spend(work, steps)
    }

    /// The seed of a draw at a rollout.
    fn rollout_stream(&self, setting: &Setting, purpose: &str, (starts, index): (Starts, u32)) -> u64 {
        let (purpose, numbers) = starts.stream(purpose, index);
        self.stream(setting, &purpose, &numbers)
    }

    /// Where a rollout begins. `None` where the physics refuses it.
    pub(crate) fn start(&self, setting: &Arc<Setting>, start: (Starts, u32)) -> Result<Option<Episode>, BenchError> {
        match Episode::start(setting, self.rollout_stream(setting, "evaluate", start)) {
            Ok(episode) => Ok(Some(episode)),
            Err(TaskError::Premise { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Whether the target is met.
    pub(crate) fn is_reached(&self, evaluation: &Evaluation) -> bool {
        let Rate { successes, rollouts, .. } = evaluation.rate;
        rollouts > 0 && f64::from(successes) >= self.protocol.target * f64::from(rollouts)
    }
}

#[cfg(test)]
mod tests {
    use situ::place::Place;

    use super::*;

    #[test]
    fn what_physics_spoilt_is_nobody_s_failure() {
        let rolled_out = |ended, success| {
            let (last, trail, choices) = (Place::Start, Vec::new(), Vec::new());
            Some(Rollout { ended, last, interrupted: None, success, once: success, primitives: 0, trail, choices })
        };
        let mut evaluation = Evaluation::none(0);
        let rollouts =
            [rolled_out(Ended::End, true), None, rolled_out(Ended::Spoilt, false), rolled_out(Ended::End, false)];
        rollouts.into_iter().zip(0..).for_each(|(rollout, index)| evaluation.count(index, rollout));
        assert_eq!(evaluation.rate, Rate { successes: 1, once: 1, rollouts: 2 });
        assert_eq!((evaluation.begun, evaluation.spoilt, evaluation.failures), (4, true, vec![3]));
    }
}
