//! What a method has learned: a task model that can be executed and corrected.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use crate::correction::Correction;
use crate::demonstration::Demonstration;
use crate::error::SituError;
use crate::graph::Graph;
use crate::keyframe::learner::Calibration;
use crate::keyframe::policy::Execution;
use crate::place::{NodeId, Place};
use crate::segment::RelativeKeyframe;
use crate::state::State;
use crate::trace::Trace;

/// What was calibrated when the originals were taught (decisions D8 and D21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// The height of the cut, nats per frame, and the scatter of the teacher.
    pub calibration: Calibration,
    /// What a cut is held to: the least and the greatest.
    pub bounds: [f64; 2],
    /// Whether there was a single original, so that the cut is that of the decision and nothing was measured.
    pub is_of_one: bool,
}

/// A task model that a method keeps up to date, and that can be executed.
///
/// A model may be held by another program, which can fail at any question: [`SituError::Outside`].
pub trait Learned: Send + Sync {
    /// Folds a correction in, all of it or nothing.
    ///
    /// # Errors
    /// Where what is said to have run cannot have run, the states are of another schema, or the learner refuses a
    /// segment. The model is then as it was before.
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError>;

    /// The places that may follow `last` in `state`, each with its probability, the most probable first: what an
    /// executor tries in turn where one of them fails. Some methods know the first alone.
    ///
    /// # Errors
    /// [`SituError::Outside`].
    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError>;

    /// The place that most probably follows `last` in `state`, and its probability; `None` where no place follows.
    ///
    /// # Errors
    /// As [`Learned::ranked`].
    fn next(&self, last: Place, state: &State) -> Result<Option<(Place, f64)>, SituError> {
        Ok(self.ranked(last, state)?.first().copied())
    }

    /// The ways of doing what a primitive does, by number: the one that is right in `state` first, then the others, the
    /// newest first. By default there is one, number 0.
    ///
    /// # Errors
    /// [`SituError::Outside`].
    fn ways(&self, _node: NodeId, _state: &State) -> Result<Vec<usize>, SituError> {
        Ok(vec![0])
    }

    /// The reference object of a primitive, and the keyframes of one execution of this way of it in `state`, relative
    /// to that object.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`]; [`SituError::Outside`].
    fn keyframes(
        &self,
        node: NodeId,
        way: usize,
        state: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError>;

    /// What was calibrated when the originals were taught; `None` where nothing was.
    fn calibrated(&self) -> Option<Calibrated> {
        None
    }

    /// How well the primitives explain a demonstration that was held out: for each of its segments, as the method cuts
    /// it, the number of keyframes and their greatest log-likelihood under the policy of a primitive about the
    /// segment's reference object, nats. `None` stands where no primitive is about that object, or none can explain the
    /// segment at all. A method whose policies are no densities has no segments.
    fn held_out(&self, _demonstration: &Demonstration) -> Vec<(usize, Option<f64>)> {
        Vec::new()
    }

    /// The structure.
    ///
    /// # Errors
    /// [`SituError::Outside`].
    fn graph(&self) -> Result<Graph, SituError>;

    /// A copy.
    fn boxed(&self) -> Box<dyn Learned>;

    /// The whole model, every number of it: equal models give equal text.
    fn to_json(&self) -> serde_json::Value;
}
