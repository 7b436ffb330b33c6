//! A task is a file: objects, the goal, what a competent teacher does, and variations that each need one edit of a task model.
//!
//! [`Registry`] knows the tasks by name. A [`Task`] with one variation applied is a [`Setting`]; an [`Episode`] is one attempt at it, the one
//! place where hands move in a task. [`script`] runs the competent teacher's program. A mistake in a file is a [`TaskError`] that names file,
//! line and key. Nothing here knows of task models or learning.
//!
//! ```
//! use situ_tasks::{Episode, Registry};
//!
//! let registry = Registry::builtin()?;
//! let setting = registry.get("sort_blocks")?.variation(Some("cover"))?;
//! let episode = Episode::start(&setting, 7)?;
//! assert_eq!(episode.observe().len(), setting.schema.len());
//! assert_eq!(episode.next_skill().map(|skill| skill.name.as_str()), Some("cover_grasp"));
//! # Ok::<(), situ_tasks::TaskError>(())
//! ```
//!
//! # The file
//!
//! Lengths are metres, angles radians, forces newtons, densities kg/m³. `[[object]]` has a `shape` ([`situ_sim::Shape`]) and a
//! `start` region; `[[joint]]` lets one object slide along another; `[beads]` fills a container; `[[magnet]]` holds a lid; `observe` lists what is seen;
//! `[guard]` says at which forces a motion ends; `premise` and `goal` are conditions ([`Predicate`]); `[[skill]]` is one skill of the teacher's program; `[[event]]` happens once (`push` with
//! `by`, or `drop`);
//! `[[intervention]]` is a moment at which a watching teacher stops the robot. `[[variation]]` may hold all of these but `observe`: an object
//! or a skill of a known name (or a joint of an object that slides already) replaces that one, new objects come last, new skills first, and the other lists are appended.
//! `[[sequence]]` names variations that a robot meets one after another.
//!
//! What carries the hand ([`Plant`]) is no matter of the file: by default an arm does, and a keyframe may be out of its reach.

mod builder;
mod episode;
mod error;
mod expression;
mod feature;
mod file;
mod key;
mod plant;
mod predicate;
mod registry;
pub mod script;
mod sequence;
mod setting;
mod skill;
mod start;
mod task;
mod trial;

pub use episode::{Episode, EpisodeSnapshot, GRIP_SECONDS, RISE_FIRST};
pub use error::TaskError;
pub use feature::{FILL_SCALE, Feature, JOINT_SCALE, LENGTH_SCALE, OPENING_SCALE, SEEN_SCALE, Schema, TILT_SCALE};
pub use plant::Plant;
pub use predicate::{GRIPPER, HELD_FORCE, ON_SLACK, PRESSED_PART, Predicate, REST_SPEED, UPRIGHT_TILT};
pub use registry::Registry;
pub use sequence::Sequence;
pub use setting::{Edit, Event, HandStart, Happening, Intervention, Moment, Placed, Setting, Start};
pub use skill::{Keyframe, Skill};
pub use task::Task;
pub use trial::{Attempt, Trial, trial};

/// The words of the physics that an episode's users need, so that they need not know the physics.
pub use situ_sim::{Gripper, MotionEnd, Pose, World};
