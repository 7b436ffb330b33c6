//! `open` and `pressed`: how far a thing that slides has gone.
//!
//! Both are made by a hand that pulls or pushes by a known way, a few millimetres to either side of the limit. The
//! oracle is the place of the thing in the frame of what it slides in, less its place at the start of its range. Both
//! are written out here, from the files of the tasks.

use std::sync::Arc;

use situ_sim::GripperCommand;
use situ_tasks::Setting;

use crate::predicates::confusion::Labels;
use crate::predicates::scene::{HALF_OPEN, SEEDS, Scene, setting};

/// Where a closed drawer and a cap that nobody has pushed are along the x axis of what they slide in, metres.
const DRAWER_AT: f64 = -0.015;
const CAP_AT: f64 = -0.125;
/// How far a cap goes in, and a drawer comes out, metres.
const CAP_TRAVEL: f64 = 0.03;
const DRAWER_TRAVEL: f64 = 0.195;
/// The squeeze at the fin of a drawer.
const PULL: GripperCommand = GripperCommand::Close(20.0);
/// Where the closed fingers touch a cap that nobody has pushed: the place of the TCP along x, and its height, in the
/// frame of the housing, metres.
const TOUCH: f64 = -0.165;
const CAP_HEIGHT: f64 = 0.09;

/// How far a drawer has come out: it slides towards −x.
fn opening(scene: &Scene) -> f64 {
    DRAWER_AT - scene.place_in("drawer", "cabinet")[0]
}

/// How far a cap has gone in: it slides towards +x.
fn depth(scene: &Scene, housing: &str) -> f64 {
    scene.place_in(&format!("{housing}_cap"), housing)[0] - CAP_AT
}

pub(crate) fn open() -> Labels {
    let mut labels = Labels::new("open");
    for seed in SEEDS {
        pulled(&mut labels, seed, None, 0.0);
        pulled(&mut labels, seed, Some("ajar"), 0.03);
        hindered(&mut labels, seed);
    }
    labels
}

/// The hand takes the fin and pulls and pushes.
fn pulled(labels: &mut Labels, seed: u64, variation: Option<&str>, began: f64) {
    /// The limits of the conditions, metres: the skill's and the goal's.
    const WIDE: f64 = 0.10;
    const SHUT: f64 = 0.02;
    let mut scene = Scene::start("drawer", variation, seed);
    let frame = scene.frame("drawer");
    let (wide, shut) = (format!("open(drawer, {WIDE})"), format!("open(drawer, {SHUT})"));
    scene.go_in(&frame, [-0.14, 0.0, 0.17], Some(HALF_OPEN));
    scene.go_in(&frame, [-0.14, 0.0, 0.06], Some(PULL));
    let pull = |scene: &mut Scene, way: f64| scene.go_in(&frame, [-0.14 - (way - began), 0.0, 0.06], None);
    pull(&mut scene, 0.097);
    labels.near_miss(&scene, &wide, "pulled 3 mm less than that", opening(&scene) >= WIDE);
    labels.truly(&scene, &shut, "pulled more than that", opening(&scene) >= SHUT);
    pull(&mut scene, 0.104);
    labels.truly(&scene, &wide, "pulled 4 mm more than that", opening(&scene) >= WIDE);
    let let_go = scene.after(|world| {
        world.command(HALF_OPEN);
        world.settle(1.0);
    });
    labels.truly(&let_go, &wide, "let go there", opening(&let_go) >= WIDE);
    pull(&mut scene, 0.16);
    labels.truly(&scene, &wide, "pulled far out", opening(&scene) >= WIDE);
    let pushed = scene.bumped("drawer", (frame.rotation * nalgebra::Vector3::new(0.065, 0.0, 0.0)).into(), 0.5);
    labels.dropped_later(&pushed, &wide, "somebody pushed it in by 65 mm", opening(&pushed) >= WIDE);
    pull(&mut scene, 0.096);
    labels.dropped_later(&scene, &wide, "pushed 4 mm further in than that", opening(&scene) >= WIDE);
    pull(&mut scene, 0.024);
    labels.truly(&scene, &shut, "pushed in to 4 mm more than that", opening(&scene) >= SHUT);
    pull(&mut scene, 0.017);
    labels.dropped_later(&scene, &shut, "pushed in to 3 mm less than that", opening(&scene) >= SHUT);
}

/// The teacher's pull with something in its way: grease in the rails, a pin before the panel, a fin that is not where
/// it was.
fn hindered(labels: &mut Labels, seed: u64) {
    const LIMIT: f64 = 0.10;
    for (variation, why) in [
        ("stiff", "the rails are stiff, the fin slipped out of the hand"),
        ("pin", "a pin stands in its way"),
        ("low_handle", "the hand pulled air above the fin"),
    ] {
        let mut scene = Scene::start("drawer", Some(variation), seed);
        let pull = scene.episode().setting().original_skills.iter().find(|skill| skill.name == "open").cloned();
        scene.perform(&pull.expect("a teacher opens it"));
        labels.near_miss(&scene, "open(drawer, 0.1)", why, opening(&scene) >= LIMIT);
    }
}

pub(crate) fn pressed() -> Labels {
    let mut labels = Labels::new("pressed");
    for seed in SEEDS {
        pushed(&mut labels, seed, None, 0.0);
        pushed(&mut labels, seed, Some("tall"), 0.10);
        springy(&mut labels, seed);
        pulled_by_half(&mut labels, seed);
    }
    labels
}

/// Caps that stay where they are left.
fn pushed(labels: &mut Labels, seed: u64, variation: Option<&str>, higher: f64) {
    let mut scene = Scene::start("press", variation, seed);
    for (housing, height) in [("green", CAP_HEIGHT), ("red", CAP_HEIGHT + higher)] {
        let is_in = |scene: &Scene| depth(scene, housing) >= 0.5 * CAP_TRAVEL;
        let pressed = format!("pressed({housing}_cap)");
        let frame = scene.frame(housing);
        let back = -0.22;
        scene.go_in(&frame, [back, 0.0, height], Some(GripperCommand::Close(10.0)));
        for (way, how) in
            [(0.0005, "touched"), (0.006, "pushed a little"), (0.0135, "pushed 1.5 mm less than half-way")]
        {
            scene.go_in(&frame, [TOUCH + way, 0.0, height], None);
            labels.near_miss(&scene, &pressed, how, is_in(&scene));
        }
        scene.go_in(&frame, [back, 0.0, height], None);
        labels.near_miss(&scene, &pressed, "pushed less than half-way, and left", is_in(&scene));
        scene.go_in(&frame, [TOUCH + 0.0165, 0.0, height], None);
        labels.truly(&scene, &pressed, "pushed 1.5 mm more than half-way", is_in(&scene));
        scene.go_in(&frame, [TOUCH + 0.026, 0.0, height], None);
        labels.truly(&scene, &pressed, "pushed nearly all the way", is_in(&scene));
        scene.go_in(&frame, [back, 0.0, height], None);
        labels.truly(&scene, &pressed, "pushed, and left", is_in(&scene));
        // The cap is taken by its sides and pulled out again.
        scene.grip(HALF_OPEN);
        scene.go_in(&frame, [TOUCH + 0.033, 0.0, height], Some(GripperCommand::Close(20.0)));
        scene.go_in(&frame, [TOUCH + 0.009, 0.0, height], Some(HALF_OPEN));
        labels.dropped_later(&scene, &pressed, "pulled out again", is_in(&scene));
        scene.go_in(&frame, [back, 0.0, height], None);
    }
}

/// Caps on a spring, which follow the hand back out.
fn springy(labels: &mut Labels, seed: u64) {
    let mut changed = Setting::clone(&setting("press", None));
    for slide in &mut changed.slides {
        slide.spring = 300.0;
        slide.friction = 0.5;
    }
    let mut scene = Scene::start_with(&Arc::new(changed), seed);
    for housing in ["green", "red"] {
        let is_in = |scene: &Scene| depth(scene, housing) >= 0.5 * CAP_TRAVEL;
        let pressed = format!("pressed({housing}_cap)");
        let frame = scene.frame(housing);
        scene.go_in(&frame, [-0.22, 0.0, CAP_HEIGHT], Some(GripperCommand::Close(10.0)));
        scene.go_in(&frame, [TOUCH + 0.0165, 0.0, CAP_HEIGHT], None);
        labels.truly(&scene, &pressed, "on a spring, pushed 1.5 mm more than half-way", is_in(&scene));
        scene.go_in(&frame, [TOUCH + 0.0135, 0.0, CAP_HEIGHT], None);
        labels.dropped_later(&scene, &pressed, "came back with the hand by 3 mm", is_in(&scene));
        scene.go_in(&frame, [TOUCH + 0.026, 0.0, CAP_HEIGHT], None);
        labels.truly(&scene, &pressed, "on a spring, pushed again", is_in(&scene));
        scene.go_in(&frame, [-0.22, 0.0, CAP_HEIGHT], None);
        labels.dropped_later(&scene, &pressed, "left, and came back out", is_in(&scene));
    }
}

/// A drawer is half-way along its range.
fn pulled_by_half(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("drawer", None, seed);
    let is_half = |scene: &Scene| opening(scene) >= 0.5 * DRAWER_TRAVEL;
    let frame = scene.frame("drawer");
    scene.go_in(&frame, [-0.14, 0.0, 0.17], Some(HALF_OPEN));
    scene.go_in(&frame, [-0.14, 0.0, 0.06], Some(PULL));
    scene.go_in(&frame, [-0.14 - 0.094, 0.0, 0.06], None);
    labels.near_miss(&scene, "pressed(drawer)", "pulled 3.5 mm less than half-way", is_half(&scene));
    scene.go_in(&frame, [-0.14 - 0.102, 0.0, 0.06], None);
    labels.truly(&scene, "pressed(drawer)", "pulled 4.5 mm more than half-way", is_half(&scene));
}
