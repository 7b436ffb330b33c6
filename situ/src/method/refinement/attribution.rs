//! Which primitive a segment of a correction is about.

use crate::decisions::Modify;
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::policy::KeyframePolicy;
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
        let own = self.learner.fit_policy(&[segment], self.model.calibration(), counters)?;
        first_near(self.model, &suspects, &own, self.learner, self.rule, counters)
    }
}

/// The primitives that the segment can show another way of doing, in this order: the one that was interrupted, the
/// most probable child of `a` if it is probable enough, and `a` itself. Only primitives on the segment's object count.
///
/// # Errors
/// [`SituError::UnknownNode`].
fn suspects(
    model: &TaskModel<KeyframeLearner>,
    a: Place,
    interrupted: Option<NodeId>,
    segment: &Segment,
    rule: &Modify,
) -> Result<Vec<NodeId>, SituError> {
    let nodes = model.children(a).filter(|child| matches!(child, Place::Node(_)));
    let likely = nodes
        .map(|child| (model.probability(child, &segment.start), child))
        .reduce(|best, other| if other.0 > best.0 { other } else { best });
    let likely = likely.filter(|(probability, _)| *probability >= rule.min_probability).map(|(_, child)| child);
    let mut suspects = Vec::new();
    for place in interrupted.map(Place::Node).into_iter().chain(likely).chain([a]) {
        if let Place::Node(y) = place
            && model.node(y)?.reference == segment.reference
        {
            suspects.push(y);
        }
    }
    Ok(suspects)
}

/// The first of the suspects whose policy is not too far from the segment's own.
///
/// # Errors
/// [`SituError::UnknownNode`].
fn first_near(
    model: &TaskModel<KeyframeLearner>,
    suspects: &[NodeId],
    own: &KeyframePolicy,
    learner: &KeyframeLearner,
    rule: &Modify,
    counters: &mut Counters,
) -> Result<Option<NodeId>, SituError> {
    for y in suspects {
        if learner.distance(&model.node(*y)?.newest().policy, own, None, counters) <= rule.max_distance {
            return Ok(Some(*y));
        }
    }
    Ok(None)
}
