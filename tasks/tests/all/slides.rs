//! `open` and `pressed` against states with a known label, which a hand has produced: true, near miss on either side,
//! changed back later.
//!
//! A label is the way that the hand has pulled or pushed, measured from where it touched. No label asks the slide.

use std::sync::Arc;

use situ_sim::{GripperCommand, Pose};
use situ_tasks::{Episode, PRESSED_PART, Predicate, Registry, Setting};

fn start(task: &str, variation: Option<&str>, seed: u64) -> Episode {
    let registry = Registry::builtin().expect("the library is sound");
    let setting =
        registry.get(task).and_then(|task| task.variation(variation)).unwrap_or_else(|error| panic!("{error}"));
    Episode::start(&setting, seed).unwrap_or_else(|error| panic!("{error}"))
}

/// Moves to a place in a frame.
fn go(episode: &mut Episode, frame: &Pose, [x, y, z]: [f64; 3], gripper: Option<GripperCommand>) {
    episode.perform(&(frame * Pose::translation(x, y, z)), gripper, 0.0, &mut |_| {});
}

/// How often a condition and the labels agreed.
#[derive(Debug, Default)]
struct Confusion {
    true_positive: usize,
    false_positive: usize,
    false_negative: usize,
    true_negative: usize,
}

impl Confusion {
    fn count(&mut self, holds: bool, label: bool) {
        *match (holds, label) {
            (true, true) => &mut self.true_positive,
            (true, false) => &mut self.false_positive,
            (false, true) => &mut self.false_negative,
            (false, false) => &mut self.true_negative,
        } += 1;
    }

    /// Precision and recall are 1.0, over at least 40 states of which at least a third have either label.
    #[track_caller]
    fn assert_exact(&self) {
        assert_eq!((self.false_positive, self.false_negative), (0, 0), "{self:?}");
        let all = self.true_positive + self.true_negative;
        assert!(all >= 40 && 3 * self.true_positive >= all && 3 * self.true_negative >= all, "{self:?}");
    }
}

#[test]
fn open() {
    let mut confusion = Confusion::default();
    let is_open = Predicate::parse("open(drawer, 0.1)").expect("a condition");
    for (variation, began) in [(None, 0.0), (Some("ajar"), 0.03)] {
        for seed in 0..4 {
            let mut episode = start("drawer", variation, seed);
            confusion.count(episode.holds(&is_open), false);
            // The fin is taken once; then the hand pulls and pushes, and the drawer is as far open as the hand has
            // gone.
            let frame = episode.reference_pose("drawer").expect("there");
            go(&mut episode, &frame, [-0.14, 0.0, 0.17], Some(GripperCommand::Open(0.06)));
            go(&mut episode, &frame, [-0.14, 0.0, 0.06], Some(GripperCommand::Close(20.0)));
            for opening in [0.05, 0.096, 0.104, 0.16, 0.103, 0.097, 0.04, 0.105] {
                go(&mut episode, &frame, [-0.14 - (opening - began), 0.0, 0.06], None);
                confusion.count(episode.holds(&is_open), opening >= 0.1);
            }
            // Let go, it stays as it is.
            let hand = episode.world().tcp();
            episode.perform(&hand, Some(GripperCommand::Open(0.06)), 1.0, &mut |_| {});
            confusion.count(episode.holds(&is_open), true);
        }
    }
    confusion.assert_exact();
}

#[test]
fn pressed() {
    let mut confusion = Confusion::default();
    for (variation, higher) in [(None, 0.0), (Some("tall"), 0.10)] {
        // Half of the states are of caps that stay in, half of caps on a spring, which follow the hand back out.
        for (seed, spring) in [(0, 0.0), (1, 0.0), (0, 300.0), (1, 300.0)] {
            let mut setting = Setting::clone(start("press", variation, seed).setting());
            setting.slides.iter_mut().for_each(|slide| {
                slide.spring = spring;
                slide.friction = if spring > 0.0 { 0.5 } else { slide.friction };
            });
            let mut episode = Episode::start(&Arc::new(setting), seed).unwrap_or_else(|error| panic!("{error}"));
            for (housing, z) in [("green", 0.09), ("red", 0.09 + higher)] {
                let is_pressed = Predicate::parse(&format!("pressed({housing}_cap)")).expect("a condition");
                let travel = episode.world().slide_travel(&format!("{housing}_cap")).expect("it slides");
                let frame = episode.reference_pose(housing).expect("there");
                confusion.count(episode.holds(&is_pressed), false);
                // The fingers touch the cap with the TCP at x = -0.165.
                go(&mut episode, &frame, [-0.22, 0.0, z], Some(GripperCommand::Close(10.0)));
                let mut deepest: f64 = 0.0;
                for way in [0.0, 0.006, 0.0135, 0.0165, 0.0135, 0.0165, 0.027, 0.0165, 0.0135] {
                    go(&mut episode, &frame, [-0.165 + way, 0.0, z], None);
                    deepest = if spring > 0.0 { way } else { deepest.max(way) };
                    confusion.count(episode.holds(&is_pressed), deepest >= PRESSED_PART * travel);
                }
                go(&mut episode, &frame, [-0.22, 0.0, z], None);
                confusion.count(episode.holds(&is_pressed), spring == 0.0);
            }
        }
    }
    confusion.assert_exact();
}

#[test]
fn a_finger_that_rebounds_presses_no_longer() {
    // A cap that is taken near its end cannot give way sideways. It is hit by one finger and then by the other. The
    // engine can keep the impulses of a pair that has come apart: a finger 3 mm away was felt pressing with its last 78
    // N, and the force on the hand rose to 70 N.
    let mut episode = start("press", None, 0);
    let frame = episode.reference_pose("green").expect("there");
    for (x, gripper) in [
        (-0.22, Some(GripperCommand::Close(10.0))),
        (-0.145, None),
        (-0.22, None),
        (-0.22, Some(GripperCommand::Open(0.06))),
        (-0.138, None),
    ] {
        go(&mut episode, &frame, [x, 0.0, 0.09], gripper);
    }
    let mut rebounds = 0;
    let target = frame * Pose::translation(-0.138, 0.0, 0.09);
    for squeeze in [5.0, 10.0, 20.0] {
        let mut pressed = false;
        episode.perform(&target, Some(GripperCommand::Close(squeeze)), 0.0, &mut |world| {
            let apart = !world.touching("hand", "green_cap");
            rebounds += usize::from(pressed && apart);
            pressed = world.grip_force("green_cap").iter().any(|&force| force > 0.0);
            assert!(!(apart && pressed), "a finger in the air presses with {:?} N", world.grip_force("green_cap"));
            assert!(world.hand_force() < 20.0, "the hand feels {} N", world.hand_force());
        });
        episode.perform(&target, Some(GripperCommand::Open(0.06)), 0.0, &mut |_| {});
    }
    assert!(rebounds >= 3, "only {rebounds} rebounds: the test has nothing to say");
}
