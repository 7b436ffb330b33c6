//! Skills: what a competent teacher does, as keyframes relative to an object.

use situ_sim::{GripperCommand, Pose};

use crate::predicate::Predicate;

/// A part of the competent teacher's program. It may run while `when` holds and `until` does not.
///
/// Teleo-reactive programs are Nilsson's (Journal of Artificial Intelligence Research 1, 1994).
#[derive(Debug, Clone, PartialEq)]
pub struct Skill {
    /// Its name, unique in the setting.
    pub name: String,
    /// The reference object. Its frame is frozen when the skill begins.
    pub reference: String,
    /// It may run while this holds.
    pub when: Predicate,
    /// It may run while this does not hold.
    pub until: Predicate,
    /// What the hand does, in order.
    pub keyframes: Vec<KeyframeCommand>,
}

/// A command to the hand: go there, then do something with the gripper, then wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyframeCommand {
    /// Pose of the TCP relative to the reference object's frozen frame: metres, z up, the gripper's closing axis is y.
    pub pose: Pose,
    /// The gripper's command on arrival. None keeps the last one.
    pub gripper: Option<GripperCommand>,
    /// How long to wait afterwards, in seconds.
    pub hold: f64,
    /// Whether the hand touches something here, so that an error in the pose matters most.
    pub contact: bool,
}
