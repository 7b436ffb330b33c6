//! Full retraining that can modify: all segments are clustered at once, and the corrections are then gone through in
//! the order in which they were given, so that what was shown later can replace what was shown before.
//!
//! `rebuild` differs from `situ` in one thing: which segments are one primitive is decided globally, not among the
//! primitives that are applicable. Whether a segment shows another way of a primitive is decided by SITU's own rule.
//! `rebuild:recency` has a plainer rule: within a cluster the newest of two ways that differ is the one.

use std::collections::BTreeMap;

use super::rebuild::{assemble, retrain_classifiers};
use crate::decisions::Decisions;
use crate::demonstration::Kind;
use crate::error::SituError;
use crate::matching::{Clusters, Match};
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::placement::Placement;
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::task_model::{History, TaskModel};
use crate::trace::{Counters, MatchedIn, Trace};
use crate::update::Update;

/// What a later way of doing a thing does to an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Later {
    /// It replaces it where SITU would say so (decision D18).
    AsSitu,
    /// It replaces it where both are in one cluster and differ by as much as decision D18 asks for.
    Replaces,
}

/// Builds a task model from all demonstrations at once, corrections in their order.
///
/// # Errors
/// [`SituError::NoDemonstration`], or where the learner refuses a segment.
pub fn replay<L: Learner>(
    histories: Vec<History>,
    calibration: L::Calibration,
    learner: &L,
    decisions: &Decisions,
    later: Later,
) -> Result<(TaskModel<L>, Trace), SituError> {
    let mut counters = Counters::default();
    let pooled: Vec<&Segment> =
        histories.iter().flat_map(|history| &history.segments).map(|segment| &**segment).collect();
    let labels = learner.cluster(&pooled, &calibration, &mut counters)?;
    let (whole, corrections): (Vec<_>, Vec<_>) =
        histories.into_iter().partition(|history| history.kind == Kind::Original);
    let taught = whole.iter().map(|history| history.segments.len()).sum();
    let ids = (0..).zip(&whole).flat_map(|(demonstration, history)| {
        (0..history.segments.len() as u32).map(move |index| SegmentId { demonstration, index })
    });
    let mut clusters = ByCluster { labels: &labels[taught..], first: BTreeMap::new(), later };
    for (id, label) in ids.zip(&labels) {
        clusters.first.entry(*label).or_insert(id);
    }
    let (mut model, trace) = assemble(whole, &labels[..taught], calibration, learner, decisions, counters)?;
    let mut counters = trace.counters;
    for history in corrections {
        let last = history.after.and_then(|segment| model.node_of(segment)).map_or(Place::Start, Place::Node);
        let count = history.segments.len();
        let mut update = Update::new(&mut model, learner, decisions);
        update.fold(last, history, &mut clusters)?;
        counters += update.into_trace().counters;
        clusters.labels = &clusters.labels[count..];
    }
    // Every policy is an exact fit by now. The negatives were gathered in order, and full retraining knows them all.
    model.forget_negatives();
    retrain_classifiers(&mut model, learner, decisions, &mut counters)?;
    Ok((model, Trace { counters, ..Trace::default() }))
}

/// Places the segments of a correction by the global clusters.
struct ByCluster<'a> {
    /// The clusters of the segments that are still to be placed, by number, this correction's first.
    labels: &'a [usize],
    /// The first segment of each cluster.
    first: BTreeMap<usize, SegmentId>,
    later: Later,
}

impl<L: Learner> Placement<L> for ByCluster<'_> {
    fn applicable(&mut self, _: &mut Update<'_, L>, _: SampleId) -> Vec<NodeId> {
        Vec::new()
    }

    fn cluster(&mut self, update: &mut Update<'_, L>, segment: SegmentId, _: &[NodeId]) -> Result<Clusters, SituError> {
        let label = self.labels[segment.index as usize];
        let instance_of = update.model.node_of(*self.first.entry(label).or_insert(segment));
        Ok(Clusters { instance_of, groups: Vec::new(), matched_in: MatchedIn::None, compared: 0 })
    }

    fn follower(&mut self, update: &mut Update<'_, L>, segment: SegmentId) -> Result<Option<NodeId>, SituError> {
        let first = self.first.get(&self.labels[segment.index as usize]);
        Ok(first.and_then(|first| update.model.node_of(*first)))
    }

    fn find_policy(
        &mut self,
        update: &mut Update<'_, L>,
        a: Place,
        segment: SegmentId,
        instance_of: Option<NodeId>,
    ) -> Result<Option<Match>, SituError> {
        let (Later::Replaces, Some(rule)) = (self.later, update.decisions.modify) else {
            return update.mend_match(a, segment, instance_of, self);
        };
        let Some(node) = instance_of else { return Ok(None) };
        update.with_own_policy(segment, |update, own| update.shown_of(node, own, &rule, true).map(Some))
    }
}
