//! Scripted teachers: they perform a task's script in physics, err in known ways, and correct a robot that has failed.
//!
//! A task's skill is a *command*; a demonstration is an *observation*. The teacher turns one into the other: it moves
//! the hand through the world of an [`situ_tasks::Episode`] and writes down what was seen. A correction is the same
//! program, run from the snapshot of a failure.

pub mod convert;
mod error;
mod extent;
mod grasp;
mod mistakes;
mod onset;
mod path;
mod profile;
mod roster;
mod tally;
mod teacher;

pub use error::TeacherError;
pub use extent::{Detour, Misaligned, Noise, Pause, Spread};
pub use onset::Onset;
pub use profile::{Profile, Way};
pub use roster::Roster;
pub use tally::{Count, Tally};
pub use teacher::{Shown, Teacher, TeachingEffort};
