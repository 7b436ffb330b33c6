//! From the tasks' types to the learner's: the same numbers under another name.

use situ::demonstration::Gripper;
use situ::error::SituError;
use situ::state::{Axis, Feature, Schema, State};
use situ_tasks::{Episode, Setting};

/// The learner's schema of a setting's observed state.
///
/// # Errors
/// Where the setting's schema breaks a rule of the learner's.
pub fn schema(setting: &Setting) -> Result<Schema, SituError> {
    let features = setting.schema.features.iter();
    let features = features.map(|feature| Feature { name: feature.name.clone(), scale: feature.scale }).collect();
    // A parallel gripper: half a turn about its approach is the same grasp.
    Ok(Schema::new(features)?.with_half_turn(Some(Axis::Z)))
}

/// The observed state of an episode.
pub fn observe(episode: &Episode) -> State {
    State::new(episode.observe())
}

/// A gripper command as the learner sees it.
pub fn observed_gripper(command: situ_tasks::GripperCommand) -> Gripper {
    match command {
        situ_tasks::GripperCommand::Open(metres) => Gripper::Open(metres),
        situ_tasks::GripperCommand::Close(newtons) => Gripper::Close(newtons),
    }
}

/// A learned gripper command for the hand; `stroke` is the hand's greatest opening, metres.
pub fn gripper_command(gripper: Gripper, stroke: f64) -> situ_tasks::GripperCommand {
    match gripper {
        Gripper::Opening(fraction) => situ_tasks::GripperCommand::Open(fraction.clamp(0.0, 1.0) * stroke),
        Gripper::Open(metres) => situ_tasks::GripperCommand::Open(metres),
        Gripper::Close(newtons) => situ_tasks::GripperCommand::Close(newtons),
    }
}
