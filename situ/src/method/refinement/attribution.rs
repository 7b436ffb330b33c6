//! Which primitive a segment of a correction is about.

use crate::decisions::Modify;
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::mending::{first_near, suspects};
use crate::place::{NodeId, Place};
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::task_model::TaskModel;
use crate::trace::Counters;

/// The original automaton, and the rule by which a segment is attributed to one of its primitives.
pub struct Attribution<'a> {
    /// The original automaton.
    pub model: &'a TaskModel<KeyframeLearner>,
    /// What fits and compares policies.
    pub learner: &'a KeyframeLearner,
    /// The rule of decision D18.
    pub rule: &'a Modify,
}

impl Attribution<'_> {
    /// The primitive that a segment shows another way of doing, by the rule of decision D18. `None` if there is no such
    /// primitive.
    ///
    /// The candidates are, in this order: the primitive that was interrupted, the most probable child of `last` if it
    /// is probable enough, and `last` itself. The first candidate wins that has the segment's reference object and is
    /// not too far from the segment, by the divergence of `situ`. The comparison is always with the *original* policy:
    /// the automaton never changes, so a segment is attributed to the same primitive after any earlier corrections. A
    /// policy is fitted to the segment only if a candidate is on its object.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`], or if no policy can be fitted to the segment.
    pub fn of(
        &self,
        last: Place,
        interrupted: Option<NodeId>,
        segment: &Segment,
        counters: &mut Counters,
    ) -> Result<Option<NodeId>, SituError> {
        let suspects = suspects(self.model, last, interrupted, segment, self.rule)?;
        if suspects.is_empty() {
            return Ok(None);
        }
        let own = self.learner.fit_policy(&[segment], counters)?;
        first_near(self.model, &suspects, &own, self.learner, self.rule, counters)
    }
}
