//! `held` and `upright`: what the hand does with one object.
//!
//! `held` is made by closing the fingers on a thing. Near misses are all the ways in which fingers can be about a
//! thing, or press on it, without a grasp. The oracle moves the hand by 3 cm in a copy. A held thing comes along:
//! upwards if it lies free, along its rails if it slides. A thing that only rides on a held thing comes along, too,
//! until the hand turns over.
//!
//! `upright` is made by turning the hand with the thing in it by a known angle, to either side of the limit, or by
//! letting the thing fall over. The oracle is the slope of the z axis, from its height and its length in the plane.

use situ_sim::{GripperCommand, pose_at, rotation_about};

use crate::predicates::confusion::Labels;
use crate::predicates::scene::{ABOVE, FIRM, GRASP, HALF_OPEN, SEEDS, Scene, WIDE, length, minus};

/// The axis along which the fingers close, in the frame of the hand.
const CLOSING: [f64; 3] = [0.0, 1.0, 0.0];
/// The axis across it.
const ACROSS: [f64; 3] = [1.0, 0.0, 0.0];

pub(crate) fn held() -> Labels {
    let mut labels = Labels::new("held");
    for seed in SEEDS {
        for block in ["red_1", "blue_1"] {
            cube(&mut labels, seed, block);
        }
        tower(&mut labels, seed);
        fin(&mut labels, seed);
        button(&mut labels, seed);
    }
    pitcher(&mut labels);
    labels
}

/// A cube that lies free.
fn cube(labels: &mut Labels, seed: u64, block: &str) {
    let mut scene = Scene::start("sort_blocks", None, seed);
    let held = format!("held({block})");
    let rises = |scene: &Scene| scene.rises_with_the_hand(block);
    scene.go(block, [0.0, 0.0, ABOVE], Some(WIDE));
    scene.go(block, [0.0, 0.0, 0.04], Some(FIRM));
    labels.near_miss(&scene, &held, "closed on air 8 mm above it", rises(&scene));
    scene.shift([0.0, 0.0, -0.0085]);
    labels.near_miss(&scene, &held, "pressed on from above with closed fingers", rises(&scene));
    scene.shift([0.0, 0.0, 0.05]);
    scene.grip(GripperCommand::Open(0.02));
    scene.shift([0.0, 0.0, -0.05]);
    labels.near_miss(&scene, &held, "pressed on from above with parted fingers", rises(&scene));
    scene.shift([0.0, 0.0, 0.05]);
    scene.grip(WIDE);
    scene.go(block, [0.0, 0.0, GRASP], None);
    labels.near_miss(&scene, &held, "fingers round it, open", rises(&scene));
    scene.grip(GripperCommand::Open(0.042));
    labels.near_miss(&scene, &held, "fingers round it, 1 mm away on either side", rises(&scene));
    scene.grip(GripperCommand::Close(0.3));
    labels.near_miss(&scene, &held, "squeezed with less than would lift it", rises(&scene));
    scene.grip(GripperCommand::Close(3.0));
    labels.truly(&scene, &held, "squeezed with little, on the table", rises(&scene));
    scene.grip(FIRM);
    labels.truly(&scene, &held, "squeezed, on the table", rises(&scene));
    labels.near_miss(&scene, "held(red_2)", "another one is held", scene.rises_with_the_hand("red_2"));
    scene.grip(WIDE);
    labels.dropped_later(&scene, &held, "let go on the table", rises(&scene));
    scene.grip(FIRM);
    scene.shift([0.0, 0.0, 0.12]);
    labels.truly(&scene, &held, "lifted", rises(&scene));
    scene.turn(ACROSS, 1.5);
    labels.truly(&scene, &held, "lifted and turned", rises(&scene));
    let taken = scene.bumped(block, [0.0, 0.0, -0.09], 0.5);
    labels.dropped_later(&taken, &held, "somebody pulled it out of the hand", rises(&taken));
    scene.turn(ACROSS, -1.5);
    scene.grip(WIDE);
    labels.dropped_later(&scene, &held, "let go in the air", rises(&scene));
    // One finger drags it over the table.
    scene.go(block, [0.0, 0.0, GRASP], None);
    scene.go(block, [0.0, 0.035, GRASP], None);
    labels.near_miss(&scene, &held, "one finger has pushed it aside", rises(&scene));
}

/// A small block on a larger one: the hand takes the one or the other.
fn tower(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("stack", Some("occupied"), seed);
    // A thing that rides on what the hand holds comes along, but not when the hand turns.
    let stays_when_turned = |scene: &Scene, object: &str| {
        let turned = scene.after(|world| {
            let high = pose_at([0.0, 0.0, 0.15], Default::default()) * world.tcp();
            world.move_hand(high, &mut |_| {});
            world.move_hand(high * rotation_about(CLOSING, 1.5), &mut |_| {});
            world.settle(0.3);
        });
        let from_hand =
            |scene: &Scene| length(minus(scene.center(object), scene.world().tcp().translation.vector.into()));
        from_hand(&turned) < from_hand(scene) + 0.03
    };
    scene.go("extra", [0.0, 0.0, 0.12], Some(WIDE));
    scene.go("base", [0.0, 0.0, 0.019], Some(FIRM));
    labels.truly(&scene, "held(base)", "taken below what is on it", stays_when_turned(&scene, "base"));
    labels.near_miss(&scene, "held(extra)", "on the one that is held", stays_when_turned(&scene, "extra"));
    scene.grip(WIDE);
    labels.dropped_later(&scene, "held(base)", "let go", scene.rises_with_the_hand("base"));
    scene.go("extra", [0.0, 0.0, 0.12], Some(HALF_OPEN));
    scene.go("extra", [0.0, 0.0, 0.004], Some(GripperCommand::Close(20.0)));
    labels.truly(&scene, "held(extra)", "taken off the base", scene.rises_with_the_hand("extra"));
    labels.near_miss(&scene, "held(base)", "the one on it is held", scene.rises_with_the_hand("base"));
    // The pads are 1 mm from the small block on either side, so that the tips come down on the larger one.
    scene.grip(GripperCommand::Open(0.032));
    scene.go("extra", [0.0, 0.0, 0.0], None);
    scene.go("extra", [0.0, 0.0, -0.0035], Some(GripperCommand::Close(20.0)));
    labels.near_miss(
        &scene,
        "held(base)",
        "the tips stand on it, about another one",
        scene.rises_with_the_hand("base"),
    );
}

/// A drawer, by its fin: what is held comes along its rails.
fn fin(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("drawer", None, seed);
    let frame = scene.frame("drawer");
    let outwards: [f64; 3] = (frame.rotation * nalgebra::Vector3::new(-0.03, 0.0, 0.0)).into();
    let follows = |scene: &Scene| scene.follows("drawer", outwards);
    scene.go_in(&frame, [-0.14, 0.0, 0.17], Some(HALF_OPEN));
    scene.go_in(&frame, [-0.14, 0.0, 0.09], Some(GripperCommand::Close(20.0)));
    labels.near_miss(&scene, "held(drawer)", "closed on air above the fin", follows(&scene));
    scene.grip(HALF_OPEN);
    scene.go_in(&frame, [-0.14, 0.0, 0.06], Some(GripperCommand::Open(0.016)));
    labels.near_miss(&scene, "held(drawer)", "fingers round the fin, 2 mm away on either side", follows(&scene));
    scene.grip(GripperCommand::Close(20.0));
    labels.truly(&scene, "held(drawer)", "taken by its fin", follows(&scene));
    scene.go_in(&frame, [-0.20, 0.0, 0.06], None);
    labels.truly(&scene, "held(drawer)", "pulled by its fin", follows(&scene));
    scene.grip(HALF_OPEN);
    labels.dropped_later(&scene, "held(drawer)", "the fin was let go", follows(&scene));
    // Beside the middle of the fin only one finger presses on it, and the fin cannot give way sideways. The finger
    // drags the drawer along by friction, so the oracle here is the gap: the fin is 12 mm thick, and a grasp closes on
    // it.
    scene.shift((frame.rotation * nalgebra::Vector3::new(0.0, 0.004, 0.0)).into());
    scene.grip(GripperCommand::Close(20.0));
    let is_closed_on_it = scene.world().opening() < 0.013;
    labels.near_miss(&scene, "held(drawer)", "one finger presses on the fin", is_closed_on_it);
}

/// A button, pushed by both fingers from the same side.
fn button(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("press", None, seed);
    let frame = scene.frame("green");
    let back: [f64; 3] = (frame.rotation * nalgebra::Vector3::new(-0.01, 0.0, 0.0)).into();
    scene.go_in(&frame, [-0.20, 0.0, 0.09], Some(GripperCommand::Close(10.0)));
    scene.go_in(&frame, [-0.135, 0.0, 0.09], None);
    labels.near_miss(&scene, "held(green_cap)", "pushed with closed fingers", scene.follows("green_cap", back));
}

/// A full pitcher, by its handle.
fn pitcher(labels: &mut Labels) {
    let mut scene = Scene::start("pour", Some("lid"), SEEDS[0]);
    let rises = |scene: &Scene, object: &str| scene.rises_with_the_hand(object);
    scene.go("lid", [0.0, 0.0, 0.12], Some(HALF_OPEN));
    scene.go("lid", [0.0, 0.0, 0.020], Some(GripperCommand::Close(20.0)));
    labels.truly(&scene, "held(lid)", "taken by its knob against its magnet", rises(&scene, "lid"));
    labels.near_miss(&scene, "held(pitcher)", "its lid is held", rises(&scene, "pitcher"));
    scene.grip(HALF_OPEN);
    labels.dropped_later(&scene, "held(lid)", "the knob was let go", rises(&scene, "lid"));
    scene.go("lid", [0.0, 0.0, 0.12], None);
    scene.go("pitcher", [-0.08, 0.0, 0.17], None);
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(GripperCommand::Open(0.02)));
    labels.near_miss(&scene, "held(pitcher)", "fingers round the handle, open", rises(&scene, "pitcher"));
    scene.grip(FIRM);
    labels.truly(&scene, "held(pitcher)", "taken by its handle", rises(&scene, "pitcher"));
}

pub(crate) fn upright() -> Labels {
    let mut labels = Labels::new("upright");
    for seed in SEEDS {
        for block in ["red_1", "blue_1"] {
            let mut scene = Scene::start("sort_blocks", None, seed);
            scene.pick(block);
            scene.shift([0.0, 0.0, 0.05]);
            tilted(&mut labels, &mut scene, block);
            fallen(&mut labels, &mut scene, block);
        }
        let mut scene = Scene::start("press", Some("shutter"), seed);
        scene.go("shutter", [0.0, 0.0, 0.22], Some(HALF_OPEN));
        scene.go("shutter", [0.0, 0.0, 0.146], Some(FIRM));
        scene.go("shutter", [0.0, 0.0, 0.32], None);
        tilted(&mut labels, &mut scene, "shutter");
        toppled(&mut labels, seed);
    }
    let mut scene = Scene::start("pour", None, SEEDS[0]);
    scene.go("pitcher", [-0.08, 0.0, 0.17], Some(HALF_OPEN));
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(FIRM));
    scene.go("pitcher", [-0.08, 0.0, 0.22], None);
    tilted(&mut labels, &mut scene, "pitcher");
    labels
}

/// The angle between the z axis of an object and the vertical, by what the axis goes in the plane and what it rises.
fn slope(scene: &Scene, object: &str) -> f64 {
    let matrix = scene.world().pose(object).expect("it is there").to_homogeneous();
    libm::atan2(libm::hypot(matrix[(0, 2)], matrix[(1, 2)]), matrix[(2, 2)])
}

/// What is held is turned with the hand, to either side of the limit.
fn tilted(labels: &mut Labels, scene: &mut Scene, object: &str) {
    /// The limit of a condition that gives none.
    const LIMIT: f64 = 0.3;
    let upright = format!("upright({object})");
    let is_within = |scene: &Scene, limit: f64| slope(scene, object) <= limit;
    labels.truly(scene, &upright, "lifted", is_within(scene, LIMIT));
    scene.turn([0.0, 0.0, 1.0], 0.8);
    labels.truly(scene, &upright, "turned about the vertical", is_within(scene, LIMIT));
    scene.turn(CLOSING, 0.285);
    labels.truly(scene, &upright, "tilted by just less than the limit", is_within(scene, LIMIT));
    scene.turn(CLOSING, 0.03);
    labels.near_miss(scene, &upright, "tilted by just more than the limit", is_within(scene, LIMIT));
    scene.turn(CLOSING, -0.03 - 0.285 - 0.285);
    labels.truly(scene, &upright, "tilted back by just less than the limit", is_within(scene, LIMIT));
    scene.turn(CLOSING, -0.03);
    labels.near_miss(scene, &upright, "tilted back by just more than the limit", is_within(scene, LIMIT));
    scene.turn(CLOSING, 0.315);
    scene.turn(ACROSS, 0.285);
    labels.truly(scene, &upright, "tilted aside by just less than the limit", is_within(scene, LIMIT));
    scene.turn(ACROSS, 0.03);
    labels.near_miss(scene, &upright, "tilted aside by just more than the limit", is_within(scene, LIMIT));
    let (wide, narrow) = (format!("upright({object}, 0.33)"), format!("upright({object}, 0.30)"));
    labels.truly(scene, &wide, "tilted aside, within the wider limit", is_within(scene, 0.33));
    labels.near_miss(scene, &narrow, "tilted aside, beyond the narrower limit", is_within(scene, 0.30));
    scene.turn(ACROSS, 0.9);
    labels.dropped_later(scene, &upright, "tilted far", is_within(scene, LIMIT));
}

/// What is held aslant is let go, and comes to lie on another face.
fn fallen(labels: &mut Labels, scene: &mut Scene, object: &str) {
    scene.turn(ACROSS, -1.215);
    scene.turn(CLOSING, 1.5);
    scene.shift([0.0, 0.0, 0.03 - scene.center(object)[2]]);
    scene.grip(WIDE);
    scene.wait(0.5);
    labels.dropped_later(scene, &format!("upright({object})"), "fell on another face", slope(scene, object) <= 0.3);
}

/// A pin that stands free is pushed over.
fn toppled(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("drawer", Some("pin"), seed);
    scene.go("pin", [0.0, 0.0, 0.14], Some(HALF_OPEN));
    scene.go("pin", [0.0, 0.0, 0.045], Some(GripperCommand::Close(20.0)));
    scene.go("pin", [0.0, 0.0, 0.20], None);
    scene.go("side", [0.0, 0.0, 0.22], None);
    scene.go("side", [0.0, 0.0, 0.106], Some(HALF_OPEN));
    labels.truly(&scene, "upright(pin)", "put down on its foot", slope(&scene, "pin") <= 0.3);
    scene.shift([0.0, 0.06, 0.0]);
    scene.wait(0.5);
    labels.dropped_later(&scene, "upright(pin)", "pushed over", slope(&scene, "pin") <= 0.3);
}
