//! A keyframe that an episode is to go to, checked.

use serde::{Deserialize, Serialize};
use situ::demonstration::{Gripper, Pose};
use situ_teachers::convert::observed_gripper;

use super::request::{About, Target};
use crate::demonstration_file::content::{FileGripper, FilePose};
use crate::demonstration_file::rules::{check_gripper, pose};

/// The greatest coordinate of a hand, metres: beyond the table on every side.
const FARTHEST: f64 = 2.0;

/// A keyframe that an episode is to go to. It is written key for key, and is the same bits when it is read again.
#[derive(Clone, Debug)]
pub(super) struct Deed {
    /// Where the hand is to be: metres, world frame.
    pub(super) target: Pose,
    pub(super) gripper: Gripper,
    /// Seconds.
    pub(super) hold: f64,
    pub(super) about: About,
}

/// The keys of a deed in a snapshot.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeedKeys {
    position: [f64; 3],
    quaternion_wxyz: [f64; 4],
    gripper: FileGripper,
    hold: f64,
    about: About,
}

impl Deed {
    /// The deed that is asked for. `command` is the one in force, `about` says which primitive it is of where that is
    /// not said.
    ///
    /// # Errors
    /// What is wrong, and what was expected.
    pub(super) fn of(
        target: Target,
        command: situ_tasks::GripperCommand,
        about: impl FnOnce(&Pose) -> About,
    ) -> Result<Self, String> {
        let Target { position, quaternion_wxyz, gripper, hold, about: given } = target;
        let target = place(position, quaternion_wxyz)?;
        let gripper = gripper.map_or_else(|| observed_gripper(command), |gripper| gripper.0);
        let about = given.unwrap_or_else(|| about(&target));
        Self { target, gripper, hold, about }.checked()
    }

    /// # Errors
    /// As [`Deed::of`].
    pub(super) fn checked(self) -> Result<Self, String> {
        check_gripper(self.gripper, self.hold).map_err(|(key, problem)| format!("key `{key}`: {problem}"))?;
        Ok(self)
    }

    pub(super) fn keys(&self) -> DeedKeys {
        let rotation = &self.target.rotation;
        DeedKeys {
            position: self.target.translation.vector.into(),
            quaternion_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
            gripper: FileGripper(self.gripper),
            hold: self.hold,
            about: self.about.clone(),
        }
    }

    /// # Errors
    /// As [`Deed::of`].
    pub(super) fn from_keys(keys: DeedKeys) -> Result<Self, String> {
        let DeedKeys { position, quaternion_wxyz, gripper, hold, about } = keys;
        Self { target: place(position, quaternion_wxyz)?, gripper: gripper.0, hold, about }.checked()
    }
}

/// A pose of the hand.
fn place(position: [f64; 3], quaternion: [f64; 4]) -> Result<Pose, String> {
    if let Some(axis) = position.iter().position(|value| value.abs() > FARTHEST) {
        let value = position[axis];
        return Err(format!("key `position[{axis}]`: {value:e} metres, expected at most {FARTHEST} either way"));
    }
    pose(&FilePose { position, quaternion }, "pose").map_err(|(_, problem)| format!("key `quaternion_wxyz`: {problem}"))
}
