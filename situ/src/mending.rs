//! The mendings: what the listing leaves open or gets wrong about the structure of an update. Each hook belongs to one
//! line of the listing; D3 serves three.
//!
//! Each hook is a decision ([`crate::decisions`]). Where the decision is switched off, its hook does nothing, and what
//! is left is the listing as printed.
//!
//! | line | decision | hook |
//! |---|---|---|
//! | A2.2 | D10: what is compared with a segment | [`Update::candidates`], [`Update::ask_further`] |
//! | A2.4, A2.18 | D18: a segment shows another way of doing it | [`Update::mend_match`] |
//! | A2.7 | D2: background negatives | [`Update::add_background`] |
//! | A2.17 | D1: a primitive's own positives; D2 | [`Update::mend_negatives`] |
//! | A2.12, A2.20, END | D3: the siblings learn where they do not begin | [`Update::tell_siblings`] |

use std::collections::BTreeSet;

use crate::decisions::{Candidates, Modify};
use crate::error::SituError;
use crate::matching::{Clusters, Match};
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::primitive::{Initiation, Learner};
use crate::segment::Segment;
use crate::task_model::TaskModel;
use crate::trace::{Counters, MatchedIn};
use crate::update::Update;

impl<L: Learner> Update<'_, L> {
    /// A2.2, D10: the primitives that a segment is compared with first.
    pub fn candidates(&self, segment: SegmentId, applicable: &[NodeId]) -> Vec<NodeId> {
        match self.decisions.candidates {
            Candidates::Applicable => applicable.to_vec(),
            Candidates::ReferenceFallback(_) => {
                let of_object: BTreeSet<NodeId> = self.model.nodes_of(&self.model.segment(segment).reference).collect();
                applicable.iter().copied().filter(|id| of_object.contains(id)).collect()
            }
            Candidates::All => self.model.nodes().map(|(id, _)| id).collect(),
        }
    }

    /// A2.2, D10: where no candidate matches, other primitives of the segment's object are compared with it, those that
    /// are most probable in its start state.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    pub fn ask_further(
        &mut self,
        segment: SegmentId,
        candidates: &[NodeId],
        found: Clusters,
    ) -> Result<Clusters, SituError> {
        let Candidates::ReferenceFallback(limit) = self.decisions.candidates else { return Ok(found) };
        if found.instance_of.is_some() {
            return Ok(found);
        }
        let shown = self.model.segment(segment).clone();
        let mut others: Vec<(f64, NodeId)> = Vec::new();
        for id in self.model.nodes_of(&shown.reference).filter(|id| !candidates.contains(id)) {
            self.counters.classifier_evaluations += 1;
            others.push((-self.model.node(id)?.classifier.probability(&shown.start), id));
        }
        others.sort_by(|left, right| left.0.total_cmp(&right.0).then(left.1.cmp(&right.1)));
        let others: Vec<NodeId> = others.into_iter().take(limit).map(|(_, id)| id).collect();
        let fallback = self.cluster(segment, &others)?;
        // Outside of Z only the segment's own cluster counts: this update does not look for redundancy elsewhere.
        let holds = |group: &Vec<NodeId>| fallback.instance_of.is_some_and(|node| group.contains(&node));
        let matched = fallback.groups.into_iter().filter(holds);
        Ok(Clusters {
            instance_of: fallback.instance_of,
            groups: found.groups.into_iter().chain(matched).collect(),
            matched_in: if fallback.instance_of.is_some() { MatchedIn::Reference } else { MatchedIn::None },
            compared: found.compared + fallback.compared,
        })
    }

    /// A2.4, D18: the primitive that a segment shows, and whether the segment replaces its policy. For a matched
    /// segment it is the match. For an unmatched one it is the first suspect whose policy is near. The segment replaces
    /// the policy where it is displaced from it; otherwise the two differ by noise alone, and the segment is one more
    /// instance.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    pub fn mend_match(
        &mut self,
        a: Place,
        segment: SegmentId,
        instance_of: Option<NodeId>,
    ) -> Result<Option<Match>, SituError> {
        let interrupted = self.interrupted.take();
        let Some(rule) = &self.decisions.modify else {
            return Ok(instance_of.map(|node| Match { node, replaces: false }));
        };
        self.with_own_policy(segment, |update, policy| {
            let Self { model, learner, counters, .. } = update;
            let node = match instance_of {
                Some(node) => Some(node),
                None => {
                    let suspects = suspects(model, a, interrupted, model.segment(segment), rule)?;
                    first_near(model, &suspects, policy, *learner, rule, counters)?
                }
            };
            let Some(node) = node else { return Ok(None) };
            let displacement = learner.displacement(&model.node(node)?.policy, policy);
            Ok(Some(Match { node, replaces: displacement >= rule.min_displacement }))
        })
    }

    /// A2.7, D2: negatives that no sibling gives.
    pub fn add_background(&self, a: Place, positives: &BTreeSet<SampleId>, negatives: &mut BTreeSet<SampleId>) {
        negatives.extend(self.model.background(self.decisions.background, [a].into_iter(), positives));
    }

    /// A2.17, D1 and D2: `z` is a child of each of its parents, so the printed negatives hold its own positives; these
    /// are taken out. The states in which `a` begins are added.
    pub fn mend_negatives(&self, a: Place, z: NodeId, negatives: &mut BTreeSet<SampleId>) {
        if self.decisions.background.neighbours {
            negatives.extend(self.model.starts([a].into_iter()));
        }
        if self.decisions.subtract_own_positives {
            let positives = self.model.starts([Place::Node(z)].into_iter());
            negatives.retain(|sample| !positives.contains(sample));
        }
    }

    /// A2.12, A2.20 and END, D3: `place` has begun after `a` in the state of a sample. The other children of `a`, END
    /// among them, learn that they do not begin there.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub fn tell_siblings(&mut self, a: Place, place: Place, state: SampleId) -> Result<(), SituError> {
        if !self.decisions.push_to_siblings {
            return Ok(());
        }
        let siblings: BTreeSet<Place> = self.model.children(a).filter(|child| *child != place).collect();
        let negatives = BTreeSet::from([state]);
        let told: BTreeSet<Place> =
            siblings.into_iter().filter(|sibling| self.model.add_negatives(*sibling, &negatives)).collect();
        // The counter is one of steps, and END belongs to no step.
        if place != Place::End {
            self.counters.nodes_touched += told.len() as u64;
        }
        self.model.fit_classifiers(self.learner, &told, &mut self.counters)
    }
}

/// D18: the primitives that the segment can show another way of doing, in this order: the one that was interrupted, the
/// most probable child of `a` if it is probable enough, and `a` itself. Only primitives on the segment's object count.
///
/// # Errors
/// [`SituError::UnknownNode`].
pub(crate) fn suspects<L: Learner>(
    model: &TaskModel<L>,
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

/// D18: the first of the suspects whose policy is not too far from the segment's own.
///
/// # Errors
/// [`SituError::UnknownNode`].
pub(crate) fn first_near<L: Learner>(
    model: &TaskModel<L>,
    suspects: &[NodeId],
    own: &L::Policy,
    learner: &L,
    rule: &Modify,
    counters: &mut Counters,
) -> Result<Option<NodeId>, SituError> {
    for y in suspects {
        if learner.distance(&model.node(*y)?.policy, own, None, counters) <= rule.max_distance {
            return Ok(Some(*y));
        }
    }
    Ok(None)
}
