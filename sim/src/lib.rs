//! Rapier behind nouns of the table: world, gripper, planner, beads, snapshot, camera.
//!
//! A [`World`] is a table with [`Object`]s, [`Beads`] and a hand of two fingers that holds by friction alone. It is advanced in steps of
//! 1/240 s, by itself or by the motions of the hand ([`World::move_hand`]); [`World::snapshot`] puts it aside; a [`Camera`] takes its picture.
//! Nothing here knows of tasks, goals or learning.
//!
//! All public poses are [`Pose`]: metres, world frame, z up, the table's top at z = 0.
//!
//! ```
//! use situ_sim::{Gripper, MotionEnd, Object, Pose, World};
//!
//! let mut world = World::new();
//! world.add(Object::block("cube", [0.02; 3], 1000.0, 0.6), Pose::translation(0.1, 0.0, 0.02))?;
//! world.place_gripper(Pose::translation(0.1, 0.0, 0.15), 0.065);
//! assert_eq!(world.move_hand(Pose::translation(0.1, 0.0, 0.028), &mut |_| {}), MotionEnd::Reached);
//! world.command(Gripper::Close(20.0));
//! world.hold(0.5, &mut |_| {});
//! world.move_hand(Pose::translation(0.1, 0.0, 0.12), &mut |_| {});
//! assert!(world.grip_force("cube").iter().all(|&force| force > 5.0));
//! assert!(!world.touching("cube", "table"));
//! # Ok::<(), situ_sim::SimError>(())
//! ```

mod arm;
mod beads;
mod camera;
mod error;
mod film;
mod frame;
mod furniture;
mod hand;
mod image;
mod magnet;
mod object;
mod overlap;
mod perception;
mod planner;
mod push;
mod ray;
mod route;
mod slide;
mod snapshot;
mod vessel;
mod world;

pub use arm::{ArmModel, Configuration, JOINTS, Joint};
pub use beads::Beads;
pub use camera::Camera;
pub use error::SimError;
pub use film::Film;
pub use frame::{Pose, pose_at, rotation_about};
pub use furniture::{Cabinet, Drawer};
pub use hand::{Gripper, MAX_OPENING, MAX_SQUEEZE};
pub use image::Image;
pub use magnet::Magnet;
pub use object::{Interior, Motion, Object, Part, Shape};
pub use overlap::Overlap;
pub use planner::{ABORT_FORCE, GUARD_FORCE, Guard, MAX_SPEED, MAX_TURN, MotionEnd};
pub use slide::Slide;
pub use snapshot::Snapshot;
pub use vessel::{Bin, Cover, Cup, Handle, Lid};
pub use world::{ARM, DT, HAND, TABLE, World};
