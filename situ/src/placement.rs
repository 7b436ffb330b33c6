//! What decides where a segment belongs: lines A1.6, A2.2 and A2.4 of the listing.
//!
//! SITU indexes the model by its classifiers and compares policies ([`ByPolicy`]). Another method may be told where
//! a segment belongs, or plan it. What follows from the answers is Algorithm 2 all the same.

use crate::error::SituError;
use crate::matching::{Clusters, Match};
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::primitive::Learner;
use crate::update::Update;

/// Decides where a segment belongs.
pub trait Placement<L: Learner> {
    /// A1.6: `Z`, the primitives that are applicable in the state of a sample. Empty where a method does not index its
    /// model.
    fn applicable(&mut self, update: &mut Update<'_, L>, state: SampleId) -> Vec<NodeId>;

    /// A2.2: Cluster. No clusters where a method does not compare policies.
    ///
    /// # Errors
    /// Where the learner refuses the segment, or `applicable` names a node that is not in the model.
    fn cluster(
        &mut self,
        update: &mut Update<'_, L>,
        segment: SegmentId,
        applicable: &[NodeId],
    ) -> Result<Clusters, SituError> {
        let _ = (update, segment, applicable);
        Ok(Clusters::default())
    }

    /// D19: the primitive that a later segment of the correction would be an instance of, as the model stands. `None`
    /// where it would be none, or a method does not look ahead.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    fn follower(&mut self, update: &mut Update<'_, L>, segment: SegmentId) -> Result<Option<NodeId>, SituError> {
        let _ = (update, segment);
        Ok(None)
    }

    /// A2.4: Find-Policy, for a segment that was shown after `a`. `instance_of` is a node of the segment's own
    /// cluster, as it is called after Local-Reconnect. `None` is the listing's `∅`.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    fn find_policy(
        &mut self,
        update: &mut Update<'_, L>,
        a: Place,
        segment: SegmentId,
        instance_of: Option<NodeId>,
    ) -> Result<Option<Match>, SituError>;
}

/// SITU: by the classifiers, then by the policies.
#[derive(Clone, Copy, Debug, Default)]
pub struct ByPolicy;

impl<L: Learner> Placement<L> for ByPolicy {
    fn applicable(&mut self, update: &mut Update<'_, L>, state: SampleId) -> Vec<NodeId> {
        update.applicable(state)
    }

    fn follower(&mut self, update: &mut Update<'_, L>, segment: SegmentId) -> Result<Option<NodeId>, SituError> {
        let applicable = update.applicable(SampleId::Start(segment));
        Ok(self.cluster(update, segment, &applicable)?.instance_of)
    }

    /// The keyframe instantiation of the paper clusters the segment's own policy together with the others, so that
    /// Cluster does the work of Find-Policy, too (decision D4). Decision D10 chooses what is compared.
    fn cluster(
        &mut self,
        update: &mut Update<'_, L>,
        segment: SegmentId,
        applicable: &[NodeId],
    ) -> Result<Clusters, SituError> {
        let candidates = update.candidates(applicable);
        let clusters = update.cluster(segment, &candidates)?;
        update.ask_further(segment, &candidates, clusters)
    }

    fn find_policy(
        &mut self,
        update: &mut Update<'_, L>,
        a: Place,
        segment: SegmentId,
        instance_of: Option<NodeId>,
    ) -> Result<Option<Match>, SituError> {
        update.mend_match(a, segment, instance_of, self)
    }
}
