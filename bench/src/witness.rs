//! Who sees how a robot is corrected, so that it can be shown afterwards.

use situ::error::SituError;
use situ::method::Learned;
use situ_tasks::Episode;

use crate::evaluation::Evaluation;
use crate::lesson::Lesson;

/// A correction at the moment at which it was given.
pub struct Intervened<'a> {
    /// The round of corrections, from 0.
    pub round: u32,
    /// The rollout that failed, among those of the round.
    pub index: u32,
    /// Why the robot was stopped, in the ledger's words.
    pub trigger: &'a str,
    /// The episode as the teacher found it.
    pub episode: &'a Episode,
    /// The demonstration's name.
    pub name: &'a str,
    /// The seed of the teacher's draws.
    pub seed: u64,
}

/// Sees how a robot is corrected. It changes nothing.
pub trait Witness {
    /// The robot has not been corrected yet. The evaluation decides whether it is.
    ///
    /// # Errors
    /// Those of the model.
    fn begins(&mut self, _model: &dyn Learned, _lesson: &Lesson, _before: &Evaluation) -> Result<(), SituError> {
        Ok(())
    }
    /// The teacher has shown a correction that the robot is given.
    fn corrects(&mut self, _intervened: &Intervened<'_>) {}
    /// The robot is corrected no further.
    ///
    /// # Errors
    /// Those of the model.
    fn ends(&mut self, _model: &dyn Learned, _lesson: &Lesson) -> Result<(), SituError> {
        Ok(())
    }
}

/// Nobody.
impl Witness for () {}
