//! What holds of every task model, however it came about.

use std::collections::{BTreeMap, BTreeSet};

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

/// # Panics
/// Where the model breaks a rule; `subtract` is decision D1.
pub(crate) fn check<L: Learner>(model: &TaskModel<L>, subtract: bool) {
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
        assert!(!node.policy_segments.is_empty() && node.policy_segments.is_subset(&node.segments), "{id}");
        assert!(model.nodes_of(&node.reference).any(|other| other == id), "{id} is not indexed by its object");
        let starts: BTreeSet<SampleId> = node.segments.iter().copied().map(SampleId::Start).collect();
        assert_eq!(node.samples.positives, starts, "{id}: positives are the start states of its segments");
        if subtract {
            let both: Vec<_> = node.samples.positives.intersection(&node.samples.negatives).collect();
            assert!(both.is_empty(), "D1, {id}: {both:?}");
        }
        assert!(node.samples.negatives.iter().all(|sample| exists(model, *sample)), "{id}: a sample of nothing");
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
    assert_eq!(end.positives, finals, "END's positives are the final states of what was carried on to it");
    assert_eq!(model.end().classifier.is_some(), !finals.is_empty());
    assert_eq!(model.parents(Place::End).count() > 0, !finals.is_empty());
    assert!(end.positives.is_disjoint(&end.negatives), "D1, END");
    assert!(end.negatives.iter().all(|sample| exists(model, *sample)));
}

fn exists<L: Learner>(model: &TaskModel<L>, sample: SampleId) -> bool {
    match sample {
        SampleId::Start(segment) => model.node_of(segment).is_some(),
        SampleId::Final(index) => model.histories().get(index as usize).is_some_and(|history| history.carried_to_end),
    }
}
