//! The automaton as a STARHMM: a node is a phase, an edge is a permitted transition, and a classifier is an entry.

use std::collections::{BTreeMap, BTreeSet};

use super::frames::Frames;
use super::parameters::ItmcdParameters;
use super::starhmm::{END, LinearGaussian, Phase, Starhmm, StarhmmSequence, StarhmmStep};
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::place::{NodeId, Place, SegmentId};
use crate::segment::Segment;
use crate::task_model::{History, TaskModel};

/// The segments that the policy of a node was fitted to before each modification, the oldest first.
pub(super) type Retired = BTreeMap<NodeId, Vec<BTreeSet<SegmentId>>>;

/// A STARHMM, and the meaning of its phases.
#[derive(Clone)]
pub(super) struct Automaton {
    pub(super) model: Starhmm,
    /// The phases of each node: its versions, the current one last.
    pub(super) versions: BTreeMap<NodeId, Vec<usize>>,
    pub(super) edges: BTreeSet<(Place, Place)>,
}

pub(super) fn problem(error: impl ToString) -> SituError {
    SituError::Phases(error.to_string())
}

/// An emission of the steps of one or more segments.
pub(super) fn emission(steps: &[&StarhmmStep], parameters: &ItmcdParameters) -> Result<LinearGaussian, SituError> {
    let samples: Vec<_> = steps.iter().map(|step| (1.0, &*step.regressors, &*step.target)).collect();
    LinearGaussian::fit(&samples, parameters.fit.ridge, parameters.fit.floor)
        .ok_or_else(|| problem("an emission cannot be fitted to a segment"))
}

/// The steps of each segment. `context` gives the context of a segment from its index.
pub(super) fn steps(
    frames: &Frames,
    history: &History,
    context: impl Fn(usize, &Segment) -> usize,
) -> Vec<Vec<StarhmmStep>> {
    let states = history.segments.iter().skip(1).map(|segment| &segment.start).chain([&history.final_state]);
    let segments = history.segments.iter().zip(states).enumerate();
    segments.map(|(index, (segment, after))| frames.steps(segment, context(index, segment), after)).collect()
}

/// The sequences in which a version of a node cannot run, of so many and the next one. `groups`: the segments of each
/// version, the current one last.
///
/// A version runs where a segment of its own is. The current one also runs wherever no version has a segment, so in the
/// next sequence too.
fn absences(own: &BTreeSet<SegmentId>, groups: &[&BTreeSet<SegmentId>], sequences: usize) -> BTreeSet<usize> {
    let runs = |group: &BTreeSet<SegmentId>, sequence: usize| {
        group.iter().any(|segment| segment.demonstration as usize == sequence)
    };
    let is_current = groups.last().is_some_and(|last| std::ptr::eq(own, *last));
    let is_absent = |sequence: &usize| {
        let elsewhere = groups.iter().any(|other| runs(other, *sequence));
        !runs(own, *sequence) && (elsewhere || !is_current)
    };
    (0..=sequences).filter(is_absent).collect()
}

impl Automaton {
    /// The model of an automaton, and the sequences of its histories. Emissions are fitted to the segments of each
    /// node. Terminations and entries are uniform; the first EM learns them.
    pub(super) fn of(
        task: &TaskModel<KeyframeLearner>,
        retired: &Retired,
        frames: &Frames,
        parameters: &ItmcdParameters,
    ) -> Result<(Self, Vec<StarhmmSequence>), SituError> {
        // A segment has the context of its node, even if its own last keyframe differs: the history has placed it
        // there.
        let mut contexts = BTreeMap::new();
        for (id, node) in task.nodes() {
            let first = node.newest().segments.first().ok_or(SituError::UnknownNode(id))?;
            contexts.insert(id, frames.context(task.segment(*first)));
        }
        let mut all_steps: Vec<Vec<Vec<StarhmmStep>>> = Vec::new();
        for history in task.histories() {
            let own = |index: usize, _: &Segment| history.nodes.get(index).and_then(|id| contexts.get(id)).copied();
            all_steps.push(steps(frames, history, |index, segment| own(index, segment).unwrap_or(usize::MAX)));
        }
        let mut phases: Vec<Phase> = Vec::new();
        let mut versions: BTreeMap<NodeId, Vec<usize>> = BTreeMap::new();
        for (slot, (id, node)) in task.nodes().enumerate() {
            let old = retired.get(&id).into_iter().flatten();
            let groups: Vec<&BTreeSet<SegmentId>> = old.chain([&node.newest().segments]).collect();
            for group in &groups {
                let shown: Vec<&StarhmmStep> = group
                    .iter()
                    .flat_map(|segment| &all_steps[segment.demonstration as usize][segment.index as usize])
                    .collect();
                let absent = absences(group, &groups, all_steps.len());
                let emission = emission(&shown, parameters)?;
                versions.entry(id).or_default().push(phases.len());
                phases.push(Phase { context: contexts[&id], emission, exit: slot, entry: slot, absent });
            }
        }
        let size = task.len();
        let model = Starhmm {
            children: vec![Vec::new(); phases.len()],
            phases,
            first: Vec::new(),
            exits: vec![vec![0.0]; size],
            entries: vec![vec![0.0; frames.entry_width()]; size + 1],
            end_entry: size,
        };
        let mut automaton = Self { model, versions, edges: BTreeSet::new() };
        for (from, to) in task.edges() {
            automaton.add_edge(from, to);
        }
        let sequence = |(history, steps): (&History, Vec<Vec<StarhmmStep>>)| {
            let origin = history.after.and_then(|segment| task.node_of(segment)).and_then(|id| automaton.current(id));
            let entry_features = frames.entry_features(&history.segments[0].start);
            StarhmmSequence { origin, entry_features, steps: steps.concat(), ends: history.carried_to_end }
        };
        let sequences = task.histories().iter().zip(all_steps).map(sequence).collect();
        Ok((automaton, sequences))
    }

    /// The phase of the current version of a node.
    pub(super) fn current(&self, id: NodeId) -> Option<usize> {
        self.versions.get(&id)?.last().copied()
    }

    /// The phases that a place stands for. START has none.
    fn phases_of(&self, place: Place) -> Vec<usize> {
        match place {
            Place::Start => Vec::new(),
            Place::Node(id) => self.versions.get(&id).cloned().unwrap_or_default(),
            Place::End => vec![END],
        }
    }

    /// Permits a transition, between all versions of the two places.
    pub(super) fn add_edge(&mut self, from: Place, to: Place) {
        if !self.edges.insert((from, to)) {
            return;
        }
        let targets = self.phases_of(to);
        if from == Place::Start {
            self.model.first.extend(targets);
        } else {
            for phase in self.phases_of(from) {
                self.model.children[phase].extend(&targets);
            }
        }
    }

    /// Adds a phase for a new node, without edges.
    pub(super) fn add_node(&mut self, id: NodeId, context: usize, emission: LinearGaussian) {
        let phase = self.model.phases.len();
        let (exit, entry) = (self.model.exits.len(), self.model.entries.len());
        self.model.exits.push(vec![0.0; self.model.exits.first().map_or(0, Vec::len)]);
        self.model.entries.push(vec![0.0; self.model.entries.first().map_or(0, Vec::len)]);
        self.model.phases.push(Phase { context, emission, exit, entry, absent: BTreeSet::new() });
        self.model.children.push(Vec::new());
        self.versions.insert(id, vec![phase]);
    }

    /// Adds a new version of a node. Of all versions it alone runs in this sequence, and it runs in no earlier one. It
    /// shares w and v with the old version.
    pub(super) fn add_version(&mut self, id: NodeId, emission: LinearGaussian, sequence: usize) {
        let Some(old) = self.current(id) else { return };
        let new = self.model.phases.len();
        let mut phase = Phase { emission, ..self.model.phases[old].clone() };
        phase.absent.extend(0..sequence);
        self.model.phases[old].absent.insert(sequence);
        self.model.phases.push(phase);
        self.model.children.push(self.model.children[old].clone());
        for children in self.model.children.iter_mut().chain([&mut self.model.first]) {
            if children.contains(&old) {
                children.push(new);
            }
        }
        self.versions.entry(id).or_default().push(new);
    }

    /// How many of these contexts, one per segment, the structure can make in a row in a sequence after `origin`. If
    /// END can follow the last of them, it counts as one more.
    pub(super) fn reach(&self, origin: Option<usize>, sequence: usize, contexts: &[usize]) -> usize {
        let mut here: BTreeSet<Option<usize>> = BTreeSet::from([origin]);
        for (index, context) in contexts.iter().enumerate() {
            let next = here.iter().flat_map(|from| self.model.options(*from, sequence, index > 0));
            let next = next.filter(|to| *to != END && self.model.phases[*to].context == *context);
            let next: BTreeSet<Option<usize>> = next.map(Some).collect();
            if next.is_empty() {
                return index;
            }
            here = next;
        }
        let is_over = here.iter().any(|from| self.model.options(*from, sequence, true).any(|to| to == END));
        contexts.len() + usize::from(is_over)
    }

    /// The node of a phase.
    pub(super) fn node_of(&self, phase: usize) -> Option<NodeId> {
        self.versions.iter().find(|(_, phases)| phases.contains(&phase)).map(|(id, _)| *id)
    }
}
