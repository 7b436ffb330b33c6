//! A2.4: whether a segment shows something new, one more instance of a primitive, or another way of it (decisions D18
//! to D21).
//!
//! The questions are asked in this order, and the first that is answered decides:
//!
//! 1. The segment is matched, and not displaced: an instance of the way that it is nearest to.
//! 2. It is matched and displaced: another way of what it matched, never an average.
//! 3. It is not matched, but not displaced either from what the robot was doing: a noisy instance of that.
//! 4. *What follows tells* (D19). Followed by what the robot was doing, it was put in before that: a new primitive.
//!    Followed by what follows that in the model, it takes its place, whatever the distance: another way of it, if it
//!    is displaced.
//! 5. By distance (D18): another way of a suspect that is near enough.
//! 6. Else it is new.
//!
//! Displaced means: for what the robot was doing, beyond the teacher's own scatter; for anything else, far (D21).

use crate::decisions::Modify;
use crate::error::SituError;
use crate::matching::{Match, Shows};
use crate::place::{NodeId, Place, SegmentId};
use crate::placement::Placement;
use crate::primitive::{Initiation, Learner};
use crate::update::Update;

/// What the followers of a segment tell of it (D19).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    /// It was put in before what the robot was doing.
    Inserted,
    /// It takes the place of this primitive.
    TakesPlaceOf(NodeId),
    /// Nothing follows, or what follows fits no suspect.
    Nothing,
}

impl<L: Learner> Update<'_, L> {
    /// The primitive that a segment shows after `a`, and what it shows of it. `placement` says what the segments after
    /// it belong to.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    pub fn mend_match<P: Placement<L>>(
        &mut self,
        a: Place,
        d: SegmentId,
        instance_of: Option<NodeId>,
        placement: &mut P,
    ) -> Result<Option<Match>, SituError> {
        let Some(rule) = self.decisions.modify else {
            return Ok(instance_of.map(|node| Match { node, shows: Shows::Way(0) }));
        };
        self.with_own_policy(d, |update, own| {
            if let Some(node) = instance_of {
                let beside = !update.was_doing(a, d).contains(&node);
                return update.shown_of(node, own, &rule, beside).map(Some);
            }
            for y in update.was_doing(a, d) {
                if let Some(way) = update.instance_of(y, own, &rule)? {
                    return Ok(Some(Match { node: y, shows: Shows::Way(way) }));
                }
            }
            if update.decisions.follow {
                match update.what_follows_tells(a, d, placement)? {
                    Told::Inserted => return Ok(None),
                    Told::TakesPlaceOf(node) => {
                        let beside = !update.was_doing(a, d).contains(&node);
                        return update.shown_of(node, own, &rule, beside).map(Some);
                    }
                    Told::Nothing => {}
                }
            }
            update.by_distance(a, d, own, &rule)
        })
    }

    /// What the robot was doing when the correction began, if the segment is its first: the primitive that was
    /// interrupted, the one that was kept from beginning, and the one that ran last.
    fn was_doing(&self, a: Place, d: SegmentId) -> Vec<NodeId> {
        let all = [self.interrupted, self.prevented, a.node()].into_iter().flatten().filter(|_| d.index == 0);
        self.on_the_object(d, all)
    }

    /// Those of some primitives that are about the segment's object, each once, in their order.
    fn on_the_object(&self, d: SegmentId, all: impl Iterator<Item = NodeId>) -> Vec<NodeId> {
        let reference = &self.model.segment(d).reference;
        let mut found: Vec<NodeId> = Vec::new();
        for id in all {
            let is_about = self.model.node(id).is_ok_and(|node| node.reference == *reference);
            if is_about && !found.contains(&id) {
                found.push(id);
            }
        }
        found
    }

    /// The way of a primitive that is nearest to a policy, of those that can be compared with it at all; the newest
    /// where they tie.
    fn nearest_way(&mut self, node: NodeId, own: &L::Policy) -> Result<Option<usize>, SituError> {
        let Self { model, learner, counters, .. } = self;
        let mut nearest: Option<(f64, usize)> = None;
        for (way, policy) in model.node(node)?.policies().into_iter().enumerate() {
            let distance = learner.distance(policy, own, None, counters);
            if distance.is_finite() && nearest.is_none_or(|(least, _)| distance <= least) {
                nearest = Some((distance, way));
            }
        }
        Ok(nearest.map(|(_, way)| way))
    }

    /// What a segment shows of the primitive that it matched.
    pub(crate) fn shown_of(
        &mut self,
        node: NodeId,
        own: &L::Policy,
        rule: &Modify,
        beside: bool,
    ) -> Result<Match, SituError> {
        let way = if self.model.node(node)?.ways.len() == 1 { Some(0) } else { self.nearest_way(node, own)? };
        let shows = match way.filter(|way| !self.is_displaced((node, *way), own, rule, beside)) {
            Some(way) => Shows::Way(way),
            None => Shows::AnotherWay,
        };
        Ok(Match { node, shows })
    }

    /// The way of a primitive that a policy is an instance of, because it is not displaced from it.
    fn instance_of(&mut self, node: NodeId, own: &L::Policy, rule: &Modify) -> Result<Option<usize>, SituError> {
        let way = self.nearest_way(node, own)?;
        Ok(way.filter(|way| !self.is_displaced((node, *way), own, rule, false)))
    }

    /// Whether a policy is displaced from a way; `beside` what the robot was doing it must be far.
    fn is_displaced(&self, (node, way): (NodeId, usize), own: &L::Policy, rule: &Modify, beside: bool) -> bool {
        let Ok(known) = self.model.node(node).map(|node| &node.ways[way].policy) else { return false };
        let limit = if beside { rule.far } else { rule.near };
        limit.is_reached(self.learner.displacement(known, own, self.model.calibration(), beside))
    }

    /// D19: what the segment after this one, or END, tells of it.
    fn what_follows_tells<P: Placement<L>>(
        &mut self,
        a: Place,
        d: SegmentId,
        placement: &mut P,
    ) -> Result<Told, SituError> {
        let suspects = self.suspects(a, d)?;
        if suspects.is_empty() {
            return Ok(Told::Nothing);
        }
        let history = &self.model.histories()[d.demonstration as usize];
        let next = SegmentId { index: d.index + 1, ..d };
        let follower = if (next.index as usize) < history.segments.len() {
            placement.follower(self, next)?.map(Place::Node)
        } else {
            history.carried_to_end.then_some(Place::End)
        };
        let Some(follower) = follower else { return Ok(Told::Nothing) };
        if suspects.iter().any(|y| Place::Node(*y) == follower) {
            return Ok(Told::Inserted);
        }
        let mut suspects = suspects.into_iter();
        let taken = suspects.find(|y| self.model.children(Place::Node(*y)).any(|child| child == follower));
        Ok(taken.map_or(Told::Nothing, Told::TakesPlaceOf))
    }

    /// The primitives whose place a segment may take: what was interrupted, what was kept from beginning, what ran
    /// last if the segment does it again from a state in which it begins (A1.6), and the children of `a`, the most
    /// probable first.
    fn suspects(&mut self, a: Place, d: SegmentId) -> Result<Vec<NodeId>, SituError> {
        let start = self.model.segment(d).start.clone();
        let mut suspects: Vec<NodeId> = Vec::new();
        if d.index == 0 {
            suspects.extend(self.interrupted.into_iter().chain(self.prevented));
        }
        let is_redone = self.is_redone(a, d)?;
        suspects.extend(a.node().filter(|_| is_redone));
        let children = self.model.ranked_children(a, &start).into_iter();
        suspects.extend(children.filter_map(|(child, _)| child.node()));
        Ok(self.on_the_object(d, suspects.into_iter()))
    }

    /// Whether a correction begins in a state in which what ran last begins, too. A thing that is nudged into place
    /// after a put is no other way of putting.
    fn is_redone(&self, a: Place, d: SegmentId) -> Result<bool, SituError> {
        let Place::Node(a) = a else { return Ok(false) };
        let start = &self.model.segment(d).start;
        Ok(d.index == 0 && self.model.node(a)?.classifier.is_applicable(start))
    }

    /// D18: another way of the first suspect whose policy is not too far from the segment's own, or one more instance
    /// of it. Of the children of `a` only the most probable one is suspected, if it is probable enough.
    fn by_distance(
        &mut self,
        a: Place,
        d: SegmentId,
        own: &L::Policy,
        rule: &Modify,
    ) -> Result<Option<Match>, SituError> {
        let start = self.model.segment(d).start.clone();
        let mut ranked = self.model.ranked_children(a, &start).into_iter();
        let likely = ranked.find_map(|(child, probability)| Some((child.node()?, probability)));
        let likely = likely.filter(|(_, probability)| *probability >= rule.min_probability).map(|(id, _)| id);
        let is_redone = self.is_redone(a, d)?;
        let first = [self.interrupted, self.prevented].into_iter().flatten().filter(|_| d.index == 0);
        let last = a.node().filter(|_| is_redone);
        let suspects = self.on_the_object(d, first.chain(likely).chain(last));
        let was_doing = self.was_doing(a, d);
        for y in suspects {
            let Self { model, learner, counters, .. } = &mut *self;
            let distances = model.node(y)?.policies();
            let distances = distances.into_iter().map(|policy| learner.distance(policy, own, None, counters));
            if distances.fold(f64::INFINITY, f64::min) <= rule.max_distance {
                return self.shown_of(y, own, rule, !was_doing.contains(&y)).map(Some);
            }
        }
        Ok(None)
    }
}
