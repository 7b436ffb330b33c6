//! A scene: an episode in which the test moves the hand, and the measurements that the oracles share.
//!
//! The measurements take positions and axes of bodies from the world, as numbers, and copies of the world in which
//! something is tried: the hand is moved, somebody bumps into a thing, time passes. They use no condition, outline,
//! room of a container, grip force or slide.

use std::sync::Arc;

use situ_sim::{DT, GripperCommand, Pose, World, pose_at, rotation_about};
use situ_tasks::{Episode, Predicate, Registry, Setting, Skill};

/// Start seeds of the scenes.
pub(crate) const SEEDS: [u64; 3] = [0, 1, 2];
/// As wide as the hand opens.
pub(crate) const WIDE: GripperCommand = GripperCommand::Open(0.08);
/// Wide enough for a bar or a knob.
pub(crate) const HALF_OPEN: GripperCommand = GripperCommand::Open(0.06);
/// A firm grasp.
pub(crate) const FIRM: GripperCommand = GripperCommand::Close(30.0);
/// Where the teacher's open hand goes before it takes a block, metres over its origin.
pub(crate) const ABOVE: f64 = 0.13;
/// How far the tips of the fingers are below the TCP, metres.
pub(crate) const TIPS: f64 = 0.012;
/// Where the teacher's hand takes a block, metres over its origin.
pub(crate) const GRASP: f64 = 0.012;

/// An episode, or what becomes of it when somebody else acts.
#[derive(Clone)]
pub(crate) struct Scene {
    episode: Episode,
    seed: u64,
    /// The world after the deed of somebody else. The hand does not move in it any more.
    after: Option<World>,
}

impl Scene {
    pub(crate) fn start(task: &str, variation: Option<&str>, seed: u64) -> Scene {
        Scene::start_with(&setting(task, variation), seed)
    }

    pub(crate) fn start_with(setting: &Arc<Setting>, seed: u64) -> Scene {
        let episode = Episode::start(setting, seed).unwrap_or_else(|error| panic!("{error}"));
        Scene { episode, seed, after: None }
    }

    /// Where it comes from, for messages.
    pub(crate) fn label(&self) -> String {
        format!("{}, seed {}", self.episode.setting().label(), self.seed)
    }

    pub(crate) fn episode(&self) -> &Episode {
        &self.episode
    }

    pub(crate) fn world(&self) -> &World {
        self.after.as_ref().unwrap_or_else(|| self.episode.world())
    }

    pub(crate) fn holds(&self, predicate: &Predicate) -> bool {
        predicate.holds(self.world())
    }

    /// The level frame of an object as it is now.
    pub(crate) fn frame(&self, object: &str) -> Pose {
        self.episode.reference_pose(object).unwrap_or_else(|| panic!("no {object} in {}", self.label()))
    }

    /// Moves the hand to a pose of the world.
    pub(crate) fn move_to(&mut self, target: &Pose, gripper: Option<GripperCommand>) {
        assert!(self.after.is_none(), "the hand does not move after somebody else has acted");
        self.episode.perform(target, gripper, 0.0, &mut |_| {});
    }

    /// Moves the hand, pointing down, to a place in a frame.
    pub(crate) fn go_in(&mut self, frame: &Pose, at: [f64; 3], gripper: Option<GripperCommand>) {
        self.move_to(&(frame * pose_at(at, Default::default())), gripper);
    }

    /// Moves the hand, pointing down, to a place in the level frame of an object as it is now.
    pub(crate) fn go(&mut self, object: &str, at: [f64; 3], gripper: Option<GripperCommand>) {
        let frame = self.frame(object);
        self.go_in(&frame, at, gripper);
    }

    /// Moves the hand from where it is, metres in the world.
    pub(crate) fn shift(&mut self, by: [f64; 3]) {
        let target = pose_at(by, Default::default()) * self.world().tcp();
        self.move_to(&target, None);
    }

    /// Turns the hand where it is, about an axis of its own.
    pub(crate) fn turn(&mut self, axis: [f64; 3], angle: f64) {
        let target = self.world().tcp() * rotation_about(axis, angle);
        self.move_to(&target, None);
    }

    /// Commands the gripper where it is.
    pub(crate) fn grip(&mut self, gripper: GripperCommand) {
        let here = self.world().tcp();
        self.move_to(&here, Some(gripper));
    }

    pub(crate) fn wait(&mut self, seconds: f64) {
        let here = self.world().tcp();
        self.episode.perform(&here, None, seconds, &mut |_| {});
    }

    /// A skill, as a teacher performs it.
    pub(crate) fn perform(&mut self, skill: &Skill) {
        let frame = self.frame(&skill.reference);
        for keyframe in &skill.keyframes {
            self.episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut |_| {});
        }
    }

    /// Takes a block as the teacher does, up to the closed fingers.
    pub(crate) fn take(&mut self, block: &str) {
        self.go(block, [0.0, 0.0, ABOVE], Some(WIDE));
        self.go(block, [0.0, 0.0, GRASP], Some(FIRM));
    }

    /// Takes a block and lifts it.
    pub(crate) fn pick(&mut self, block: &str) {
        self.take(block);
        self.go(block, [0.0, 0.0, 0.15], None);
    }

    /// What becomes of the scene when somebody does something to its world.
    pub(crate) fn after(&self, deed: impl FnOnce(&mut World)) -> Scene {
        let mut world = self.world().clone();
        deed(&mut world);
        Scene { after: Some(world), ..self.clone() }
    }

    /// What becomes of the scene when somebody pushes an object by so much, and half a second has passed.
    pub(crate) fn bumped(&self, object: &str, by: [f64; 3], seconds: f64) -> Scene {
        self.after(|world| {
            push(world, object, by, seconds);
            world.settle(seconds + 0.5);
        })
    }

    /// The scene at the moment at which somebody has lifted an object by so much.
    pub(crate) fn lifted(&self, object: &str, height: f64) -> Scene {
        /// Slow enough that nothing jumps, seconds.
        const SECONDS: f64 = 0.5;
        self.after(|world| {
            push(world, object, [0.0, 0.0, height], SECONDS);
            world.settle(SECONDS);
        })
    }

    /// Where the middle of an object is, metres in the world.
    pub(crate) fn center(&self, object: &str) -> [f64; 3] {
        center(self.world(), object)
    }

    /// Where the origin of `a` is in the frame of `b`: the difference of their places along each of the axes of `b`.
    pub(crate) fn place_in(&self, a: &str, b: &str) -> [f64; 3] {
        self.point_in(self.center(a), b)
    }

    /// Where a point of the world is in the frame of `b`.
    pub(crate) fn point_in(&self, point: [f64; 3], b: &str) -> [f64; 3] {
        let matrix = self.world().pose(b).unwrap_or_else(|| panic!("no {b}")).to_homogeneous();
        [0, 1, 2].map(|axis| (0..3).map(|row| matrix[(row, axis)] * (point[row] - matrix[(row, 3)])).sum())
    }

    /// Whether an object comes along when the hand goes on by so much, metres in the world, in a copy of the scene.
    pub(crate) fn follows(&self, object: &str, by: [f64; 3]) -> bool {
        let mut copy = self.world().clone();
        let before = center(&copy, object);
        let target = pose_at(by, Default::default()) * copy.tcp();
        copy.move_hand(target, &mut |_| {});
        let way = minus(center(&copy, object), before);
        /// The part of the hand's way that is asked for: a thing that is taken may slip a little.
        const MOST: f64 = 0.8;
        dot(way, by) >= MOST * dot(by, by)
    }

    /// Whether an object rises with the hand by 3 cm in a copy of the scene.
    pub(crate) fn rises_with_the_hand(&self, object: &str) -> bool {
        self.follows(object, [0.0, 0.0, 0.03])
    }

    /// Speed of an object in m/s: its way in the next steps of a copy in which nobody does anything.
    pub(crate) fn speed(&self, object: &str) -> f64 {
        /// 1/80 s.
        const STEPS: u32 = 3;
        let mut copy = self.world().clone();
        let before = center(&copy, object);
        for _ in 0..STEPS {
            copy.step();
        }
        length(minus(center(&copy, object), before)) / (f64::from(STEPS) * DT)
    }
}

pub(crate) fn setting(task: &str, variation: Option<&str>) -> Arc<Setting> {
    let registry = Registry::builtin().expect("the library is sound");
    registry.get(task).and_then(|task| task.variation(variation)).unwrap_or_else(|error| panic!("{error}"))
}

/// Begins a push.
pub(crate) fn push(world: &mut World, object: &str, by: [f64; 3], seconds: f64) {
    world.push(object, by, seconds).unwrap_or_else(|error| panic!("{error}"));
}

pub(crate) fn center(world: &World, object: &str) -> [f64; 3] {
    let matrix = world.pose(object).unwrap_or_else(|| panic!("no {object}")).to_homogeneous();
    [0, 1, 2].map(|row| matrix[(row, 3)])
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub(crate) fn length(a: [f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}
