//! A correction being folded into a task model: what the lines of Algorithms 1 and 2 call, under the listing's names.

use std::collections::{BTreeMap, BTreeSet};

use crate::decisions::Decisions;
use crate::error::SituError;
use crate::matching::{Clusters, Match, Shows};
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::primitive::Learner;
use crate::task_model::TaskModel;
use crate::trace::{Branch, Counters, MatchedIn, Obedience, Step, Trace};

/// A task model `T` under correction, the learner and the decisions, and what was done so far.
pub struct Update<'a, L: Learner> {
    /// `T`.
    pub model: &'a mut TaskModel<L>,
    /// Fits and compares.
    pub learner: &'a L,
    /// The open decisions.
    pub decisions: &'a Decisions,
    /// The primitive that ran last before the correction.
    pub last: Place,
    /// The primitive that was interrupted before the correction (D18).
    pub interrupted: Option<NodeId>,
    /// The primitive that was chosen before the correction and kept from beginning (D23).
    pub prevented: Option<NodeId>,
    /// The work of the step under way.
    pub counters: Counters,
    /// The policies of single segments, each from the moment when it is fitted until a primitive takes it.
    own: BTreeMap<SegmentId, L::Policy>,
    steps: Vec<Step>,
    /// Where the model had to be made to do what was shown (D22).
    pub(crate) obedience: Obedience,
}

/// The new ids of the nodes that Local-Reconnect has merged (decision D9).
pub struct Renamed(BTreeMap<NodeId, NodeId>);

impl Renamed {
    /// The node that was called `id`. A node that was not merged keeps its id.
    pub fn node(&self, id: NodeId) -> NodeId {
        self.0.get(&id).copied().unwrap_or(id)
    }

    /// The same for a place.
    pub fn place(&self, place: Place) -> Place {
        if let Place::Node(id) = place { Place::Node(self.node(id)) } else { place }
    }
}

impl<'a, L: Learner> Update<'a, L> {
    /// An update that has done nothing yet.
    pub fn new(model: &'a mut TaskModel<L>, learner: &'a L, decisions: &'a Decisions) -> Self {
        Self {
            model,
            learner,
            decisions,
            last: Place::Start,
            interrupted: None,
            prevented: None,
            counters: Counters::default(),
            own: BTreeMap::new(),
            steps: Vec::new(),
            obedience: Obedience::default(),
        }
    }

    /// D17: begins the step of a segment.
    pub(crate) fn begin_step(&mut self, d: SegmentId) {
        self.steps.push(Step::new(&self.model.segment(d).reference, self.model.len()));
        self.counters = Counters::default();
    }

    /// D17: ends the step, in which these primitives were applicable.
    pub(crate) fn end_step(&mut self, applicable: Vec<NodeId>) {
        let counters = std::mem::take(&mut self.counters);
        if let Some(step) = self.steps.last_mut() {
            step.applicable = applicable;
            step.counters = counters;
        }
    }

    /// D17: what was done. Work outside of the steps (END) counts in the sum alone.
    pub(crate) fn into_trace(self) -> Trace {
        let mut counters = self.counters;
        self.steps.iter().for_each(|step| counters += step.counters);
        Trace { steps: self.steps, obedience: self.obedience, counters }
    }

    fn note(&mut self, note: impl FnOnce(&mut Step)) {
        if let Some(step) = self.steps.last_mut() {
            note(step);
        }
    }

    /// Cluster (A2.2): the segment's own policy and those of the candidates, whatever their order.
    ///
    /// # Errors
    /// Where the learner refuses the segment; [`SituError::UnknownNode`].
    pub fn cluster(&mut self, d: SegmentId, candidates: &[NodeId]) -> Result<Clusters, SituError> {
        let candidates: Vec<NodeId> = BTreeSet::from_iter(candidates.iter().copied()).into_iter().collect();
        if candidates.is_empty() {
            return Ok(Clusters::default());
        }
        let own = self.fit_policy(d)?;
        let known = self.model.distances_among(self.learner, &candidates, &mut self.counters)?;
        let node = |id: &NodeId| Ok(self.model.node(*id)?.policies());
        let policies = candidates.iter().map(node).collect::<Result<Vec<_>, SituError>>()?;
        let calibration = self.model.calibration();
        let found = self.learner.cluster_and_find(&own, &policies, &known, calibration, &mut self.counters);
        self.own.insert(d, own);
        let ids = |indices: &[usize]| indices.iter().map(|index| candidates[*index]).collect::<Vec<_>>();
        let mut groups = Vec::new();
        if self.decisions.merge_redundant {
            groups.extend(found.redundant.iter().map(|group| ids(group)));
        }
        if found.matched.len() > 1 {
            groups.push(ids(&found.matched));
        }
        let instance_of = found.matched.first().map(|index| candidates[*index]);
        let matched_in = if instance_of.is_some() { MatchedIn::Index } else { MatchedIn::None };
        Ok(Clusters { instance_of, groups, matched_in, compared: candidates.len() })
    }

    /// Local-Reconnect (A2.3).
    ///
    /// # Errors
    /// Where the learner refuses.
    pub(crate) fn local_reconnect(&mut self, clusters: &Clusters) -> Result<Renamed, SituError> {
        let Self { model, learner, decisions, counters, .. } = self;
        let renamed = Renamed(model.local_reconnect(learner, &clusters.groups, decisions, counters)?);
        self.last = renamed.place(self.last);
        self.interrupted = self.interrupted.map(|id| renamed.node(id));
        self.prevented = self.prevented.map(|id| renamed.node(id));
        let merged = clusters.groups.iter().map(|group| (group.clone(), renamed.node(group[0]))).collect();
        let Clusters { matched_in, compared, .. } = *clusters;
        self.note(|step| (step.merged, step.matched_in, step.candidates) = (merged, matched_in, compared));
        Ok(renamed)
    }

    /// `S(children(r))` over these places `r` (A2.7, A2.17): the states in which their children begin.
    pub(crate) fn starts_of_children(&self, places: impl IntoIterator<Item = Place>) -> BTreeSet<SampleId> {
        self.model.starts(places.into_iter().flat_map(|place| self.model.children(place)))
    }

    /// Fit-Policy (A2.8): the policy of `d` alone. Find-Policy may have asked for it already.
    ///
    /// # Errors
    /// Where the learner refuses the segment.
    pub(crate) fn fit_policy(&mut self, d: SegmentId) -> Result<L::Policy, SituError> {
        match self.own.remove(&d) {
            Some(policy) => Ok(policy),
            None => {
                let Self { model, learner, counters, .. } = self;
                learner.fit_policy(&[&**model.segment(d)], model.calibration(), counters)
            }
        }
    }

    /// Lends the policy of `d` alone, as [`Update::fit_policy`] makes it.
    ///
    /// # Errors
    /// Where the learner refuses the segment, and those of `work`.
    pub(crate) fn with_own_policy<T>(
        &mut self,
        d: SegmentId,
        work: impl FnOnce(&mut Self, &L::Policy) -> Result<T, SituError>,
    ) -> Result<T, SituError> {
        let policy = self.fit_policy(d)?;
        let outcome = work(self, &policy)?;
        self.own.insert(d, policy);
        Ok(outcome)
    }

    /// Fit-Classifier (A2.9).
    ///
    /// # Errors
    /// Where the learner refuses.
    pub(crate) fn fit_classifier(&mut self, samples: &Samples) -> Result<L::Classifier, SituError> {
        self.model.fit_samples(self.learner, samples, &mut self.counters)
    }

    /// Add-Node (A2.11).
    pub(crate) fn add_node(
        &mut self,
        d: SegmentId,
        (policy, samples, classifier): (L::Policy, Samples, L::Classifier),
    ) -> NodeId {
        let way = self.model.way(BTreeSet::from([d]), policy);
        let z = self.model.add_node(BTreeSet::from([d]), vec![way], samples, classifier);
        self.model.place(d, z);
        self.counters.nodes_touched += 1;
        self.note(|step| step.branch = Branch::New);
        z
    }

    /// Update-Policy (A2.18), as an exact refit of the way that the segment is an instance of; another way has the
    /// policy of the segment alone (D18 to D20).
    ///
    /// # Errors
    /// Where the learner refuses; [`SituError::UnknownNode`].
    pub(crate) fn update_policy(&mut self, d: SegmentId, i: &Match) -> Result<(), SituError> {
        let (way, branch) = match i.shows {
            Shows::AnotherWay => {
                let own = self.fit_policy(d)?;
                self.model.add_way(i.node, d, own, self.decisions.ways.most())?;
                (self.model.node(i.node)?.ways.len() - 1, Branch::Modify)
            }
            Shows::Way(way) => {
                self.model.adopt(i.node, way, d)?;
                self.model.fit_policy(self.learner, i.node, way, &mut self.counters)?;
                (way, Branch::Existing)
            }
        };
        // D23: the way is wanted where another one was begun in its place, whatever was shown before it once more.
        let is_redone = self.last == Place::Node(i.node) || self.stopped() == Some(i.node);
        if let Some(chosen) = self.chosen(d.demonstration, i.node).filter(|_| is_redone) {
            self.model.want(i.node, way, chosen)?;
        }
        self.model.place(d, i.node);
        self.counters.nodes_touched += 1;
        self.note(|step| step.branch = branch);
        Ok(())
    }

    /// Update-Classifier (A2.19) by these positives and negatives.
    ///
    /// # Errors
    /// Where the learner refuses.
    pub(crate) fn update_classifier(
        &mut self,
        z: NodeId,
        positives: &BTreeSet<SampleId>,
        negatives: &BTreeSet<SampleId>,
    ) -> Result<(), SituError> {
        self.model.add_positives(z, positives)?;
        self.model.add_negatives(Place::Node(z), negatives);
        self.model.fit_classifiers(self.learner, &BTreeSet::from([Place::Node(z)]), &mut self.counters)
    }

    /// Add-Edge (A2.12, A2.20).
    pub(crate) fn add_edge(&mut self, a: Place, z: NodeId) {
        let is_new = self.model.add_edge(a, Place::Node(z));
        self.note(|step| (step.after, step.node, step.edge_added) = (a, z, is_new));
    }

    /// D11: the listing has no END. The final state of a demonstration that was carried on to the end is a positive of
    /// END, after `a`, the primitive that ran last; the siblings are told (D3).
    ///
    /// # Errors
    /// Where the learner refuses.
    pub(crate) fn end(&mut self, a: Place, demonstration: u32) -> Result<(), SituError> {
        let siblings = self.model.children(a).filter(|child| *child != Place::End);
        let before = self.decisions.background.neighbours.then_some(a); // D2
        let negatives = self.model.starts(siblings.chain(before));
        self.model.add_final(demonstration);
        self.model.add_negatives(Place::End, &negatives);
        self.model.add_edge(a, Place::End);
        self.model.fit_classifiers(self.learner, &BTreeSet::from([Place::End]), &mut self.counters)?;
        self.tell_siblings(a, Place::End, &BTreeSet::from([SampleId::Final(demonstration)]))
    }
}
