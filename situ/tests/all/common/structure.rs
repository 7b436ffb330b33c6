//! What holds of every task model, however it came about.

use std::collections::{BTreeMap, BTreeSet};

use situ::decisions::Decisions;
use situ::place::{NodeId, Place, SampleId, SegmentId};
use situ::primitive::Learner;
use situ::task_model::TaskModel;

/// The edges that the histories hold: consecutive places, START and END among them.
pub(crate) fn edges_of_histories<L: Learner>(model: &TaskModel<L>) -> BTreeSet<(Place, Place)> {
    let mut edges = BTreeSet::new();
    for history in model.histories() {
        let mut before = match history.after {
            None => Place::Start,
            Some(segment) => Place::Node(model.node_of(segment).expect("what ran last was placed")),
        };
        for node in &history.nodes {
            edges.insert((before, Place::Node(*node)));
            before = Place::Node(*node);
        }
        if history.carried_to_end {
            edges.insert((before, Place::End));
        }
    }
    edges
}

/// How many start and final states are samples no longer (decision D22).
pub(crate) fn retired<L: Learner>(model: &TaskModel<L>) -> usize {
    let starts = model.nodes().flat_map(|(_, node)| {
        let positives = &node.samples.positives;
        node.segments.iter().filter(|segment| !positives.contains(&SampleId::Start(**segment)))
    });
    let ends = (0..).zip(model.histories()).filter(|(demonstration, history)| {
        history.carried_to_end && !model.end().samples.positives.contains(&SampleId::Final(*demonstration))
    });
    starts.count() + ends.count()
}

/// # Panics
/// Where the model breaks a rule that every model of these decisions keeps.
pub(crate) fn check<L: Learner>(model: &TaskModel<L>, decisions: &Decisions) {
    let ids: BTreeSet<NodeId> = model.nodes().map(|(id, _)| id).collect();
    let places: Vec<Place> = ids.iter().map(|id| Place::Node(*id)).chain([Place::Start, Place::End]).collect();

    // Edges: between places of the model, the same from both ends, and exactly those of the histories.
    let edges: BTreeSet<(Place, Place)> = model.edges().collect();
    for place in edges.iter().flat_map(|(from, to)| [from, to]) {
        assert!(places.contains(place), "an edge at {place}, which is not in the model");
    }
    let forwards: BTreeSet<_> =
        places.iter().flat_map(|place| model.children(*place).map(|child| (*place, child))).collect();
    let backwards: BTreeSet<_> =
        places.iter().flat_map(|place| model.parents(*place).map(|parent| (parent, *place))).collect();
    assert_eq!(forwards, edges, "children");
    assert_eq!(backwards, edges, "parents");
    assert_eq!(edges_of_histories(model), edges, "edges are the consecutive places of the histories");
    assert_eq!(model.parents(Place::Start).count(), 0, "START has parents");
    assert_eq!(model.children(Place::End).count(), 0, "END has children");

    // Segments: each held by exactly one node, which is the one that its history names.
    let mut holders: BTreeMap<SegmentId, NodeId> = BTreeMap::new();
    for (id, node) in model.nodes() {
        for segment in &node.segments {
            assert_eq!(holders.insert(*segment, id), None, "{segment:?} is held twice");
        }
        assert!(model.nodes_of(&node.reference).any(|other| other == id), "{id} is not indexed by its object");
        ways(model, id, decisions);
        samples(model, id, decisions);
    }
    let mut finals = BTreeSet::new();
    for (demonstration, history) in (0..).zip(model.histories()) {
        assert_eq!(history.nodes.len(), history.segments.len(), "every segment is placed");
        for (index, node) in (0..).zip(&history.nodes) {
            let segment = SegmentId { demonstration, index };
            assert_eq!(holders.remove(&segment), Some(*node), "{segment:?}");
        }
        finals.extend(history.carried_to_end.then_some(SampleId::Final(demonstration)));
    }
    assert!(holders.is_empty(), "segments of no history: {holders:?}");

    // END (D11).
    let end = &model.end().samples;
    assert!(end.positives.is_subset(&finals), "END's positives are the final states of what was carried on to it");
    assert!(decisions.obey || end.positives == finals, "only obedience retires");
    assert_eq!(end.positives.is_empty(), finals.is_empty(), "END keeps its last positive");
    assert_eq!(model.end().classifier.is_some(), !finals.is_empty());
    assert_eq!(model.parents(Place::End).count() > 0, !finals.is_empty());
    assert!(end.positives.is_disjoint(&end.negatives), "D1, END");
    assert!(end.negatives.iter().all(|sample| exists(model, *sample)));
}

/// D20: one way at least and no more than there may be, each with data of its own, which is the node's.
fn ways<L: Learner>(model: &TaskModel<L>, id: NodeId, decisions: &Decisions) {
    let node = model.node(id).unwrap();
    assert!((1..=decisions.ways.most()).contains(&node.ways.len()), "{id}: {} ways", node.ways.len());
    let mut data = BTreeSet::new();
    for way in &node.ways {
        assert!(!way.segments.is_empty() && way.segments.is_subset(&node.segments), "{id}: {:?}", way.segments);
        assert!(way.segments.iter().all(|segment| data.insert(*segment)), "{id}: two ways share a segment");
        assert!(way.wanted.iter().all(|sample| exists(model, *sample)), "{id}: wanted in a state of nothing");
        let is_own = |sample: &SampleId| match sample {
            SampleId::Start(segment) => way.segments.contains(segment),
            SampleId::Chosen { .. } => decisions.trail,
            SampleId::Final(_) => false,
        };
        assert!(way.wanted.iter().all(is_own), "{id}: wanted where it was shown or where another was stopped");
    }
    assert_eq!(data, node.policy_segments(), "{id}");
    let first: Vec<_> = node.ways.iter().map(|way| way.segments.first()).collect();
    assert!(first.is_sorted(), "{id}: the oldest first");
}

/// The positives of a node are the start states of its segments but for those that were retired (D22), and states in
/// which the robot chose what it should not have done (D23); one at least.
fn samples<L: Learner>(model: &TaskModel<L>, id: NodeId, decisions: &Decisions) {
    let node = model.node(id).unwrap();
    let starts: BTreeSet<SampleId> = node.segments.iter().copied().map(SampleId::Start).collect();
    let positives = &node.samples.positives;
    let is_explained = |sample: &SampleId| match sample {
        SampleId::Chosen { demonstration, .. } => {
            let first = SegmentId { demonstration: *demonstration, index: 0 };
            decisions.trail && node.segments.contains(&first)
        }
        own => starts.contains(own),
    };
    assert!(!positives.is_empty() && positives.iter().all(is_explained), "{id}: {positives:?}");
    assert!(decisions.obey || starts.is_subset(positives), "{id}: only obedience retires");
    if decisions.subtract_own_positives {
        let both: Vec<_> = positives.intersection(&node.samples.negatives).collect();
        assert!(both.is_empty(), "D1, {id}: {both:?}");
    }
    let all = positives.union(&node.samples.negatives);
    assert!(all.into_iter().all(|sample| exists(model, *sample)), "{id}: a sample of nothing");
}

fn exists<L: Learner>(model: &TaskModel<L>, sample: SampleId) -> bool {
    match sample {
        SampleId::Start(segment) => model.node_of(segment).is_some(),
        SampleId::Final(index) => model.histories().get(index as usize).is_some_and(|history| history.carried_to_end),
        SampleId::Chosen { demonstration, index } => {
            model.histories().get(demonstration as usize).is_some_and(|history| (index as usize) < history.trail.len())
        }
    }
}
