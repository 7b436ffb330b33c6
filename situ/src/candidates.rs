//! Cluster and Find-Policy over the candidates of a segment (A2.2 and A2.4 together; decisions D4 and D10).

use std::collections::BTreeSet;

use crate::decisions::{Candidates, Decisions};
use crate::demonstration::Segment;
use crate::error::SituError;
use crate::place::NodeId;
use crate::primitive::{Initiation, Learner};
use crate::task_model::TaskModel;
use crate::trace::{Counters, MatchedIn};

/// What was found for a segment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// A node of the segment's cluster: the one whose policy it is an instance of; `None` is the listing's `∅`.
    pub node: Option<NodeId>,
    /// Groups of two or more nodes that belong together, the segment's own among them.
    pub groups: Vec<Vec<NodeId>>,
    /// Where the match was found.
    pub matched_in: MatchedIn,
    /// How many nodes were compared with the segment.
    pub compared: usize,
}

/// Clusters the segment with its candidates: those in `applicable` first, and where none of them matches, others of its
/// reference object (decision D10).
///
/// `own` is the policy fitted to the segment alone.
///
/// # Errors
/// [`SituError::UnknownNode`] where `applicable` names a node that is not in the model.
pub fn find<L: Learner>(
    model: &mut TaskModel<L>,
    segment: &Segment,
    own: &L::Policy,
    applicable: &[NodeId],
    learner: &L,
    decisions: &Decisions,
    counters: &mut Counters,
) -> Result<Found, SituError> {
    let indexed: Vec<NodeId> = match decisions.candidates {
        Candidates::Applicable => applicable.to_vec(),
        Candidates::ReferenceFallback(_) => {
            let of_object: BTreeSet<NodeId> = model.nodes_of(&segment.reference).collect();
            applicable.iter().copied().filter(|id| of_object.contains(id)).collect()
        }
        Candidates::All => model.nodes().map(|(id, _)| id).collect(),
    };
    let found = among(model, own, &indexed, learner, decisions, counters)?;
    let Candidates::ReferenceFallback(limit) = decisions.candidates else { return Ok(found) };
    if found.node.is_some() {
        return Ok(found);
    }
    let mut others: Vec<(f64, NodeId)> = Vec::new();
    for id in model.nodes_of(&segment.reference).filter(|id| !indexed.contains(id)) {
        counters.classifier_evaluations += 1;
        others.push((-model.node(id)?.classifier.probability(&segment.start), id));
    }
    others.sort_by(|left, right| left.0.total_cmp(&right.0).then(left.1.cmp(&right.1)));
    let others: Vec<NodeId> = others.into_iter().take(limit).map(|(_, id)| id).collect();
    let fallback = among(model, own, &others, learner, decisions, counters)?;
    // Outside of Z only the segment's own cluster counts: redundancy elsewhere is not this update's business.
    let own = fallback.groups.into_iter().filter(|group| fallback.node.is_some_and(|node| group.contains(&node)));
    Ok(Found {
        node: fallback.node,
        groups: found.groups.into_iter().chain(own).collect(),
        matched_in: if fallback.node.is_some() { MatchedIn::Reference } else { MatchedIn::None },
        compared: found.compared + fallback.compared,
    })
}

fn among<L: Learner>(
    model: &mut TaskModel<L>,
    own: &L::Policy,
    candidates: &[NodeId],
    learner: &L,
    decisions: &Decisions,
    counters: &mut Counters,
) -> Result<Found, SituError> {
    let mut candidates = candidates.to_vec();
    candidates.sort_unstable();
    candidates.dedup();
    if candidates.is_empty() {
        return Ok(Found { node: None, groups: Vec::new(), matched_in: MatchedIn::None, compared: 0 });
    }
    let known = model.distances_among(learner, &candidates, counters)?;
    let policies = candidates.iter().map(|id| Ok(&model.node(*id)?.policy)).collect::<Result<Vec<_>, SituError>>()?;
    let clustering = learner.cluster_and_find(own, &policies, &known, model.calibration(), counters);
    let ids = |indices: &[usize]| indices.iter().map(|index| candidates[*index]).collect::<Vec<_>>();
    let mut groups = Vec::new();
    if decisions.merge_redundant {
        groups.extend(clustering.redundant.iter().map(|group| ids(group)));
    }
    if clustering.matched.len() > 1 {
        groups.push(ids(&clustering.matched));
    }
    let node = clustering.matched.first().map(|index| candidates[*index]);
    let matched_in = if node.is_some() { MatchedIn::Index } else { MatchedIn::None };
    Ok(Found { node, groups, matched_in, compared: candidates.len() })
}
