//! Local-Reconnect: nodes merged, and connected by the traversal histories of their data.

use std::collections::{BTreeMap, BTreeSet};

use super::TaskModel;
use super::node::Way;
use super::ways::bound;
use crate::decisions::Decisions;
use crate::error::SituError;
use crate::place::{NodeId, Place, Samples, SegmentId};
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::trace::Counters;

impl<L: Learner> TaskModel<L> {
    /// Local-Reconnect (A2.3): replaces each group of nodes by one node, retrained on the group's data and connected
    /// by the traversal histories of that data. Of their ways a merged node keeps no more than a node may have
    /// (decision D20). Returns the new id of each node that is gone (decision D9).
    ///
    /// # Errors
    /// Where the learner refuses, or a node is not in the model.
    pub fn local_reconnect(
        &mut self,
        learner: &L,
        groups: &[Vec<NodeId>],
        decisions: &Decisions,
        counters: &mut Counters,
    ) -> Result<BTreeMap<NodeId, NodeId>, SituError> {
        let mut renamed = BTreeMap::new();
        for group in groups {
            let mut segments = BTreeSet::new();
            let mut samples = Samples::default();
            for id in group {
                let node = self.node(*id)?;
                segments.extend(&node.segments);
                samples.positives.extend(&node.samples.positives);
                samples.negatives.extend(&node.samples.negatives);
            }
            if decisions.subtract_own_positives {
                samples.negatives = samples.negatives.difference(&samples.positives).copied().collect();
            }
            let mut ways = self.merged_ways(learner, group, counters)?;
            bound(&mut ways, decisions.ways.most());
            let classifier = self.fit_samples(learner, &samples, counters)?;
            counters.nodes_touched += group.len() as u64 + 1;
            for id in group {
                self.remove(*id);
            }
            let touched = segments.clone();
            let merged = self.add_node(segments, ways, samples, classifier);
            for segment in &touched {
                self.histories[segment.demonstration as usize].nodes[segment.index as usize] = merged;
            }
            self.connect_by_history(&touched);
            renamed.extend(group.iter().map(|id| (*id, merged)));
        }
        Ok(renamed)
    }

    /// The ways of a merged node, the oldest first. Of each node the way that is nearest to what there is already
    /// becomes one with it, and its policy is fitted anew; the others stand beside it. The ways of one node never
    /// merge.
    fn merged_ways(
        &self,
        learner: &L,
        group: &[NodeId],
        counters: &mut Counters,
    ) -> Result<Vec<Way<L::Policy>>, SituError> {
        let mut all: Vec<Way<L::Policy>> = Vec::new();
        let mut pooled = BTreeSet::new();
        for id in group {
            let mut ways = self.node(*id)?.ways.clone();
            if !all.is_empty() {
                let (old, new) = self.nearest_pair(learner, &all, &ways, counters);
                let joins = ways.remove(new);
                all[old].segments.extend(&joins.segments);
                all[old].wanted.extend(&joins.wanted);
                all[old].is_corrective &= joins.is_corrective;
                pooled.insert(old);
            }
            all.append(&mut ways);
        }
        for way in pooled {
            let data: Vec<&Segment> = all[way].segments.iter().map(|id| &**self.segment(*id)).collect();
            all[way].policy = learner.fit_policy(&data, &self.calibration, counters)?;
        }
        all.sort_by_key(|way| way.segments.first().copied());
        Ok(all)
    }

    /// The indices of the two ways, one of each list, whose policies are nearest; the first where they tie.
    fn nearest_pair(
        &self,
        learner: &L,
        left: &[Way<L::Policy>],
        right: &[Way<L::Policy>],
        counters: &mut Counters,
    ) -> (usize, usize) {
        if left.len() == 1 && right.len() == 1 {
            return (0, 0);
        }
        let mut nearest = (f64::INFINITY, (0, 0));
        for (one, own) in left.iter().enumerate() {
            for (two, other) in right.iter().enumerate() {
                let distance = learner.distance(&own.policy, &other.policy, Some(&self.calibration), counters);
                if distance < nearest.0 {
                    nearest = (distance, (one, two));
                }
            }
        }
        nearest.1
    }

    fn remove(&mut self, id: NodeId) {
        let place = Place::Node(id);
        let out = self.children(place).map(|child| (place, child));
        let edges: BTreeSet<(Place, Place)> = out.chain(self.parents(place).map(|parent| (parent, place))).collect();
        for (from, to) in edges {
            self.edges.remove(from, to);
            if let Some(journal) = &mut self.journal {
                journal.edges.push((from, to, false));
            }
        }
        self.keep(id);
        self.take_out(id);
    }

    /// Adds the edges into and out of these segments' nodes that the histories hold.
    pub fn connect_by_history(&mut self, segments: &BTreeSet<SegmentId>) {
        let mut edges = BTreeSet::new();
        let node = |id: SegmentId| self.node_of(id).map(Place::Node);
        for id in segments {
            let Some(here) = node(*id) else { continue };
            let history = &self.histories[id.demonstration as usize];
            let before = match id.index.checked_sub(1) {
                Some(index) => node(SegmentId { index, ..*id }),
                None => history.after.map_or(Some(Place::Start), node),
            };
            edges.extend(before.map(|before| (before, here)));
            let next = SegmentId { index: id.index + 1, ..*id };
            if next.index as usize == history.segments.len() {
                edges.extend(history.carried_to_end.then_some((here, Place::End)));
            } else {
                edges.extend(node(next).map(|next| (here, next)));
            }
            for follower in self.followers.get(id).into_iter().flatten() {
                let first = SegmentId { demonstration: *follower, index: 0 };
                edges.extend(node(first).map(|first| (here, first)));
            }
        }
        for (from, to) in edges {
            self.add_edge(from, to);
        }
    }
}
