//! What a correction does to keyframe clusters.

use proptest::prelude::*;
use situ::demonstration::Gripper;
use situ::keyframe::pose::log;
use situ::method::refinement::Refine;
use situ::method::refinement::alignment::{Stop, align, distance};
use situ::method::refinement::keyframe_model::KeyframeModel;
use situ::segment::RelativeKeyframe;

use super::fixture::{keyframe, moved, pick, policy, segment};

/// The keyframes after corrections of the pick, which three equal demonstrations taught.
fn corrected(corrections: &[Vec<RelativeKeyframe>]) -> Vec<RelativeKeyframe> {
    let original = segment(pick());
    let originals = [&original; 3];
    let mut primitive = KeyframeModel.fit(&policy(&originals), &originals, &mut Default::default()).unwrap();
    for shown in corrections {
        KeyframeModel.correct(&mut primitive, &segment(shown.clone()), &mut Default::default()).unwrap();
    }
    KeyframeModel.keyframes(&primitive).iter().map(|keyframe| keyframe.mean).collect()
}

fn assert_same(found: &[RelativeKeyframe], expected: &[RelativeKeyframe]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!(log(&found.pose, &expected.pose).norm() < 1e-9, "keyframe {index}: {found:?} for {expected:?}");
        assert!((found.gripper.value() - expected.gripper.value()).abs() < 1e-9, "keyframe {index}");
        assert!((found.hold - expected.hold).abs() < 1e-9, "keyframe {index}");
    }
}

#[test]
fn what_is_as_it_was_changes_nothing() {
    assert_same(&corrected(&[]), &pick());
    assert_same(&corrected(&[pick()]), &pick());
    assert_same(&corrected(&[pick(), pick()]), &pick());
}

#[test]
fn one_keyframe_moved_moves_one_cluster() {
    for index in 0..pick().len() {
        let mut shown = pick();
        shown[index] = moved(&shown[index], [0.07, 0.0, 0.0975]);
        assert_same(&corrected(std::slice::from_ref(&shown)), &shown);
    }
}

#[test]
fn the_whole_path_moved_moves_every_cluster() {
    let shown: Vec<_> = pick().iter().map(|keyframe| moved(keyframe, [0.07, 0.0, 0.0975])).collect();
    assert_same(&corrected(std::slice::from_ref(&shown)), &shown);
}

/// Noise is averaged: a keyframe that is 2 cm off is the fourth instance, so it moves its cluster by half a centimetre.
/// Up to 5 cm are noise, 6 cm are not.
#[test]
fn an_instance_is_averaged_in() {
    for (off, moves) in [(0.02, 0.005), (0.05, 0.0125), (0.06, 0.06)] {
        let mut shown = pick();
        shown[2] = moved(&shown[2], [off, 0.0, 0.0]);
        let mut expected = pick();
        expected[2] = moved(&expected[2], [moves, 0.0, 0.0]);
        assert_same(&corrected(&[shown]), &expected);
    }
}

#[test]
fn an_added_keyframe_is_added_at_its_place() {
    for (at, place, closed) in [(1, [-0.2, 0.0, 0.3], false), (4, [0.1, 0.2, 0.25], true), (5, [0.4, 0.2, 0.3], true)] {
        let mut shown = pick();
        shown.insert(at, keyframe(place, closed));
        assert_same(&corrected(std::slice::from_ref(&shown)), &shown);
    }
}

/// A keyframe on the way adds nothing to the way. A keyframe that opens the hand there does.
#[test]
fn a_needless_keyframe_is_not_added() {
    let mut shown = pick();
    shown.insert(3, keyframe([0.01, 0.0, 0.12], true));
    assert_same(&corrected(std::slice::from_ref(&shown)), &pick());
    shown[3] = keyframe([0.01, 0.0, 0.12], false);
    assert_eq!(corrected(&[shown]).len(), 6);
}

#[test]
fn a_free_keyframe_left_out_is_deleted_and_what_is_on_the_way_or_a_contact_is_not() {
    // The keyframe beside the object is far off the straight way down.
    let mut shown = pick();
    shown.remove(1);
    assert_same(&corrected(std::slice::from_ref(&shown)), &shown);
    // The lift is off the straight way from the grasp to the side, too.
    let mut shown = pick();
    shown.remove(3);
    assert_same(&corrected(std::slice::from_ref(&shown)), &shown);
    // Without the grasp there is no pick. The ends are not shown, so the correction says nothing about them.
    for left_out in [2, 0, 4] {
        let mut shown = pick();
        shown.remove(left_out);
        assert_same(&corrected(&[shown]), &pick());
    }
    // A keyframe on the way stays if it is forgotten.
    let mut long = pick();
    long.insert(3, keyframe([0.0, 0.0, 0.12], true));
    let original = segment(long.clone());
    let mut primitive = KeyframeModel.fit(&policy(&[&original]), &[&original], &mut Default::default()).unwrap();
    KeyframeModel.correct(&mut primitive, &segment(pick()), &mut Default::default()).unwrap();
    assert_eq!(primitive.0.len(), long.len());
}

fn stops(most: usize) -> impl Strategy<Value = Vec<Stop>> {
    let stop = (prop::array::uniform3(-0.2..0.2_f64), any::<bool>()).prop_map(|(place, closed)| {
        let RelativeKeyframe { pose, gripper, .. } = keyframe(place, closed);
        Stop { pose, gripper }
    });
    prop::collection::vec(stop, 0..=most)
}

/// The least cost of aligning the lists, by trying every way.
fn least(model: &[Stop], shown: &[Stop]) -> f64 {
    let (Some((m, model_rest)), Some((s, shown_rest))) = (model.split_first(), shown.split_first()) else {
        return 0.15 * (model.len() + shown.len()) as f64;
    };
    let alone = (0.15 + least(model_rest, shown)).min(0.15 + least(model, shown_rest));
    if m.is_closed() != s.is_closed() {
        return alone;
    }
    alone.min(distance(&m.pose, &s.pose) + least(model_rest, shown_rest))
}

proptest! {
    #[test]
    fn the_alignment_is_the_best_of_all(model in stops(5), shown in stops(5)) {
        let pairs = align(&model, &shown);
        prop_assert!(pairs.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1));
        let mut cost = 0.15 * (model.len() + shown.len() - 2 * pairs.len()) as f64;
        for (i, j) in pairs {
            prop_assert_eq!(model[i].is_closed(), shown[j].is_closed());
            cost += distance(&model[i].pose, &shown[j].pose);
        }
        prop_assert!((cost - least(&model, &shown)).abs() < 1e-12);
    }
}

#[test]
fn a_hand_is_closed_below_half_its_stroke() {
    let closed = |gripper| Stop { gripper, ..Stop::from(&pick()[0]) }.is_closed();
    assert!(closed(Gripper::Close(0.0)) && !closed(Gripper::Open(0.0)));
    for (share, expected) in [(0.0, true), (0.499, true), (0.5, false), (1.0, false)] {
        assert_eq!(closed(Gripper::Opening(share)), expected, "{share}");
    }
}
