//! The ways of doing what a primitive does (decision D20), and which of them is right in a state.

use std::collections::BTreeSet;

use super::TaskModel;
use super::node::Way;
use crate::demonstration::Kind;
use crate::error::SituError;
use crate::place::{NodeId, SampleId, SegmentId};
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::state::State;
use crate::trace::Counters;
use crate::worlds::is_in_own_world;

impl<L: Learner> TaskModel<L> {
    /// A way whose policy was fitted to these segments, of which there is at least one.
    pub fn way(&self, segments: BTreeSet<SegmentId>, policy: L::Policy) -> Way<L::Policy> {
        let wanted = segments.iter().filter_map(|segment| self.natural_start(*segment)).collect();
        let is_original = |segment: &SegmentId| self.histories[segment.demonstration as usize].kind == Kind::Original;
        let is_corrective = !segments.iter().any(is_original);
        Way { segments, policy, wanted, is_corrective }
    }

    /// The start of a segment, where it is one that a robot can come to by itself: not where somebody stepped in
    /// (decision D23). Where nobody knows how the robot came there, the start has to stand for that.
    fn natural_start(&self, segment: SegmentId) -> Option<SampleId> {
        let is_stepped_in = segment.index == 0 && !self.histories[segment.demonstration as usize].trail.is_empty();
        (!is_stepped_in).then_some(SampleId::Start(segment))
    }

    /// Makes a segment an instance of a way of a node. Its policy is fitted anew by [`TaskModel::fit_policy`].
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn adopt(&mut self, id: NodeId, way: usize, segment: SegmentId) -> Result<(), SituError> {
        let start = self.natural_start(segment);
        let node = self.node_mut(id)?;
        node.segments.insert(segment);
        node.ways[way].segments.insert(segment);
        node.ways[way].wanted.extend(start);
        Ok(())
    }

    /// Makes a segment an instance of a node, and gives the node the policy that was fitted to this segment alone as
    /// its newest way. With room for one way the old ones are gone: their segments remain instances of the node, but no
    /// longer teach a policy. Beyond `most` ways the oldest goes that a correction added.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn add_way(&mut self, id: NodeId, segment: SegmentId, policy: L::Policy, most: usize) -> Result<(), SituError> {
        let way = self.way(BTreeSet::from([segment]), policy);
        let node = self.node_mut(id)?;
        node.segments.insert(segment);
        node.ways.push(way);
        bound(&mut node.ways, most);
        self.distances.forget(id);
        Ok(())
    }

    /// Notes that a way was wanted in the state of a sample.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn want(&mut self, id: NodeId, way: usize, sample: SampleId) -> Result<(), SituError> {
        self.node_mut(id)?.ways[way].wanted.insert(sample);
        Ok(())
    }

    /// Fits the policy of a way to its segments (Update-Policy, A2.18).
    ///
    /// # Errors
    /// Where the learner refuses; [`SituError::UnknownNode`].
    pub fn fit_policy(
        &mut self,
        learner: &L,
        id: NodeId,
        way: usize,
        counters: &mut Counters,
    ) -> Result<(), SituError> {
        let segments: Vec<&Segment> = self.node(id)?.ways[way].segments.iter().map(|id| &**self.segment(*id)).collect();
        let policy = learner.fit_policy(&segments, &self.calibration, counters)?;
        self.node_mut(id)?.ways[way].policy = policy;
        self.distances.forget(id);
        Ok(())
    }

    /// The way of a node that is right in a state: the newest, unless the state is in the world of an older one. Each
    /// older way is held against the one that is right so far, the newer ones first.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn way_in(&self, id: NodeId, state: &State, scales: &[f64]) -> Result<usize, SituError> {
        let ways = &self.node(id)?.ways;
        let wanted = |way: usize| ways[way].wanted.iter().map(|sample| self.state(*sample)).collect::<Vec<&State>>();
        let mut right = ways.len() - 1;
        for older in (0..right).rev() {
            if is_in_own_world(state, &wanted(older), &wanted(right), scales) {
                right = older;
            }
        }
        Ok(right)
    }
}

/// Takes ways of one node, the oldest first, away until there are no more than `most`, which is 1 at least: the oldest
/// that a correction added, and where there is none but the newest, the oldest.
pub(super) fn bound<P>(ways: &mut Vec<Way<P>>, most: usize) {
    while ways.len() > most.max(1) {
        let older = ways.len() - 1;
        let goes = (0..older).find(|way| ways[*way].is_corrective).unwrap_or(0);
        ways.remove(goes);
    }
}
