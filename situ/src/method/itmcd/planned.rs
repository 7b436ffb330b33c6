//! Where the segments of a correction belong, by the edits that were chosen.

use std::collections::{BTreeMap, BTreeSet};

use super::candidate::Candidate;
use super::selection::Plan;
use crate::error::SituError;
use crate::matching::{Clusters, Match, Shows};
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::placement::Placement;
use crate::primitive::Learner;
use crate::trace::MatchedIn;
use crate::update::Update;

/// A plan under way.
pub(super) struct Planned<'a> {
    /// The planned node of each segment.
    nodes: &'a [NodeId],
    /// Candidates that were weighed.
    candidates: usize,
    /// Nodes that are still to be modified.
    modified: BTreeSet<NodeId>,
    /// Planned nodes that are not made. A node in which no segment is placed is never made.
    unmade: BTreeSet<NodeId>,
    /// The ids of planned nodes that were made: those behind a node that is not made move up.
    made: BTreeMap<NodeId, NodeId>,
    /// The segments that the policies of modified nodes were fitted to.
    pub(super) retired: Vec<(NodeId, BTreeSet<SegmentId>)>,
}

impl<'a> Planned<'a> {
    pub(super) fn new(plan: &Plan, nodes: &'a [NodeId]) -> Self {
        let (mut modified, mut unmade) = (BTreeSet::new(), BTreeSet::new());
        for edit in plan.edits() {
            match edit {
                Candidate::Modify { node, .. } => modified.insert(node),
                Candidate::Node { new, .. } => unmade.insert(new),
                Candidate::Nothing | Candidate::Edge { .. } => continue,
            };
        }
        let candidates = plan.rounds.iter().map(|round| round.evaluations.len()).sum();
        Self { nodes, candidates, modified, unmade, made: BTreeMap::new(), retired: Vec::new() }
    }

    /// The place that a planned place has become; `None` for a node that was not made.
    pub(super) fn actual(&self, place: Place) -> Option<Place> {
        match place {
            Place::Node(name) if self.unmade.contains(&name) => None,
            Place::Node(name) => Some(Place::Node(self.made.get(&name).copied().unwrap_or(name))),
            other => Some(other),
        }
    }
}

impl<L: Learner> Placement<L> for Planned<'_> {
    /// All of them: the model is not indexed, and the edits of every primitive were weighed.
    fn applicable(&mut self, update: &mut Update<'_, L>, _: SampleId) -> Vec<NodeId> {
        update.model.nodes().map(|(id, _)| id).collect()
    }

    fn cluster(&mut self, _: &mut Update<'_, L>, segment: SegmentId, _: &[NodeId]) -> Result<Clusters, SituError> {
        let planned = self.nodes[segment.index as usize];
        let matched_in = if self.unmade.contains(&planned) { MatchedIn::None } else { MatchedIn::Reference };
        Ok(Clusters { matched_in, compared: self.candidates, ..Clusters::default() })
    }

    fn find_policy(
        &mut self,
        update: &mut Update<'_, L>,
        _: Place,
        segment: SegmentId,
        _: Option<NodeId>,
    ) -> Result<Option<Match>, SituError> {
        let planned = self.nodes[segment.index as usize];
        // A node that this correction makes has no older way to replace.
        let replaces = self.modified.remove(&planned);
        if self.unmade.remove(&planned) {
            self.made.insert(planned, update.model.next_id());
            return Ok(None);
        }
        let node = self.made.get(&planned).copied().unwrap_or(planned);
        if replaces {
            self.retired.push((node, update.model.node(node)?.newest().segments.clone()));
            return Ok(Some(Match { node, shows: Shows::AnotherWay }));
        }
        Ok(Some(Match { node, shows: Shows::Way(0) }))
    }
}
