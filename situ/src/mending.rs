//! The mendings: what the listing leaves open or gets wrong about the structure of an update. Each hook belongs to one
//! line of the listing; D3 serves three.
//!
//! Each hook is a decision ([`crate::decisions`]). Where the decision is switched off, its hook does nothing, and what
//! is left is the listing as printed.
//!
//! | line | decision | hook |
//! |---|---|---|
//! | A2.2 | D10: what is compared with a segment | [`Update::candidates`], [`Update::ask_further`] |
//! | A2.4, A2.18 | D18 to D20: a segment shows another way of a primitive | [`crate::another_way`] |
//! | A2.6, A2.16 | D23: the state in which the robot will choose again | [`Update::mend_positives`] |
//! | A2.7 | D2: background negatives | [`Update::add_background`] |
//! | A2.17 | D1: a primitive's own positives; D2 | [`Update::mend_negatives`] |
//! | A2.12, A2.20, END | D3: the siblings learn where they do not begin | [`Update::tell_siblings`] |
//!
//! A limit that is left: a node has one classifier, whatever it is reached from. Where it is shared by two branches,
//! what one branch gives it as negatives (D2, D3) counts on the other, too. A positive in the same state as `n`
//! negatives of the other branch is worth about `1 / (n + 1)`, and with `n` greater than 2 the node is no confident
//! child there (D11). Obedience (D22) mends it where the robot is corrected in that state, and nowhere else.

use std::collections::BTreeSet;

use crate::decisions::Candidates;
use crate::error::SituError;
use crate::matching::Clusters;
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::primitive::{Initiation, Learner};
use crate::state::State;
use crate::trace::MatchedIn;
use crate::update::Update;
use crate::worlds::is_unlike;

impl<L: Learner> Update<'_, L> {
    /// A1.6, D10 and D23: the primitives about the segment's object that are applicable where the segment begins, or
    /// where the robot last chose what it should not have done; where none is, the likeliest. Somebody who steps in
    /// leaves the hand where no primitive begins. As printed: whatever is applicable where the segment begins.
    pub fn applicable(&mut self, state: SampleId) -> Vec<NodeId> {
        let (SampleId::Start(d), Candidates::ReferenceFallback(_)) = (state, self.decisions.candidates) else {
            return self.model.applicable(self.model.state(state), &mut self.counters);
        };
        let chosen = self.stopped().and_then(|y| self.chosen_before(d, y));
        let states: Vec<&State> = chosen.into_iter().chain([state]).map(|sample| self.model.state(sample)).collect();
        let mut applicable = Vec::new();
        let mut likeliest: Option<(f64, NodeId)> = None;
        for id in self.model.nodes_of(&self.model.segment(d).reference) {
            let Ok(node) = self.model.node(id) else { continue };
            self.counters.classifier_evaluations += states.len() as u64;
            if states.iter().any(|state| node.classifier.is_applicable(state)) {
                applicable.push(id);
            }
            let probability = states.iter().map(|state| node.classifier.probability(state)).fold(0.0, f64::max);
            if likeliest.is_none_or(|(most, _)| probability > most) {
                likeliest = Some((probability, id));
            }
        }
        if applicable.is_empty() {
            applicable.extend(likeliest.map(|(_, id)| id));
        }
        applicable
    }

    /// A2.2, D10: the primitives that a segment is compared with first.
    pub fn candidates(&self, applicable: &[NodeId]) -> Vec<NodeId> {
        match self.decisions.candidates {
            Candidates::Applicable | Candidates::ReferenceFallback(_) => applicable.to_vec(),
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

    /// A2.6 and A2.16, D23: where a correction begins is not where the robot will choose next time. It last chose a
    /// primitive `y` that it should not have run to its end. Where the first segment shows `z` in its place, the state
    /// of that choice is a positive of `z`, unless it is like the states in which `y` begins rightly; where it shows
    /// `y` itself, it is one of `y`.
    pub fn mend_positives(&self, a: Place, z: Option<NodeId>, d: SegmentId, positives: &mut BTreeSet<SampleId>) {
        let stopped = self.stopped();
        if let Some(z) = z
            && stopped.map_or(a, Place::Node) == Place::Node(z)
        {
            positives.extend(self.chosen_before(d, z));
            return;
        }
        let Some(y) = stopped else { return };
        let Some(chosen) = self.chosen_before(d, y).filter(|chosen| self.model.before(*chosen) == Some(a)) else {
            return;
        };
        let begins = self.model.starts([Place::Node(y)].into_iter());
        let begins: Vec<&State> = begins.iter().map(|sample| self.model.state(*sample)).collect();
        if is_unlike(self.model.state(chosen), &begins, self.learner.scales()) {
            positives.insert(chosen);
        }
    }

    /// The primitive that the robot was doing, or kept from doing, before the correction.
    pub(crate) fn stopped(&self) -> Option<NodeId> {
        self.interrupted.or(self.prevented)
    }

    /// D23: the last choice of a primitive on the trail that led to the correction, if the segment is its first.
    pub(crate) fn chosen_before(&self, d: SegmentId, y: NodeId) -> Option<SampleId> {
        self.chosen(d.demonstration, y).filter(|_| d.index == 0)
    }

    /// D23: the last choice of a primitive on the trail that led to a correction.
    pub(crate) fn chosen(&self, demonstration: u32, y: NodeId) -> Option<SampleId> {
        let trail = &self.model.histories()[demonstration as usize].trail;
        let last = trail.iter().rposition(|step| self.model.node_of(step.of) == Some(y))?;
        Some(SampleId::Chosen { demonstration, index: last as u32 })
    }

    /// A2.12, A2.20 and END, D3: `place` begins after `a` in the states of these samples. The other children of `a`,
    /// END among them, learn that they do not begin there.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub fn tell_siblings(&mut self, a: Place, place: Place, negatives: &BTreeSet<SampleId>) -> Result<(), SituError> {
        if !self.decisions.push_to_siblings {
            return Ok(());
        }
        let siblings: BTreeSet<Place> = self.model.children(a).filter(|child| *child != place).collect();
        let told: BTreeSet<Place> =
            siblings.into_iter().filter(|sibling| self.model.add_negatives(*sibling, negatives)).collect();
        // The counter is one of steps, and END belongs to no step.
        if place != Place::End {
            self.counters.nodes_touched += told.len() as u64;
        }
        self.model.fit_classifiers(self.learner, &told, &mut self.counters)
    }
}
