//! Which primitive a segment of a correction is about.

use crate::decisions::Modify;
use crate::demonstration::Segment;
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::place::{NodeId, Place};
use crate::primitive::Learner;
use crate::task_model::TaskModel;
use crate::trace::Counters;

/// The primitive that a segment shows another way of doing, by the rule of decision D18; none where there is no such primitive.
///
/// The candidates, in this order: the primitive that was interrupted, the most probable child of `last` if it is probable enough, and
/// `last` itself. The first is taken that has the segment's reference object and is not too far from the segment, in the divergence that
/// `situ` uses. It is always the *original* policy that is compared: the automaton is never changed, so the same segment is about
/// the same primitive, whatever was corrected before. A policy is fitted to the segment only where a candidate is on its object.
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
    let children: Vec<Place> = model.children(last).filter(|child| matches!(child, Place::Node(_))).collect();
    counters.classifier_evaluations += children.len() as u64;
    let likely = children
        .into_iter()
        .map(|child| (model.probability(child, &segment.start), child))
        .reduce(|best, other| if other.0 > best.0 { other } else { best })
        .filter(|(probability, _)| *probability >= rule.min_probability)
        .map(|(_, child)| child);
    let mut own = None;
    for place in interrupted.map(Place::Node).into_iter().chain(likely).chain([last]) {
        let Place::Node(id) = place else { continue };
        let node = model.node(id)?;
        if node.reference != segment.reference {
            continue;
        }
        let own = match &own {
            Some(policy) => policy,
            None => own.insert(learner.fit_policy(&[segment], counters)?),
        };
        if learner.distance(&node.policy, own, counters) <= rule.max_distance {
            return Ok(Some(id));
        }
    }
    Ok(None)
}
