//! Full retraining: all segments pooled, clustered at once, every primitive fitted anew.

use std::collections::{BTreeMap, BTreeSet};

use crate::decisions::Decisions;
use crate::error::SituError;
use crate::place::{Place, SampleId, Samples, SegmentId};
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::task_model::{History, TaskModel};
use crate::trace::{Counters, Trace};

/// Builds a task model from all demonstrations at once.
///
/// Distances between all segments, one global clustering, edges from every history, every policy, signature and
/// classifier fitted. `calibration` is that of the model which is rebuilt; with `None` it is made from the
/// demonstrations that begin at START. The original model of every method is built by this.
///
/// # Errors
/// [`SituError::NoDemonstration`], or where the learner refuses a segment.
pub fn rebuild<L: Learner>(
    histories: Vec<History>,
    calibration: Option<L::Calibration>,
    learner: &L,
    decisions: &Decisions,
) -> Result<(TaskModel<L>, Trace), SituError> {
    if histories.is_empty() {
        return Err(SituError::NoDemonstration);
    }
    let mut counters = Counters::default();
    let segments = |of: &dyn Fn(&&History) -> bool| {
        histories.iter().filter(of).map(|history| history.segments.as_slice()).collect::<Vec<_>>()
    };
    let is_whole = |history: &&History| history.after.is_none();
    let (calibration, labels) = if calibration.is_none() && histories.iter().all(|history| is_whole(&history)) {
        learner.calibrate_and_cluster(&segments(&is_whole), &mut counters)?
    } else {
        let calibration = match calibration {
            Some(calibration) => calibration,
            None => learner.calibrate(&segments(&is_whole), &mut counters)?,
        };
        let pooled: Vec<&Segment> =
            histories.iter().flat_map(|history| &history.segments).map(|segment| &**segment).collect();
        let labels = learner.cluster(&pooled, &calibration, &mut counters)?;
        (calibration, labels)
    };
    assemble(histories, &labels, calibration, learner, decisions, counters)
}

/// Builds a task model whose primitives are known: `labels` has one number for each segment, in the order of the
/// histories, 0, 1, 2, … in order of first appearance.
///
/// # Errors
/// Where the learner refuses a segment.
pub(super) fn assemble<L: Learner>(
    histories: Vec<History>,
    labels: &[usize],
    calibration: L::Calibration,
    learner: &L,
    decisions: &Decisions,
    mut counters: Counters,
) -> Result<(TaskModel<L>, Trace), SituError> {
    let mut model = TaskModel::new(calibration);
    let mut ids = Vec::with_capacity(labels.len());
    let ends: Vec<u32> =
        (0..).zip(&histories).filter(|(_, history)| history.carried_to_end).map(|(index, _)| index).collect();
    for history in histories {
        ids.extend(model.begin(history));
    }
    let mut clusters: BTreeMap<usize, BTreeSet<SegmentId>> = BTreeMap::new();
    for (id, label) in ids.iter().zip(labels) {
        clusters.entry(*label).or_default().insert(*id);
    }
    let mut nodes = Vec::new();
    // A node's negatives are known once every edge is; until then all share one classifier.
    let mut blank: Option<L::Classifier> = None;
    for segments in clusters.values() {
        let data: Vec<&Segment> = segments.iter().map(|id| &**model.segment(*id)).collect();
        let policy = learner.fit_policy(&data, model.calibration(), &mut counters)?;
        let positives: BTreeSet<SampleId> = segments.iter().copied().map(SampleId::Start).collect();
        let samples = Samples { positives, negatives: BTreeSet::new() };
        let classifier = match &blank {
            Some(classifier) => classifier.clone(),
            None => blank.insert(model.fit_samples(learner, &samples, &mut counters)?).clone(),
        };
        let way = model.way(segments.clone(), policy);
        nodes.push(model.add_node(segments.clone(), vec![way], samples, classifier));
    }
    for (id, label) in ids.iter().zip(labels) {
        model.place(*id, nodes[*label]);
    }
    model.connect_by_history(&ids.iter().copied().collect());
    for demonstration in ends {
        model.add_final(demonstration);
    }
    retrain_classifiers(&mut model, learner, decisions, &mut counters)?;
    counters.nodes_touched += model.len() as u64;
    Ok((model, Trace { counters, ..Trace::default() }))
}

/// Refits every policy, signature and classifier of a model without clustering again: the cheapest full retraining.
///
/// # Errors
/// Where the learner refuses.
pub fn refit<L: Learner>(
    mut model: TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> Result<(TaskModel<L>, Trace), SituError> {
    let mut counters = Counters::default();
    let nodes: Vec<_> = model.nodes().map(|(id, node)| (id, node.ways.len())).collect();
    for (id, ways) in nodes {
        for way in 0..ways {
            model.fit_policy(learner, id, way, &mut counters)?;
        }
    }
    retrain_classifiers(&mut model, learner, decisions, &mut counters)?;
    counters.nodes_touched += model.len() as u64;
    Ok((model, Trace { counters, ..Trace::default() }))
}

/// The negatives of every place by the rules of Algorithm 2 and the decisions, then every classifier.
pub(super) fn retrain_classifiers<L: Learner>(
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
    counters: &mut Counters,
) -> Result<(), SituError> {
    let places: BTreeSet<Place> = model.nodes().map(|(id, _)| Place::Node(id)).chain([Place::End]).collect();
    for place in &places {
        let own = model.starts([*place].into_iter());
        let siblings: BTreeSet<Place> = model.parents(*place).flat_map(|parent| model.children(parent)).collect();
        let mut negatives = model.starts(siblings.into_iter());
        let neighbours: BTreeSet<Place> = model.parents(*place).chain(model.children(*place)).collect();
        negatives.extend(model.background(decisions.background, neighbours.into_iter(), &own));
        if decisions.subtract_own_positives || *place == Place::End {
            negatives.retain(|sample| !own.contains(sample)); // D1
        }
        model.add_negatives(*place, &negatives);
    }
    model.fit_classifiers(learner, &places, counters)
}
