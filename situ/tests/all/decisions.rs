//! Each decision about the structure of an update, pinned: what `situ` does, and what the listing does in its place.
//! Those about ways, D18 to D23, are in [`crate::ways`].
//!
//! The learner is the one on a line. It is plain to see which policies are one, so only Algorithms 1 and 2 are at work.

use std::collections::BTreeSet;

use crate::common::structure::check;
use crate::common::toy::Toy;
use crate::common::{corrective, folded, histories, spelt};
use situ::correction::Correction;
use situ::decisions::{Background, Candidates, Decisions};
use situ::method::rebuild::rebuild;
use situ::place::{NodeId, Place, SampleId, SegmentId};
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Branch, MatchedIn, Step, Trace};
use situ::trail::{StepEnd, TrailStep};

pub(crate) const MENDED: Decisions = Decisions::mended();

/// Object, place along x, start state.
pub(crate) type Word = (u8, f64, f64);

pub(crate) fn id(demonstration: u32, index: u32) -> SegmentId {
    SegmentId { demonstration, index }
}

pub(crate) fn start(demonstration: u32, index: u32) -> SampleId {
    SampleId::Start(id(demonstration, index))
}

/// A model of originals, each with its final state if it was carried on to the end.
pub(crate) fn taught(originals: &[(&[Word], Option<f64>)], width: f64) -> (TaskModel<Toy>, Toy) {
    let learner = Toy::on_a_line(width);
    let shown: Vec<_> = originals.iter().map(|(words, end)| spelt(words, end.unwrap_or(0.0), end.is_some())).collect();
    (rebuild(histories(&shown), None, &learner, &MENDED).unwrap().0, learner)
}

/// A model after a correction that began where this segment's node had run, and the correction's steps.
pub(crate) fn corrected(
    (model, learner): &(TaskModel<Toy>, Toy),
    after: Option<SegmentId>,
    words: &[Word],
    end: Option<f64>,
    decisions: Decisions,
) -> (TaskModel<Toy>, Vec<Step>) {
    let (after, trace) = given(&(model, learner), after, &Before::default(), words, end, decisions);
    (after, trace.steps)
}

/// What happened before a correction: what was interrupted, and the choices, each with its state and how it ended.
#[derive(Clone, Default)]
pub(crate) struct Before {
    pub(crate) interrupted: Option<NodeId>,
    pub(crate) trail: Vec<(NodeId, f64, StepEnd)>,
}

impl Before {
    /// These choices, of which the last was interrupted.
    pub(crate) fn interrupted(trail: &[(NodeId, f64)]) -> Self {
        let (last, others) = trail.split_last().unwrap();
        let mut trail: Vec<_> = others.iter().map(|(node, state)| (*node, *state, StepEnd::Finished)).collect();
        trail.push((last.0, last.1, StepEnd::Interrupted));
        Self { interrupted: Some(last.0), trail }
    }
}

/// The same as [`corrected`], for a robot that knows what it did; and the whole trace.
pub(crate) fn given(
    (model, learner): &(&TaskModel<Toy>, &Toy),
    after: Option<SegmentId>,
    before: &Before,
    words: &[Word],
    end: Option<f64>,
    decisions: Decisions,
) -> (TaskModel<Toy>, Trace) {
    let shown = corrective(words, end.unwrap_or(0.0), end.is_some());
    let step =
        |(node, state, end): &(NodeId, f64, StepEnd)| TrailStep { state: State::new([*state]), node: *node, end: *end };
    let trail: Vec<TrailStep> = before.trail.iter().map(step).collect();
    let last = after.map_or(Place::Start, |segment| Place::Node(model.node_of(segment).unwrap()));
    let correction = Correction { interrupted: before.interrupted, trail: &trail, ..Correction::after(last, &shown) };
    let (after, trace) = folded(correction, model, learner, &decisions);
    check(&after, &decisions);
    (after, trace)
}

pub(crate) fn node(model: &TaskModel<Toy>, segment: SegmentId) -> NodeId {
    model.node_of(segment).unwrap()
}

fn negatives(model: &TaskModel<Toy>, segment: SegmentId) -> &BTreeSet<SampleId> {
    &model.node(node(model, segment)).unwrap().samples.negatives
}

/// The letters a, b, c stand for objects, each with one skill at x = 0; its start state is the number given.
pub(crate) const A: Word = (0, 0.0, 0.0);
pub(crate) const B: Word = (1, 0.0, 1.0);
pub(crate) const C: Word = (2, 0.0, 2.0);

#[test]
fn d1_a_primitive_is_no_counterexample_of_itself() {
    let model = taught(&[(&[A, B], Some(3.0)), (&[A, B], Some(3.0))], 2.0);
    let (after, steps) = corrected(&model, Some(id(0, 0)), &[B], None, MENDED);
    assert_eq!(steps[0].branch, Branch::Existing);
    assert!(negatives(&after, id(0, 1)).is_disjoint(&BTreeSet::from([start(0, 1), start(1, 1), start(2, 0)])));
    // As printed, B is a child of its parent A, and S(children(A)) holds B's own start states.
    let printed = Decisions { subtract_own_positives: false, ..MENDED };
    let (after, _) = corrected(&model, Some(id(0, 0)), &[B], None, printed);
    assert!(negatives(&after, id(0, 1)).is_superset(&BTreeSet::from([start(0, 1), start(1, 1)])));
}

#[test]
fn d2_a_new_primitive_without_siblings_has_background_negatives() {
    let model = taught(&[(&[A, B], None)], 2.0);
    let (after, steps) = corrected(&model, Some(id(0, 1)), &[C], None, MENDED);
    assert_eq!((steps[0].branch, steps[0].edge_added), (Branch::New, true));
    assert_eq!(*negatives(&after, id(1, 0)), BTreeSet::from([start(0, 0), start(0, 1)]), "predecessor and others");
    let neighbours = Decisions { background: Background { neighbours: true, others: 0 }, ..MENDED };
    let (after, _) = corrected(&model, Some(id(0, 1)), &[C], None, neighbours);
    assert_eq!(*negatives(&after, id(1, 0)), BTreeSet::from([start(0, 1)]), "the predecessor alone");
    let none = Decisions { background: Background { neighbours: false, others: 0 }, ..MENDED };
    let (after, _) = corrected(&model, Some(id(0, 1)), &[C], None, none);
    assert!(negatives(&after, id(1, 0)).is_empty(), "one class");
}

#[test]
fn d3_siblings_learn_where_they_do_not_begin() {
    // After A comes B, or the end.
    let model = taught(&[(&[A, B], Some(3.0)), (&[A], Some(4.0))], 2.0);
    let silent = Decisions { push_to_siblings: false, ..MENDED };
    for (decisions, told) in [(MENDED, true), (silent, false)] {
        let (after, _) = corrected(&model, Some(id(0, 0)), &[C], None, decisions);
        assert_eq!(negatives(&after, id(0, 1)).contains(&start(2, 0)), told, "B");
        assert_eq!(after.end().samples.negatives.contains(&start(2, 0)), told, "END");
        // The new one learns from its siblings whatever the decision (A2.7).
        assert!(negatives(&after, id(2, 0)).is_superset(&BTreeSet::from([start(0, 1), SampleId::Final(0)])));
        // A known skill tells its siblings, too, and so does the end of a correction.
        let (after, steps) = corrected(&model, Some(id(0, 0)), &[B], None, decisions);
        assert_eq!(steps[0].branch, Branch::Existing);
        assert_eq!(after.end().samples.negatives.contains(&start(2, 0)), told, "END, of B");
        let (after, _) = corrected(&model, None, &[A], Some(5.0), decisions);
        assert_eq!(negatives(&after, id(0, 1)).contains(&SampleId::Final(2)), told, "B, of the end after A");
        assert!(after.end().samples.negatives.contains(&start(0, 1)), "END learns where B begins: both follow A");
    }
}

#[test]
fn d4_a_segment_joins_its_cluster_once_and_redundant_candidates_merge() {
    // Four originals, a node each for skills that are near: a at 0.0 and 0.5, and a at 10.0 and 10.5.
    let words: [&[Word]; 4] = [&[A], &[(0, 0.5, 0.1)], &[(0, 10.0, 0.2)], &[(0, 10.5, 0.3)]];
    let model = taught(&words.map(|words| (words, None)), 0.05);
    assert_eq!(model.0.len(), 4);
    let all = Decisions { candidates: Candidates::All, modify: None, ..MENDED };
    let (after, steps) = corrected(&model, None, &[(0, 0.2, 0.0)], None, all);
    assert_eq!(after.len(), 2, "its own cluster and the other one");
    let segments = |segment| after.node(node(&after, segment)).unwrap().segments.clone();
    assert_eq!(segments(id(4, 0)), BTreeSet::from([id(0, 0), id(1, 0), id(4, 0)]));
    assert_eq!(segments(id(2, 0)), BTreeSet::from([id(2, 0), id(3, 0)]));
    assert_eq!(steps[0].merged.len(), 2);
    let apart = Decisions { merge_redundant: false, ..all };
    let (after, _) = corrected(&model, None, &[(0, 0.2, 0.0)], None, apart);
    assert_eq!(after.len(), 3, "the other cluster is left apart");
    let (after, steps) = corrected(&model, None, &[(0, 20.0, 0.0)], None, apart);
    assert_eq!((after.len(), steps[0].branch), (5, Branch::New), "alone it is a new node");
}

#[test]
fn d9_what_ran_last_may_be_merged_away() {
    let originals: [(&[Word], _); 2] = [(&[A, B], Some(3.0)), (&[(0, 0.5, 0.0), B], Some(3.0))];
    let model = taught(&originals, 0.05);
    assert_eq!(model.0.len(), 3, "two nodes of one skill, and B");
    let gone = [id(0, 0), id(1, 0)].map(|segment| node(&model.0, segment));
    // The same skill once more: it merges with what ran last, and follows itself.
    let (after, steps) = corrected(&model, Some(id(1, 0)), &[(0, 0.2, 0.0)], None, MENDED);
    let merged = node(&after, id(0, 0));
    assert_eq!(steps[0].merged, [(gone.to_vec(), merged)]);
    assert!(gone.iter().all(|id| after.node(*id).is_err()), "ids are never used again");
    let (a, b) = (Place::Node(merged), Place::Node(node(&after, id(0, 1))));
    assert_eq!(steps[0].after, a);
    assert_eq!(after.edges().collect::<BTreeSet<_>>(), [(Place::Start, a), (a, a), (a, b), (b, Place::End)].into());
    // Another skill of that object: it is new, and follows what the last one was merged into.
    let unmodified = Decisions { modify: None, ..MENDED };
    let (after, steps) = corrected(&model, Some(id(1, 0)), &[(0, 10.0, 0.0), B], None, unmodified);
    let (a, new) = (Place::Node(node(&after, id(0, 0))), Place::Node(node(&after, id(2, 0))));
    assert_eq!((steps[0].branch, steps[0].after, steps[0].edge_added), (Branch::New, a, true));
    assert!(after.children(a).eq([b, new]) && after.children(new).eq([b]) && after.children(b).eq([Place::End]));
}

#[test]
fn d10_a_skill_in_a_new_state_is_found_by_its_object() {
    // Two skills on the last object.
    let model = taught(&[(&[A, B, C, A, (2, 50.0, 4.0)], Some(5.0))], 2.0);
    // No classifier is activated so far away. The likeliest of the object is the other skill, and then comes C.
    let far = (2, 0.0, 50.0);
    let (after, steps) = corrected(&model, Some(id(0, 0)), &[far], None, MENDED);
    let other = node(&model.0, id(0, 4));
    assert_eq!(steps[0].applicable, [other]);
    assert_eq!((steps[0].matched_in, steps[0].candidates), (MatchedIn::Reference, 2));
    assert_eq!((after.len(), after.node_of(id(1, 0))), (4, model.0.node_of(id(0, 2))), "an edge to C");
    let printed = Decisions { candidates: Candidates::Applicable, ..MENDED };
    let (after, steps) = corrected(&model, Some(id(0, 0)), &[far], None, printed);
    assert_eq!((steps[0].matched_in, steps[0].branch), (MatchedIn::None, Branch::New));
    assert_eq!(after.len(), 5, "as printed the skill is doubled");
    let (_, steps) = corrected(&model, Some(id(0, 0)), &[C], None, MENDED);
    assert_eq!((steps[0].matched_in, steps[0].candidates), (MatchedIn::Index, 1));
    let all = Decisions { candidates: Candidates::All, ..MENDED };
    let (_, steps) = corrected(&model, Some(id(0, 0)), &[far], None, all);
    assert_eq!((steps[0].matched_in, steps[0].candidates), (MatchedIn::Index, 4));
    // Where the robot last chose what it should not have done, C is applicable.
    let b = node(&model.0, id(0, 1));
    let before = Before::interrupted(&[(node(&model.0, id(0, 0)), 0.0), (b, 2.0)]);
    let (_, trace) = given(&(&model.0, &model.1), Some(id(0, 0)), &before, &[far], None, MENDED);
    let c = node(&model.0, id(0, 2));
    assert_eq!((&trace.steps[0].applicable[..], trace.steps[0].matched_in), (&[c][..], MatchedIn::Index));
}

#[test]
fn d11_only_what_is_carried_on_ends_the_task() {
    let model = taught(&[(&[A, B], None)], 2.0);
    assert!(model.0.end().classifier.is_none() && model.0.parents(Place::End).count() == 0);
    let (after, _) = corrected(&model, None, &[B], None, MENDED);
    let b = Place::Node(node(&after, id(0, 1)));
    assert!(after.children(Place::Start).any(|child| child == b), "a correction can begin at START");
    assert!(after.end().samples.positives.is_empty() && after.children(b).count() == 0);
    let (after, _) = corrected(&model, None, &[B], Some(3.0), MENDED);
    assert_eq!(after.end().samples.positives, BTreeSet::from([SampleId::Final(1)]));
    assert!(after.end().samples.negatives.contains(&start(0, 1)), "the task is not over where its parent begins (D2)");
    assert!(after.children(b).eq([Place::End]));
    let state = after.state(SampleId::Final(1)).clone();
    assert_eq!(after.most_probable_child(b, &state).unwrap().0, Place::End);
}
