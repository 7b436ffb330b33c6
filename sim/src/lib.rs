//! Rapier behind nouns of the table: world, gripper, planner, beads, snapshot, camera.
//!
//! A [`World`] is a table with [`Object`]s, [`Beads`] and a hand of two fingers that holds by friction alone. It is advanced in steps of
//! 1/240 s, by itself or by the motions of the hand ([`World::move_hand`]); [`World::snapshot`] puts it aside; a [`Camera`] takes its picture.
//! Nothing here knows of tasks, goals or learning.
//!
//! All public poses are [`Pose`]: metres, world frame, z up, the table's top at z = 0.
//!
//! ```
//! use situ_sim::{Block, Gripper, MotionEnd, Pose, World};
//!
//! let mut world = World::new();
//! let cube = Block { half: [0.02; 3], density: 1000.0, friction: 0.6 };
//! world.add(cube.object("cube"), Pose::translation(0.1, 0.0, 0.02))?;
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
mod check;
mod convex;
mod error;
mod film;
mod frame;
mod hand;
mod image;
mod interior;
mod magnet;
mod object;
mod overlap;
mod part;
mod perception;
mod planner;
mod push;
mod ray;
mod route;
mod shape;
mod slide;
mod snapshot;
mod world;

pub use arm::{ArmModel, Configuration, JOINTS, Joint};
pub use beads::Beads;
pub use camera::Camera;
pub use convex::Convex;
pub use error::SimError;
pub use film::Film;
pub use frame::{Pose, pose_at, rotation_about};
pub use hand::{Gripper, MAX_OPENING, MAX_SQUEEZE};
pub use image::Image;
pub use interior::Interior;
pub use magnet::Magnet;
pub use object::{Motion, Object, Outline};
pub use overlap::Overlap;
pub use part::Part;
pub use planner::{ABORT_FORCE, GUARD_FORCE, Guard, MAX_SPEED, MAX_TURN, MotionEnd};
pub use shape::*;
pub use slide::Slide;
pub use snapshot::Snapshot;
pub use world::{ARM, DT, HAND, TABLE, World};
