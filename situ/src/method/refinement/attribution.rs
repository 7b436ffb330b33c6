//! Which primitive a segment of a correction is about.

use crate::decisions::Modify;
use crate::demonstration::Segment;
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::place::{NodeId, Place};
use crate::primitive::Learner;
use crate::situ::{near_enough, suspects};
use crate::task_model::TaskModel;
use crate::trace::Counters;

/// The primitive that a segment shows another way of doing, by the rule of decision D18; none where there is no such
/// primitive.
///
/// The candidates, in this order: the primitive that was interrupted, the most probable child of `last` if it is
/// probable enough, and `last` itself. The first is taken that has the segment's reference object and is not too far
/// from the segment, in the divergence that `situ` uses. It is always the *original* policy that is compared: the
/// automaton is never changed, so the same segment is about the same primitive, whatever was corrected before. A policy
/// is fitted to the segment only where a candidate is on its object.
///
/// # Errors
/// [`SituError::UnknownNode`], or where no policy can be fitted to the segment.
pub fn attribute(
    model: &TaskModel<KeyframeLearner>,
    learner: &KeyframeLearner,
    rule: &Modify,
    last: Place,
    interrupted: Option<NodeId>,
    segment: &Segment,
    counters: &mut Counters,
) -> Result<Option<NodeId>, SituError> {
    let suspects = suspects(model, last, interrupted, segment, rule)?;
    if suspects.is_empty() {
        return Ok(None);
    }
    let own = learner.fit_policy(&[segment], counters)?;
    near_enough(model, &suspects, &own, learner, rule, counters)
}
