//! Scripted teachers: people who perform a task's script in physics, err in known ways, and correct a robot that has failed.
//!
//! A task's skill is a *command*; a demonstration is an *observation*. The teacher is who turns one into the other: it moves
//! the hand through the world of an [`situ_tasks::Episode`] and writes down what was seen. A correction is the same program,
//! run from the snapshot of a failure.

pub mod convert;
pub mod error;
pub mod mistakes;
pub mod profile;
pub mod roster;
pub mod tally;
pub mod teacher;

pub use error::TeacherError;
pub use mistakes::Onset;
pub use profile::{Detour, Misaligned, Noise, Pause, Profile};
pub use roster::Roster;
pub use tally::{Count, Tally, Way};
pub use teacher::{Effort, Shown, Teacher};
