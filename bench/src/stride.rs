//! The way to one keyframe, as every executor goes it: rollouts of task models, and episodes that are served.

use situ::demonstration::{Gripper, Pose};
use situ_sim::{GripperCommand, MAX_OPENING, MotionEnd, World};
use situ_tasks::Episode;
use situ_teachers::convert::gripper_command;

use crate::ended::Ended;

/// A keyframe that is to be gone to.
pub(crate) struct Stride<'a> {
    /// Where the hand is to be: metres, world frame.
    pub(crate) target: Pose,
    /// The command to the gripper there.
    pub(crate) gripper: Gripper,
    /// Seconds of rest there.
    pub(crate) hold: f64,
    /// The reference object of the primitive that it is a keyframe of, and its index there, from 0. Events wait for
    /// it.
    pub(crate) about: (&'a str, usize),
}

impl Stride<'_> {
    /// Goes there. Returns the force on the hand, newtons, where the guard stopped it on the way, which does not end a
    /// primitive. The observer sees each step.
    ///
    /// # Errors
    /// Why the primitive cannot go on: it was aborted, it was out of reach, there was no plan, or the physics is
    /// spoilt.
    pub(crate) fn go(&self, episode: &mut Episode, observer: &mut dyn FnMut(&World)) -> Result<Option<f64>, Ended> {
        let command = gripper_command(self.gripper, MAX_OPENING);
        let gripper = (!same(command, episode.world().gripper())).then_some(command);
        let end = episode.perform(&self.target, gripper, self.hold, observer);
        if !episode.is_sound() {
            return Err(Ended::Spoilt);
        }
        let (reference, index) = self.about;
        episode.reached_keyframe(reference, index);
        match end {
            MotionEnd::Reached => Ok(None),
            MotionEnd::Guarded { force } => Ok(Some(force)),
            MotionEnd::Aborted { .. } => Err(Ended::Aborted),
            MotionEnd::OutOfReach => Err(Ended::OutOfReach),
            MotionEnd::NoPlan => Err(Ended::NoPlan),
        }
    }
}

/// A learned command is a mean. Within this of the command in force, it is that command. Metres.
const SAME_OPENING: f64 = 1e-3;
/// The same for a force, newtons.
const SAME_FORCE: f64 = 0.5;

fn same(left: GripperCommand, right: GripperCommand) -> bool {
    match (left, right) {
        (GripperCommand::Open(left), GripperCommand::Open(right)) => (left - right).abs() < SAME_OPENING,
        (GripperCommand::Close(left), GripperCommand::Close(right)) => (left - right).abs() < SAME_FORCE,
        _ => false,
    }
}
