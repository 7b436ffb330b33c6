//! The conditions against states whose label is known because physics was made to produce them: true, near miss, dropped later.

use std::sync::Arc;

use situ_sim::{Gripper, Pose, pose_at, rotation_about};
use situ_tasks::{Episode, Predicate, Registry, Setting};

fn setting(task: &str, variation: Option<&str>) -> Arc<Setting> {
    let registry = Registry::builtin().expect("the library is sound");
    registry.get(task).and_then(|task| task.variation(variation)).unwrap_or_else(|error| panic!("{error}"))
}

fn start(task: &str, variation: Option<&str>) -> Episode {
    Episode::start(&setting(task, variation), 11).unwrap_or_else(|error| panic!("{error}"))
}

/// Moves to a pose relative to an object as it is now.
fn go(episode: &mut Episode, reference: &str, at: [f64; 3], pitch: f64, gripper: Option<Gripper>) {
    let frame = episode.reference_pose(reference).expect("the object is there");
    let local: Pose = pose_at(at, rotation_about([0.0, 1.0, 0.0], pitch));
    episode.perform(&(frame * local), gripper, 0.0, &mut |_| {});
}

#[track_caller]
fn expect(episode: &Episode, text: &str, label: bool) {
    let predicate = Predicate::parse(text).expect("a condition");
    assert_eq!(episode.holds(&predicate), label, "{text}");
}

const OPEN: Option<Gripper> = Some(Gripper::Open(0.08));
const CLOSE: Option<Gripper> = Some(Gripper::Close(30.0));

fn pick(episode: &mut Episode, block: &str) {
    go(episode, block, [0.0, 0.0, 0.13], 0.0, OPEN);
    go(episode, block, [0.0, 0.0, 0.012], 0.0, CLOSE);
    go(episode, block, [0.0, 0.0, 0.15], 0.0, None);
}

#[test]
fn held() {
    let mut episode = start("sort_blocks", None);
    expect(&episode, "held(red_1)", false);
    // Near miss: the fingers are around the cube, but open.
    go(&mut episode, "red_1", [0.0, 0.0, 0.13], 0.0, OPEN);
    go(&mut episode, "red_1", [0.0, 0.0, 0.012], 0.0, None);
    expect(&episode, "held(red_1)", false);
    episode.perform(&episode.world().tcp(), CLOSE, 0.0, &mut |_| {});
    expect(&episode, "held(red_1)", true);
    go(&mut episode, "red_1", [0.0, 0.0, 0.15], 0.0, None);
    expect(&episode, "held(red_1)", true);
    expect(&episode, "held(red_2)", false);
    // Dropped later.
    episode.perform(&episode.world().tcp(), OPEN, 0.5, &mut |_| {});
    expect(&episode, "held(red_1)", false);
    // Near miss: closed on air beside the cube.
    go(&mut episode, "red_1", [0.0, 0.12, 0.05], 0.0, CLOSE);
    expect(&episode, "held(red_1)", false);
}

#[test]
fn inside() {
    let mut episode = start("sort_blocks", None);
    expect(&episode, "inside(red_1, red_bin)", false);
    pick(&mut episode, "red_1");
    // Near miss: over the bin, but above its rim.
    go(&mut episode, "red_bin", [0.0, 0.0, 0.17], 0.0, None);
    expect(&episode, "inside(red_1, red_bin)", false);
    go(&mut episode, "red_bin", [0.0, 0.0, 0.10], 0.0, Some(Gripper::Open(0.065)));
    go(&mut episode, "red_bin", [0.0, 0.0, 0.17], 0.0, None);
    expect(&episode, "inside(red_1, red_bin)", true);
    expect(&episode, "inside(red_1, blue_bin)", false);
    expect(&episode, "inside(red_2, red_bin)", false);
    // A second cube, on top of the first, is inside, too.
    pick(&mut episode, "red_2");
    go(&mut episode, "red_bin", [0.0, 0.0, 0.17], 0.0, None);
    go(&mut episode, "red_bin", [0.0, 0.0, 0.10], 0.0, Some(Gripper::Open(0.065)));
    go(&mut episode, "red_bin", [0.0, 0.0, 0.17], 0.0, None);
    expect(&episode, "all(inside(red_1, red_bin), inside(red_2, red_bin))", true);
    // Taken out again and dropped outside.
    pick(&mut episode, "red_2");
    go(&mut episode, "red_bin", [-0.18, 0.0, 0.20], 0.0, OPEN);
    expect(&episode, "inside(red_2, red_bin)", false);
}

#[test]
fn on() {
    let mut episode = start("sort_blocks", None);
    pick(&mut episode, "red_1");
    go(&mut episode, "blue_1", [0.0, 0.0, 0.13], 0.0, None);
    expect(&episode, "on(red_1, blue_1)", false);
    go(&mut episode, "blue_1", [0.0, 0.0, 0.053], 0.0, OPEN);
    go(&mut episode, "blue_1", [0.0, 0.0, 0.15], 0.0, None);
    expect(&episode, "on(red_1, blue_1)", true);
    expect(&episode, "on(blue_1, red_1)", false);
    // Dropped later: taken off, and put down touching, side by side.
    pick(&mut episode, "red_1");
    expect(&episode, "on(red_1, blue_1)", false);
    let frame = episode.reference_pose("blue_1").expect("there");
    for z in [0.15, 0.0132] {
        episode.perform(&(frame * Pose::translation(0.0405, 0.0, z)), None, 0.0, &mut |_| {});
    }
    episode.perform(&episode.world().tcp(), Some(Gripper::Open(0.06)), 0.3, &mut |_| {});
    let push = frame * Pose::translation(0.030, 0.0, 0.0132);
    episode.perform(&push, None, 0.0, &mut |_| {});
    assert!(episode.world().touching("red_1", "blue_1"), "the near miss is none");
    expect(&episode, "on(red_1, blue_1)", false);
}

#[test]
fn a_lid_is_on_until_it_is_lifted() {
    let mut episode = start("pour", Some("lid"));
    expect(&episode, "on(lid, pitcher)", true);
    expect(&episode, "on(lid, bowl)", false);
    go(&mut episode, "lid", [0.0, 0.0, 0.12], 0.0, Some(Gripper::Open(0.06)));
    go(&mut episode, "lid", [0.0, 0.0, 0.020], 0.0, Some(Gripper::Close(20.0)));
    expect(&episode, "all(on(lid, pitcher), held(lid))", true);
    go(&mut episode, "lid", [0.0, 0.0, 0.12], 0.0, None);
    expect(&episode, "on(lid, pitcher)", false);
    // Over the bowl is not inside; dropped into it is.
    go(&mut episode, "bowl", [0.0, 0.0, 0.17], 0.0, None);
    expect(&episode, "inside(lid, bowl)", false);
    go(&mut episode, "bowl", [0.0, 0.0, 0.075], 0.0, Some(Gripper::Open(0.06)));
    go(&mut episode, "bowl", [0.0, 0.0, 0.17], 0.0, None);
    expect(&episode, "inside(lid, bowl)", true);
}

#[test]
fn filled_upright_and_at() {
    let mut episode = start("pour", None);
    expect(&episode, "filled(pitcher, 1)", true);
    expect(&episode, "filled(bowl, 0.05)", false);
    go(&mut episode, "pitcher", [-0.08, 0.0, 0.17], 0.0, Some(Gripper::Open(0.06)));
    go(&mut episode, "pitcher", [-0.08, 0.0, 0.06], 0.0, CLOSE);
    go(&mut episode, "mat", [-0.08, 0.0, 0.16], 0.0, None);
    // Near miss: over the mat and still, but held.
    episode.perform(&episode.world().tcp(), None, 0.5, &mut |_| {});
    expect(&episode, "at(pitcher, mat, 0.05)", false);
    go(&mut episode, "mat", [-0.08, 0.0, 0.062], 0.0, Some(Gripper::Open(0.06)));
    expect(&episode, "at(pitcher, mat, 0.05)", true);
    // Near miss: put down 10 cm beside it.
    episode.perform(&episode.world().tcp(), CLOSE, 0.0, &mut |_| {});
    go(&mut episode, "mat", [-0.08, 0.10, 0.10], 0.0, None);
    go(&mut episode, "mat", [-0.08, 0.10, 0.062], 0.0, Some(Gripper::Open(0.06)));
    expect(&episode, "at(pitcher, mat, 0.08)", false);
    expect(&episode, "at(pitcher, mat, 0.12)", true);
    // Tilted a little, then too far, then so far that all beads fall on the table.
    episode.perform(&episode.world().tcp(), CLOSE, 0.0, &mut |_| {});
    go(&mut episode, "mat", [-0.2, 0.1, 0.35], 0.2, None);
    expect(&episode, "upright(pitcher)", true);
    go(&mut episode, "mat", [-0.2, 0.1, 0.35], 0.5, None);
    expect(&episode, "upright(pitcher)", false);
    expect(&episode, "upright(pitcher, 0.6)", true);
    expect(&episode, "filled(pitcher, 1)", true);
    go(&mut episode, "mat", [-0.2, 0.1, 0.35], 2.2, None);
    episode.perform(&episode.world().tcp(), None, 1.0, &mut |_| {});
    expect(&episode, "any(filled(pitcher, 0.1), filled(bowl, 0.1))", false);
}

#[test]
fn the_goal_wants_the_pitcher_back() {
    let mut episode = start("pour", None);
    let skills = episode.setting().skills.clone();
    for (i, skill) in skills.iter().enumerate() {
        assert!(!episode.succeeded(), "before {}", skill.name);
        let frame = episode.reference_pose(&skill.reference).expect("there");
        for keyframe in &skill.keyframes {
            episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut |_| {});
        }
        expect(&episode, "filled(bowl, 0.8)", i >= 1);
    }
    assert!(episode.succeeded());
    // And it is lost again when somebody takes the pitcher away.
    go(&mut episode, "pitcher", [-0.08, 0.0, 0.06], 0.0, CLOSE);
    go(&mut episode, "pitcher", [-0.08, 0.0, 0.20], 0.0, None);
    assert!(!episode.succeeded());
}
