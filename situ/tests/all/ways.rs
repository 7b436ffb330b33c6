//! Decisions D18 to D23, pinned: other ways of a primitive, when a segment shows one, which one runs, and what the
//! model does and knows after that.

use std::collections::BTreeSet;

use situ::correction::Correction;
use situ::decisions::{Decisions, Limit, Modify, Ways};
use situ::demonstration::Kind;
use situ::method::rebuild::refit;
use situ::place::{Place, SampleId, SegmentId};
use situ::primitive::Learner;
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Branch, MatchedIn, Obedience};
use situ::trail::StepEnd;

use crate::common::structure::check;
use crate::common::toy::Toy;
use crate::common::{folded, written};
use crate::decisions::{A, B, Before, C, MENDED, Word, corrected, given, id, node, start, taught};

/// Far is so many units along x, for anything and in either unit.
fn rule(far: f64) -> Modify {
    let limit = Limit { metres: far, scatters: far };
    Modify { min_probability: 0.5, max_distance: 8.0, near: limit, far: limit }
}

/// Where along x the ways of a segment's node lead, the oldest first.
fn ways(model: &TaskModel<Toy>, segment: SegmentId) -> Vec<f64> {
    model.node(node(model, segment)).unwrap().ways.iter().map(|way| way.policy.x).collect()
}

#[test]
fn d18_an_unmatched_segment_shows_another_way_of_what_would_have_run() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let moved = [(1, 6.0, 1.0)];
    for (kept, expected) in [(Ways::Replace, vec![6.0]), (Ways::Keep(2), vec![0.0, 6.0])] {
        let modify = |modify| Decisions { modify, ways: kept, ..MENDED };
        let (after, steps) = corrected(&model, Some(id(0, 0)), &moved, None, modify(Some(rule(5.0))));
        assert_eq!((steps[0].branch, steps[0].matched_in, after.len()), (Branch::Modify, MatchedIn::None, 3));
        let b = after.node(node(&after, id(0, 1))).unwrap();
        assert_eq!(ways(&after, id(0, 1)), expected);
        assert_eq!(b.newest().segments, BTreeSet::from([id(2, 0)]));
        assert_eq!(b.segments, BTreeSet::from([id(0, 1), id(1, 1), id(2, 0)]), "all of them are instances of it");
        // A refit keeps what a modification replaced; forgetting would be undone by the next update.
        let (refitted, _) = refit(after.clone(), &model.1, &MENDED).unwrap();
        assert_eq!(ways(&refitted, id(0, 1)), expected);
        check(&refitted, &MENDED);

        // Beyond the cut and not far away all the same: noise, and one instance more.
        let (after, steps) = corrected(&model, Some(id(0, 0)), &moved, None, modify(Some(rule(6.1))));
        assert_eq!((steps[0].branch, steps[0].matched_in, after.len()), (Branch::Existing, MatchedIn::None, 3));
        assert_eq!(ways(&after, id(0, 1)), [2.0], "the mean of 0, 0 and 6");
        // It is far where it is far in both units.
        let scatters = Limit { metres: 0.0, scatters: 6.1 };
        let (_, steps) =
            corrected(&model, Some(id(0, 0)), &moved, None, modify(Some(Modify { far: scatters, ..rule(5.0) })));
        assert_eq!(steps[0].branch, Branch::Existing);

        // Each condition alone adds no way: the switch, the object, the state, the distance.
        let refused: [(Option<Modify>, Word); 4] = [
            (None, moved[0]),
            (Some(rule(5.0)), (2, 6.0, 1.0)),
            (Some(Modify { min_probability: 0.9, ..rule(5.0) }), (1, 6.0, 2.0)),
            (Some(Modify { max_distance: 5.0, ..rule(5.0) }), moved[0]),
        ];
        for (rule, word) in refused {
            let (after, steps) = corrected(&model, Some(id(0, 0)), &[word], None, modify(rule));
            assert_eq!((steps[0].branch, after.len()), (Branch::New, 4), "{rule:?} {word:?}");
            assert_eq!(ways(&after, id(0, 1)), [0.0]);
        }
    }
}

#[test]
fn d18_a_match_far_from_the_policy_is_another_way_and_so_is_what_ran_last_done_again() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    for (kept, expected) in [(Ways::Replace, &[1.5][..]), (Ways::Keep(2), &[0.0, 1.5])] {
        let modify = |modify| Decisions { modify, ways: kept, ..MENDED };
        // Within the cut: another way, or averaged.
        let near = [(1, 1.5, 1.0)];
        let policy = |rule| {
            let (after, steps) = corrected(&model, Some(id(0, 0)), &near, None, modify(rule));
            (steps[0].branch, after.len(), ways(&after, id(0, 1)))
        };
        assert_eq!(policy(Some(rule(1.0))), (Branch::Modify, 3, expected.to_vec()));
        assert_eq!(policy(Some(rule(1.6))), (Branch::Existing, 3, vec![0.5]));
        assert_eq!(policy(None), (Branch::Existing, 3, vec![0.5]));
        // What ran last is shown in another way where it is done again from a state like those in which it begins. In
        // any other state it is something that comes after it.
        for (state, branch) in [(1.0, Branch::Modify), (2.5, Branch::New)] {
            let word = (1, 6.0, state);
            let (_, steps) = corrected(&model, Some(id(0, 1)), &[word], None, modify(Some(rule(5.0))));
            assert_eq!(steps[0].branch, branch, "in state {state}");
        }
        // Near is for what the robot was doing, far for the others (D21).
        let unequal = Modify { far: Limit { metres: 7.0, scatters: 7.0 }, ..rule(1.0) };
        for (after, branch) in [(id(0, 1), Branch::Modify), (id(0, 0), Branch::Existing)] {
            let (_, steps) = corrected(&model, Some(after), &near, None, modify(Some(unequal)));
            assert_eq!(steps[0].branch, branch, "after {after:?}");
        }
    }
}

#[test]
fn d18_what_was_interrupted_is_the_first_to_be_shown_another_way() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let (a, b) = (node(&model.0, id(0, 0)), node(&model.0, id(0, 1)));
    for (kept, expected) in [(Ways::Replace, &[6.0][..]), (Ways::Keep(2), &[0.0, 6.0])] {
        let decisions = Decisions { modify: Some(rule(5.0)), ways: kept, ..MENDED };
        // Half way through B the world looks like nothing in which B begins; another segment of the correction comes
        // after it.
        let correct = |before: &Before| {
            let words = [(1, 6.0, 40.0), (2, 6.0, 41.0)];
            given(&(&model.0, &model.1), Some(id(0, 0)), before, &words, None, decisions)
        };
        let interrupted = |interrupted| Before { interrupted, ..Before::default() };
        let branches = |before| correct(&before).1.steps.iter().map(|step| step.branch).collect::<Vec<_>>();
        assert_eq!(branches(interrupted(None)), [Branch::New, Branch::New]);
        assert_eq!(
            branches(interrupted(Some(b))),
            [Branch::Modify, Branch::New],
            "what comes later was not interrupted"
        );
        assert_eq!(branches(interrupted(Some(a))), [Branch::New, Branch::New], "another object is no other way");
        let prevented = Before { trail: vec![(b, 1.0, StepEnd::Prevented)], ..Before::default() };
        assert_eq!(
            branches(prevented),
            [Branch::Modify, Branch::New],
            "what was kept from beginning is suspected, too"
        );
        assert_eq!(ways(&correct(&interrupted(Some(b))).0, id(0, 1)), expected);
    }
}

/// After B comes C, and then the end.
#[test]
fn d19_what_follows_a_segment_tells_what_it_is() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let (a, b, c) = (node(&model.0, id(0, 0)), node(&model.0, id(0, 1)), node(&model.0, id(0, 2)));
    let branches = |after, y, words: &[Word], end: Option<f64>, decisions: Decisions| {
        let words: Vec<_> = words.iter().map(|(object, x, state)| (*object, *x, [*state])).collect();
        let shown = written(Kind::Corrective, true, &words, [end.unwrap_or(0.0)], end.is_some());
        let correction = Correction { interrupted: y, ..Correction::after(Place::Node(after), &shown) };
        let (after, trace) = folded(correction, &model.0, &model.1, &decisions);
        check(&after, &decisions);
        trace.steps.iter().map(|step| (step.branch, step.node)).collect::<Vec<_>>()
    };
    let silent = Decisions { follow: false, ..MENDED };
    let (new, far, near) = (model.0.next_id(), (1, 60.0, 40.0), (1, 6.0, 40.0));
    // What follows B in the model follows the segment, too: it takes B's place, whatever the distance.
    let (taken, added) = ([(Branch::Modify, b), (Branch::Existing, c)], [(Branch::New, new), (Branch::Existing, c)]);
    assert_eq!(branches(a, Some(b), &[far, C], None, MENDED), taken);
    assert_eq!(branches(a, Some(b), &[far, C], None, silent), added);
    assert_eq!(branches(a, None, &[far, C], None, MENDED), taken, "a child of what ran last is suspected");
    // B itself follows it: it was put in before B, however near it is.
    assert_eq!(branches(a, Some(b), &[near, B], None, MENDED), [(Branch::New, new), (Branch::Existing, b)]);
    assert_eq!(branches(a, Some(b), &[near, B], None, silent), [(Branch::Modify, b), (Branch::Existing, b)]);
    // The end follows, too, where the correction was carried on to it.
    let last = (2, 60.0, 40.0);
    assert_eq!(branches(b, Some(c), &[last], Some(3.0), MENDED), [(Branch::Modify, c)]);
    assert_eq!(branches(b, Some(c), &[last], None, MENDED), [(Branch::New, new)], "nothing follows");
    assert_eq!(branches(b, Some(c), &[last], Some(3.0), silent), [(Branch::New, new)]);
}

#[test]
fn d20_in_its_own_world_the_older_way_runs() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, (1, 0.0, 1.1), C], Some(3.0))], 2.0);
    let (a, b) = (node(&model.0, id(0, 0)), node(&model.0, id(0, 1)));
    let correct = |model: &TaskModel<Toy>, learner: &Toy, x: f64, failed: f64, ways: Ways| {
        let before = Before::interrupted(&[(a, 0.0), (b, failed)]);
        let decisions = Decisions { ways, ..MENDED };
        given(&(model, learner), Some(id(0, 0)), &before, &[(1, x, 40.0)], None, decisions).0
    };
    // B was begun in state 5, failed, and was shown in another way.
    let after = correct(&model.0, &model.1, 10.0, 5.0, Ways::Keep(3));
    assert_eq!(ways(&after, id(0, 1)), [0.0, 10.0]);
    let runs = |model: &TaskModel<Toy>, state: f64, learner: &Toy| {
        model.way_in(b, &State::new([state]), learner.scales()).unwrap()
    };
    assert_eq!([0.9, 1.0, 1.1, 2.9, 3.2, 5.0, 6.0].map(|state| runs(&after, state, &model.1)), [0, 0, 0, 0, 1, 1, 1]);
    let wanted = |model: &TaskModel<Toy>, way: usize| model.node(b).unwrap().ways[way].wanted.clone();
    assert_eq!(wanted(&after, 0), BTreeSet::from([start(0, 1), start(1, 1)]));
    let chosen = SampleId::Chosen { demonstration: 2, index: 1 };
    assert_eq!(wanted(&after, 1), BTreeSet::from([chosen]), "not where somebody stepped in");
    // It failed on the other side, too: no feature tells, and the newest runs everywhere.
    let both = correct(&after, &model.1, 10.5, -5.0, Ways::Keep(3));
    assert_eq!(ways(&both, id(0, 1)), [0.0, 10.25], "one more instance of the new way");
    assert_eq!([-5.0, 1.0, 1.1, 5.0].map(|state| runs(&both, state, &model.1)), [1; 4]);
    // Where there is no room, the oldest goes that a correction added; what the originals show stays.
    let third = correct(&after, &model.1, 20.0, 8.0, Ways::Keep(3));
    assert_eq!(ways(&third, id(0, 1)), [0.0, 10.0, 20.0]);
    let fourth = correct(&third, &model.1, 30.0, 12.0, Ways::Keep(3));
    assert_eq!(ways(&fourth, id(0, 1)), [0.0, 20.0, 30.0]);
    assert_eq!([1.0, 8.0, 12.0].map(|state| runs(&fourth, state, &model.1)), [0, 1, 2]);
    assert_eq!(ways(&correct(&third, &model.1, 30.0, 12.0, Ways::Replace), id(0, 1)), [30.0]);
    // Without a trail the start of the correction stands for the choice.
    let before = Before { interrupted: Some(b), ..Before::default() };
    let (alone, _) = given(&(&model.0, &model.1), Some(id(0, 0)), &before, &[(1, 10.0, 40.0)], None, MENDED);
    assert_eq!(wanted(&alone, 1), BTreeSet::from([start(2, 0)]));
}

/// Two nodes of one skill, each with a way that a correction added. Merged they would have three.
#[test]
fn d20_a_merged_node_has_no_more_ways_than_any_other() {
    let model = taught(&[(&[A, B], Some(3.0)), (&[A, (1, 0.5, 1.1)], Some(3.0))], 0.05);
    let apart = Decisions { ways: Ways::Keep(2), merge_redundant: false, ..MENDED };
    let correct = |model: &TaskModel<Toy>, learner: &Toy, failed: SegmentId, x: f64| {
        let before = Before::interrupted(&[(node(model, failed), 1.0)]);
        given(&(model, learner), Some(id(0, 0)), &before, &[(1, x, 40.0 + x)], None, apart).0
    };
    let one = correct(&model.0, &model.1, id(0, 1), 10.0);
    let both = correct(&one, &model.1, id(1, 1), 20.0);
    assert_eq!([id(0, 1), id(1, 1)].map(|segment| ways(&both, segment)), [[0.0, 10.0], [0.5, 20.0]]);
    let merging = Decisions { merge_redundant: true, ..apart };
    let instance = [(1, 0.2, 1.0)];
    let third = |most| {
        let decisions = Decisions { ways: Ways::Keep(most), ..merging };
        corrected(&(both.clone(), model.1.clone()), Some(id(0, 0)), &instance, None, decisions)
    };
    let (after, steps) = third(3);
    assert_eq!(steps[0].merged.iter().map(|(group, _)| group.len()).collect::<Vec<_>>(), [2]);
    assert_eq!(ways(&after, id(0, 1))[1..], [10.0, 20.0]);
    assert_eq!(ways(&third(2).0, id(0, 1))[1..], [20.0], "the oldest goes that a correction added");
    assert_eq!(ways(&third(1).0, id(0, 1)).len(), 1);
}

/// D is new; in a state in which B began, the first in order wins, and that is B.
#[test]
fn d22_where_something_was_shown_it_is_chosen() {
    const D: Word = (3, 0.0, 1.0);
    let disobedient = Decisions { obey: false, ..MENDED };
    let correct = |model: &(TaskModel<Toy>, Toy), decisions| {
        let (after, trace) = given(&(&model.0, &model.1), Some(id(0, 0)), &Before::default(), &[D], None, decisions);
        let (a, b, d) =
            (Place::Node(node(&after, id(0, 0))), node(&after, id(0, 1)), node(&after, trace_segment(&after)));
        let chosen = after.most_probable_child(a, &State::new([1.0])).unwrap().0;
        (after.node(b).unwrap().samples.positives.clone(), chosen == Place::Node(d), trace.obedience)
    };
    let model = taught(&[(&[A, B], Some(3.0)), (&[A, (1, 0.0, 1.5)], Some(3.0))], 2.0);
    let (all, rest) = (BTreeSet::from([start(0, 1), start(1, 1)]), BTreeSet::from([start(1, 1)]));
    assert_eq!(correct(&model, disobedient), (all.clone(), false, Obedience::default()));
    let one = Obedience { retired: 1, ..Obedience::default() };
    assert_eq!(correct(&model, MENDED), (rest, true, one), "the nearest is retired");
    // A place keeps its last positive, and the trace says that the model does not obey.
    let single = taught(&[(&[A, B], Some(3.0))], 2.0);
    let none = Obedience { disobeyed: 1, ..Obedience::default() };
    assert_eq!(correct(&single, MENDED), (BTreeSet::from([start(0, 1)]), false, none));
    // What came another way is not retired.
    let other = taught(&[(&[A, B], Some(3.0)), (&[C, (1, 0.0, 1.0)], Some(3.0))], 2.0);
    let (positives, obeys, obedience) = correct(&other, MENDED);
    assert!(positives.contains(&start(1, 1)) && !obeys && obedience.disobeyed == 1, "{obedience:?}");
}

/// The task was over after A, and now B is wanted after it.
#[test]
fn d22_what_nothing_tells_from_it_is_superseded() {
    let model = taught(&[(&[A], Some(3.0)), (&[A], Some(3.2))], 2.0);
    let ends = |state: f64, decisions| {
        let before = Before::default();
        let (after, trace) =
            given(&(&model.0, &model.1), Some(id(0, 0)), &before, &[(1, 0.0, state)], Some(9.0), decisions);
        (after.end().samples.positives.clone(), trace.obedience.retired)
    };
    let [one, two, new] = [0, 1, 2].map(SampleId::Final);
    assert_eq!(ends(3.1, MENDED), (BTreeSet::from([new]), 2), "the states look alike: the newer holds");
    assert_eq!(ends(3.45, MENDED).0, BTreeSet::from([one, two, new]), "told by more than the range of the older");
    assert_eq!(ends(3.1, Decisions { obey: false, ..MENDED }), (BTreeSet::from([one, two, new]), 0));
    // What the originals show beside it is no contradiction.
    let either = taught(&[(&[A], Some(3.0)), (&[A, (1, 0.0, 3.1)], Some(9.0))], 2.0);
    let before = Before::default();
    let (after, _) = given(&(&either.0, &either.1), Some(id(0, 0)), &before, &[(1, 0.0, 3.1)], Some(9.0), MENDED);
    assert!(after.end().samples.positives.contains(&one));
}

/// What follows tells, but the segment is not displaced from what it seems to take the place of.
#[test]
fn d19_a_clumsy_instance_takes_no_place() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let far = |limit| Decisions { modify: Some(rule(limit)), ..MENDED };
    for (limit, branch) in [(4.0, Branch::Modify), (6.0, Branch::Existing)] {
        let words = [(1, 5.0, 1.0), C];
        let (after, steps) = corrected(&model, Some(id(0, 0)), &words, Some(3.0), far(limit));
        assert_eq!((steps[0].branch, steps[0].matched_in, after.len()), (branch, MatchedIn::None, 3));
    }
}

/// The first segment of the last demonstration.
fn trace_segment(model: &TaskModel<Toy>) -> SegmentId {
    id(model.histories().len() as u32 - 1, 0)
}

#[test]
fn d23_a_state_in_which_the_robot_chose_wrongly_is_one_of_what_was_shown() {
    let model = taught(&[(&[A, B, C], Some(3.0)), (&[A, B, C], Some(3.0))], 2.0);
    let (a, b) = (node(&model.0, id(0, 0)), node(&model.0, id(0, 1)));
    let chosen = SampleId::Chosen { demonstration: 2, index: 1 };
    let positives = |before: &Before, word: Word, decisions| {
        let (after, _) = given(&(&model.0, &model.1), Some(id(0, 0)), before, &[word], None, decisions);
        after.node(node(&after, trace_segment(&after))).unwrap().samples.positives.clone()
    };
    let failed = |state: f64| Before::interrupted(&[(a, 0.0), (b, state)]);
    // Something new, or C, in B's place: only where B was begun in a state unlike its others.
    for (word, own) in [((3, 0.0, 40.0), BTreeSet::new()), ((2, 0.0, 40.0), BTreeSet::from([start(0, 2), start(1, 2)]))]
    {
        let with =
            |sample: &[SampleId]| own.iter().chain(sample).copied().chain([start(2, 0)]).collect::<BTreeSet<_>>();
        assert_eq!(positives(&failed(5.0), word, MENDED), with(&[chosen]), "unlike");
        assert_eq!(positives(&failed(1.1), word, MENDED), with(&[]), "like");
        assert_eq!(
            positives(&Before { interrupted: Some(b), ..Before::default() }, word, MENDED),
            with(&[]),
            "no trail"
        );
        assert_eq!(positives(&failed(5.0), word, Decisions { trail: false, ..MENDED }), with(&[]), "not heeded");
        // What was kept from beginning counts as what was interrupted does.
        let prevented =
            Before { trail: vec![(a, 0.0, StepEnd::Finished), (b, 5.0, StepEnd::Prevented)], ..Before::default() };
        assert_eq!(positives(&prevented, word, MENDED), with(&[chosen]), "kept from beginning");
    }
    // Only the last choice of B counts, and only one that came after what ran last.
    let twice = Before::interrupted(&[(a, 0.0), (b, 5.0), (a, 0.0), (b, 1.1)]);
    assert_eq!(positives(&twice, (3, 0.0, 40.0), MENDED), BTreeSet::from([start(2, 0)]));
    let elsewhere = Before::interrupted(&[(b, 1.0), (b, 5.0)]);
    assert_eq!(positives(&elsewhere, (3, 0.0, 40.0), MENDED), BTreeSet::from([start(2, 0)]));
    // B itself, in another way: B begins there, too.
    let own = BTreeSet::from([start(0, 1), start(1, 1), start(2, 0), chosen]);
    assert_eq!(positives(&failed(1.1), (1, 10.0, 40.0), MENDED), own);
}
