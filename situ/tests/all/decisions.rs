//! Each decision about the structure of an update, pinned: what `situ` does, and what the listing does in its place.
//!
//! The learner is the one on a line. It is plain to see which policies are one, so only Algorithms 1 and 2 are at work.

use std::collections::BTreeSet;

use crate::common::structure::check;
use crate::common::toy::Toy;
use crate::common::{folded, histories, spelt};
use situ::correction::Correction;
use situ::decisions::{Background, Candidates, Decisions, Modify};
use situ::method::rebuild::{rebuild, refit};
use situ::place::{NodeId, Place, SampleId, SegmentId};
use situ::task_model::TaskModel;
use situ::trace::{Branch, MatchedIn, Step};

const MENDED: Decisions = Decisions::mended();

/// Object, place along x, start state.
type Word = (u8, f64, f64);

fn id(demonstration: u32, index: u32) -> SegmentId {
    SegmentId { demonstration, index }
}

fn start(demonstration: u32, index: u32) -> SampleId {
    SampleId::Start(id(demonstration, index))
}

/// A model of originals, each with its final state if it was carried on to the end.
fn taught(originals: &[(&[Word], Option<f64>)], width: f64) -> (TaskModel<Toy>, Toy) {
    let learner = Toy { taught: width, found: 2.0 };
    let shown: Vec<_> = originals.iter().map(|(words, end)| spelt(words, end.unwrap_or(0.0), end.is_some())).collect();
    (rebuild(histories(&shown), None, &learner, &MENDED).unwrap().0, learner)
}

/// A model after a correction that began where this segment's node had run, and the correction's steps.
fn corrected(
    (model, learner): &(TaskModel<Toy>, Toy),
    after: Option<SegmentId>,
    words: &[Word],
    end: Option<f64>,
    decisions: Decisions,
) -> (TaskModel<Toy>, Vec<Step>) {
    let last = after.map_or(Place::Start, |segment| Place::Node(model.node_of(segment).unwrap()));
    let shown = spelt(words, end.unwrap_or(0.0), end.is_some());
    let (after, trace) = folded(Correction::after(last, &shown), model, learner, &decisions);
    check(&after, decisions.subtract_own_positives);
    (after, trace.steps)
}

fn node(model: &TaskModel<Toy>, segment: SegmentId) -> NodeId {
    model.node_of(segment).unwrap()
}

fn negatives(model: &TaskModel<Toy>, segment: SegmentId) -> &BTreeSet<SampleId> {
    &model.node(node(model, segment)).unwrap().samples.negatives
}

/// The letters a, b, c stand for objects, each with one skill at x = 0; its start state is the number given.
const A: Word = (0, 0.0, 0.0);
const B: Word = (1, 0.0, 1.0);
const C: Word = (2, 0.0, 2.0);

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
    let model = taught(&[(&[A, B, C], Some(3.0))], 2.0);
    // No classifier is activated so far away.
    let far = (2, 0.0, 50.0);
    let (after, steps) = corrected(&model, Some(id(0, 0)), &[far], None, MENDED);
    assert_eq!((steps[0].applicable.len(), steps[0].matched_in, steps[0].candidates), (0, MatchedIn::Reference, 1));
    assert_eq!((after.len(), after.node_of(id(1, 0))), (3, model.0.node_of(id(0, 2))), "an edge to C");
    let printed = Decisions { candidates: Candidates::Applicable, ..MENDED };
    let (after, steps) = corrected(&model, Some(id(0, 0)), &[far], None, printed);
    assert_eq!((steps[0].matched_in, steps[0].branch), (MatchedIn::None, Branch::New));
    assert_eq!(after.len(), 4, "as printed the skill is doubled");
    let (_, steps) = corrected(&model, Some(id(0, 0)), &[C], None, MENDED);
    assert_eq!((steps[0].matched_in, steps[0].candidates), (MatchedIn::Index, 1));
    let all = Decisions { candidates: Candidates::All, ..MENDED };
    let (_, steps) = corrected(&model, Some(id(0, 0)), &[far], None, all);
    assert_eq!((steps[0].matched_in, steps[0].candidates), (MatchedIn::Index, 3));
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

#[test]
fn d18_an_unmatched_segment_replaces_the_policy_that_would_have_run() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let rule = Modify { min_probability: 0.5, max_distance: 8.0, min_displacement: 5.0 };
    let modify = |rule| Decisions { modify: rule, ..MENDED };
    let moved = [(1, 6.0, 1.0)];
    let (after, steps) = corrected(&model, Some(id(0, 0)), &moved, None, modify(Some(rule)));
    assert_eq!((steps[0].branch, steps[0].matched_in, after.len()), (Branch::Modify, MatchedIn::None, 3));
    let b = after.node(node(&after, id(0, 1))).unwrap();
    assert_eq!(b.policy_segments, BTreeSet::from([id(2, 0)]));
    assert_eq!(b.policy.x, 6.0, "the old variant is forgotten");
    assert_eq!(b.segments, BTreeSet::from([id(0, 1), id(1, 1), id(2, 0)]), "its states are kept");
    // A refit keeps what a modification replaced; forgetting would be undone by the next update.
    let (refitted, _) = refit(after.clone(), &model.1, &MENDED).unwrap();
    assert_eq!(refitted.node(node(&after, id(0, 1))).unwrap().policy.x, 6.0);
    check(&refitted, true);

    // Beyond the cut and not far away all the same: noise, and one instance more.
    let near = Modify { min_displacement: 6.1, ..rule };
    let (after, steps) = corrected(&model, Some(id(0, 0)), &moved, None, modify(Some(near)));
    assert_eq!((steps[0].branch, steps[0].matched_in, after.len()), (Branch::Existing, MatchedIn::None, 3));
    assert_eq!(after.node(node(&after, id(0, 1))).unwrap().policy.x, 2.0, "the mean of 0, 0 and 6");

    // Each condition alone keeps the old variant: the switch, the object, the state, the distance.
    let refused: [(Option<Modify>, Word); 4] = [
        (None, moved[0]),
        (Some(rule), (2, 6.0, 1.0)),
        (Some(Modify { min_probability: 0.9, ..rule }), (1, 6.0, 2.0)),
        (Some(Modify { max_distance: 5.0, ..rule }), moved[0]),
    ];
    for (rule, word) in refused {
        let (after, steps) = corrected(&model, Some(id(0, 0)), &[word], None, modify(rule));
        assert_eq!((steps[0].branch, after.len()), (Branch::New, 4), "{rule:?} {word:?}");
        assert_eq!(after.node(node(&after, id(0, 1))).unwrap().policy.x, 0.0);
    }
}

#[test]
fn d18_a_match_far_from_the_policy_replaces_it_and_so_does_another_way_of_what_ran_last() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let rule = |min_displacement| Some(Modify { min_probability: 0.5, max_distance: 8.0, min_displacement });
    let modify = |rule| Decisions { modify: rule, ..MENDED };
    // Within the cut: averaged, or taken for the policy.
    let near = [(1, 1.5, 1.0)];
    let policy = |rule| {
        let (after, steps) = corrected(&model, Some(id(0, 0)), &near, None, modify(rule));
        (steps[0].branch, after.len(), after.node(node(&after, id(0, 1))).unwrap().policy.x)
    };
    assert_eq!(policy(rule(1.0)), (Branch::Modify, 3, 1.5));
    assert_eq!(policy(rule(1.6)), (Branch::Existing, 3, 0.5));
    assert_eq!(policy(None), (Branch::Existing, 3, 0.5));
    // What ran last, shown in another way from a state in which it would not begin.
    let (after, steps) = corrected(&model, Some(id(0, 1)), &[(1, 6.0, 2.5)], None, modify(rule(5.0)));
    assert_eq!((steps[0].branch, after.len()), (Branch::Modify, 3));
    assert_eq!(after.node(node(&after, id(0, 1))).unwrap().policy.x, 6.0);
}

#[test]
fn d18_what_was_interrupted_is_the_first_to_be_shown_another_way() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let rule = Modify { min_probability: 0.5, max_distance: 8.0, min_displacement: 5.0 };
    let decisions = Decisions { modify: Some(rule), ..MENDED };
    let (a, b) = (node(&model.0, id(0, 0)), node(&model.0, id(0, 1)));
    // Half way through B the world looks like nothing in which B begins; another segment of the correction comes after
    // it.
    let shown = spelt(&[(1, 6.0, 40.0), (2, 6.0, 41.0)], 0.0, false);
    let correct = |interrupted| {
        let correction = Correction { interrupted, ..Correction::after(Place::Node(a), &shown) };
        folded(correction, &model.0, &model.1, &decisions)
    };
    let branches = |interrupted| correct(interrupted).1.steps.iter().map(|step| step.branch).collect::<Vec<_>>();
    assert_eq!(branches(None), [Branch::New, Branch::New]);
    assert_eq!(branches(Some(b)), [Branch::Modify, Branch::New], "what comes later was not interrupted");
    assert_eq!(branches(Some(a)), [Branch::New, Branch::New], "another object is no other way");
    let (after, _) = correct(Some(b));
    check(&after, true);
    assert_eq!(after.node(b).unwrap().policy.x, 6.0);
}
