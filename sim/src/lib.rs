//! Rapier behind nouns of the table: world, gripper, arm, beads, snapshot, camera.
//!
//! A [`World`] is a table with [`Object`]s, [`Beads`] and a hand of two fingers that holds by friction alone. It is
//! advanced in steps of 1/240 s, by itself or by the motions of the hand ([`World::move_hand`]). [`World::snapshot`]
//! puts it aside, and a [`Camera`] takes its picture. Nothing here knows of tasks, goals or learning.
//!
//! A [`Shape`] with its dimensions makes an [`Object`], and a task file is read straight into it.
//!
//! All public poses are [`Pose`]: metres, world frame, z up, the table's top at z = 0.
//!
//! ```
//! use situ_sim::{Block, GripperCommand, MotionEnd, Pose, World};
//!
//! let mut world = World::new();
//! let cube = Block { half: [0.02; 3], density: 1000.0, friction: 0.6 };
//! world.add(cube.object("cube"), Pose::translation(0.1, 0.0, 0.02))?;
//! world.place_gripper(Pose::translation(0.1, 0.0, 0.15), 0.065);
//! assert_eq!(world.move_hand(Pose::translation(0.1, 0.0, 0.028), &mut |_| {}), MotionEnd::Reached);
//! world.command(GripperCommand::Close(20.0));
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
mod font;
mod frame;
mod hand;
mod hinge;
mod image;
mod mechanism;
mod motion;
mod object;
mod perception;
mod push;
mod rolling;
mod scene;
mod shape;
mod sight;
mod step;
mod symmetry;
mod tag;
mod world;

pub use arm::{ArmModel, Configuration, JOINTS, Joint};
pub use beads::Beads;
pub use camera::{Camera, FRONT};
pub use error::SimError;
pub use film::Film;
pub use frame::{Pose, pose_at, rotation_about};
pub use hand::{ABORT_FORCE, GUARD_FORCE, GripperCommand, Guard, MAX_OPENING, MAX_SQUEEZE};
pub use hinge::Hinge;
pub use image::Image;
pub use mechanism::{Magnet, Slide};
pub use motion::MotionEnd;
pub use motion::pace::{CONTACT_SPEED, CONTACT_TURN, MAX_SPEED, MAX_TURN};
pub use object::{Convex, Interior, Mobility, Object, Outline, Part, Rolling};
pub use perception::Overlap;
pub use shape::*;
pub use sight::Sight;
pub use step::DT;
pub use symmetry::Symmetry;
pub use tag::{ARM, HAND, TABLE};
pub use world::{Snapshot, World};
