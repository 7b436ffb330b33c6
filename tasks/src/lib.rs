//! A task is a file: objects, the goal, what a competent teacher does, and variations. Each variation needs one edit of
//! a task model, or none.
//!
//! [`Registry`] knows the tasks by name. A [`Task`] with one variation applied is a [`Setting`]. An [`Episode`] is one
//! attempt at a setting, and the one place where hands move in a task. [`script`] runs the program of the competent
//! teacher. A mistake in a file is a [`TaskError`] that names file, line and key. Nothing here knows of task models or
//! learning.
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
//! Lengths are metres, angles radians, forces newtons, densities kg/m³. `[[object]]` has a `shape`
//! ([`situ_sim::Shape`]) and a `start` region. `[[joint]]` lets one object slide along another. `[beads]` fills a
//! container. `[[magnet]]` holds a lid. `[[hinge]]` lets one object turn on another, `[[role]]` speaks of whichever of
//! several objects is due, and `[perception]` is a camera that sees with noise. `observe` lists the observed features.
//! `[guard]` says at which forces a motion ends. `premise` and `goal` are conditions ([`Predicate`]; [`Condition`]
//! lists the words). `[[skill]]` is one skill of the teacher's program. `[[event]]` happens once (`push` with `by`, or
//! `drop`). `[[intervention]]` is a moment at which a watching teacher stops the robot. `[[variation]]` may hold all of
//! these except `observe`, `[guard]` and `[perception]`. An object or a skill of a known name replaces that one, and so
//! does a `[[joint]]` of an object that slides already. New objects come last, new skills first. The other lists are
//! appended. `[[sequence]]` names variations that a robot meets one after another. Every key with its unit and frame:
//! `bench/docs/task-files.md`.
//!
//! The file does not say what carries the hand ([`Plant`]). By default an arm does, and a keyframe may be out of its
//! reach.

mod builder;
mod edit;
mod episode;
mod error;
mod event;
mod expression;
mod feature;
mod file;
mod file_kind;
mod intervention;
pub mod key;
mod level;
mod measure;
mod moment;
pub mod name;
mod placement;
mod plant;
mod poses;
mod predicate;
mod registry;
mod role;
pub mod script;
mod sequence;
mod setting;
mod sight;
mod skill;
mod start;
mod stream;
mod task;
mod trial;
mod view;
mod vocabulary;

pub use edit::NeededEdit;
pub use episode::{Episode, EpisodeSnapshot, RISE_FIRST};
pub use error::TaskError;
pub use event::{Event, Happening};
pub use feature::{
    ANGLE_SCALE, FILL_SCALE, LENGTH_SCALE, OPENING_SCALE, SEEN_SCALE, SLIDE_SCALE, TILT_SCALE, WorldFeature,
    WorldSchema,
};
pub use file_kind::FileKind;
pub use intervention::Intervention;
pub use measure::{HELD_FORCE, ON_SLACK, REST_SPEED};
pub use moment::Moment;
pub use placement::{HandStart, Placed, Start};
pub use plant::Plant;
pub use poses::{PoseSchema, Poses};
pub use predicate::{Condition, Measured, PRESSED_PART, Predicate, UPRIGHT_TILT};
pub use registry::Registry;
pub use role::ObjectRole;
pub use sequence::{ORIGINAL, VariationSequence};
pub use setting::Setting;
pub use sight::Perception;
pub use skill::{KeyframeCommand, Skill};
pub use task::Task;
pub use trial::{Attempt, Trial, trial};
pub use view::{GRIPPER, View};

/// The words of the physics that the users of an episode need. So they need not know the physics itself.
pub use situ_sim::{GripperCommand, MotionEnd, Pose, World};
