//! How people take things: the spread of their grasps, and that what is in the hand gets to where it belongs.
//!
//! The figures that a person's grasps are held against come from recordings of people (see the profile `person`). They
//! are measured on what a teacher has recorded, as they were on what the people had; nothing here knows how the grasps
//! are drawn.

use std::collections::BTreeMap;

use situ::demonstration::{Gripper, Kind, Pose};
use situ_tasks::Episode;
use situ_teachers::{Profile, Shown, Spread, Way};

use crate::teachers::{demonstrate, named, setting};

/// One whole demonstration, be it clean or not.
fn shown(profile: &Profile, task: &str, seed: u64) -> Shown {
    let mut episode = Episode::start(&setting(task, None), seed).unwrap();
    demonstrate(profile.clone(), Kind::Original, &mut episode, seed, &mut |_| ())
}

/// The grasps of a demonstration, by skill: the gripper's pose in the frame of what it closes on.
fn grasps(shown: &Shown) -> BTreeMap<String, Pose> {
    let mut grasps = BTreeMap::new();
    for keyframe in shown.demonstration.iter().flat_map(|demonstration| demonstration.keyframes()) {
        if matches!(keyframe.gripper, Gripper::Close(_)) {
            let skill = keyframe.narration.as_deref().unwrap();
            let pose = keyframe.reference_pose.inverse() * keyframe.gripper_pose;
            // The hand stays closed until the end of the skill, and beyond: its first closed keyframe is the grasp.
            grasps.entry(skill.to_owned()).or_insert(pose);
        }
    }
    grasps.retain(|skill, _| skill.starts_with("pick"));
    grasps
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// All pairs of grasps of one thing: the medians of metres and of radians between them.
fn medians(things: &BTreeMap<String, Vec<Pose>>) -> (f64, f64) {
    let pairs = things.values().flat_map(|grasps| {
        grasps.iter().enumerate().flat_map(|(index, one)| grasps[..index].iter().map(move |other| (one, other)))
    });
    let apart = pairs.clone().map(|(one, other)| (one.translation.vector - other.translation.vector).norm());
    (median(apart.collect()), median(pairs.map(|(one, other)| one.rotation.angle_to(&other.rotation)).collect()))
}

/// The six cubes of *sort_blocks* and *stack*, which may be taken in any way that the hand allows.
#[test]
fn two_grasps_of_a_person_are_as_far_apart_as_those_of_people() {
    /// Of 374 pairs.
    const PEOPLE: (f64, f64) = (0.019, 31.0);
    /// Some 250 grasps: three standard errors of either median.
    const TOLERANCE: (f64, f64) = (0.0025, 5.0);
    let person = named("person");
    let taken = |task: &'static str| {
        let person = &person;
        move || -> Vec<(String, Pose)> { (1..=50).flat_map(|seed| grasps(&shown(person, task, seed))).collect() }
    };
    let mut things: BTreeMap<String, Vec<Pose>> = BTreeMap::new();
    let all = std::thread::scope(|scope| {
        let threads = ["sort_blocks", "stack"].map(|task| scope.spawn(taken(task)));
        threads.map(|thread| thread.join().unwrap()).concat()
    });
    for (skill, grasp) in all {
        things.entry(skill).or_default().push(grasp);
    }
    let (metres, radians) = medians(&things);
    let count: usize = things.values().map(Vec::len).sum();
    assert!(count > 200 && things.len() == 6, "{count} grasps of {} things", things.len());
    assert!((metres - PEOPLE.0).abs() < TOLERANCE.0, "{metres} m");
    assert!((radians.to_degrees() - PEOPLE.1).abs() < TOLERANCE.1, "{}°", radians.to_degrees());
}

/// A cube that is taken centimetres from its middle and put by its script's hand, and not by where it is, would not be
/// on the other one, or centimetres from where it is by the expert.
#[test]
fn what_is_in_the_hand_gets_to_where_it_belongs() {
    let spread = Spread { position: 0.01, rotation: 25.0, freedom: 3 };
    let wide = Profile { grasp: spread, ..named("expert") };
    let place = |profile: &Profile, seed| {
        let mut episode = Episode::start(&setting("stack", None), seed).unwrap();
        let shown = demonstrate(profile.clone(), Kind::Original, &mut episode, seed, &mut |_| ());
        let [base, middle] = ["base", "middle"].map(|name| episode.world().pose(name).unwrap().translation.vector);
        (grasps(&shown).remove("pick_middle"), shown.clean.then_some(middle - base))
    };
    let (mut tried, mut taken_off) = (0, 0.0_f64);
    for seed in 1..=12 {
        let ((grasp, at), (own, right)) = (place(&wide, seed), place(&named("expert"), seed));
        let (Some(at), Some(right)) = (at, right) else { continue };
        tried += 1;
        taken_off = taken_off.max((grasp.unwrap().translation.vector - own.unwrap().translation.vector).norm());
        assert!((at - right).norm() < 0.004, "seed {seed}: {at} instead of {right}");
    }
    assert!(tried >= 8 && taken_off > 0.015, "{tried} of 12, {taken_off} m");
}

/// The turns of the gripper against the expert's, in degrees, from keyframe to keyframe of a task.
fn turns(profile: &Profile, task: &str) -> (Shown, Vec<f64>) {
    let (own, other) = (shown(profile, task, 3), shown(&named("expert"), task, 3));
    let poses = |shown: &Shown| -> Vec<Pose> {
        shown.demonstration.iter().flat_map(|shown| shown.keyframes()).map(|keyframe| keyframe.gripper_pose).collect()
    };
    let pairs = poses(&own).into_iter().zip(poses(&other));
    let turns = pairs.map(|(one, other)| one.rotation.angle_to(&other.rotation).to_degrees()).collect();
    (own, turns)
}

#[test]
fn a_thing_is_taken_and_kept_from_another_side_and_a_button_is_pressed_as_ever() {
    for (profile, way, angle) in [
        (Profile { other_side: 1.0, ..named("expert") }, Way::OtherSide, 90.0),
        (Profile { half_turn: 1.0, ..named("expert") }, Way::HalfTurn, 180.0),
    ] {
        let (shown, turned) = turns(&profile, "stack");
        assert!(shown.clean && shown.tally.of(way).happened == 2, "{:?}", shown.tally.of(way));
        assert!(turned.len() == 12 && turned.iter().all(|turn| (turn - angle).abs() < 4.0), "{turned:?}");
        let (shown, turned) = turns(&profile, "press");
        assert!(shown.clean && shown.tally.of(way).chances == 0, "a fist takes nothing");
        assert!(turned.iter().all(|turn| *turn < 1e-6), "{turned:?}");
    }
    // The handle of a pitcher leaves no room for a finger on its inner side: whoever sees that takes it as ever.
    let (shown, turned) = turns(&Profile { other_side: 1.0, ..named("expert") }, "pour");
    assert!(shown.clean && turned.iter().all(|turn| *turn < 0.5), "{turned:?}");
    assert!(shown.tally.of(Way::OtherSide).happened > 1, "it was thought of");
}
