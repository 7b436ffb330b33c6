//! Rules that numbers and poses of a scene must keep.

use crate::error::SimError;
use crate::frame::{self, Pose};

/// No pose may be further than this from the world's origin, in metres.
const WORKSHOP: f64 = 5.0;

/// An error if any value is not within `[low, high]` (a value that is not a number is not). `what` is the rule, in
/// words.
pub(crate) fn within(object: &str, what: &'static str, values: &[f64], low: f64, high: f64) -> Result<(), SimError> {
    match values.iter().find(|&&v| !(low..=high).contains(&v)) {
        Some(&value) => Err(SimError::BadValue { object: object.to_owned(), what, value }),
        None => Ok(()),
    }
}

/// An error if the pose is not finite or outside the workshop.
pub(crate) fn check_pose(object: &str, pose: &Pose) -> Result<(), SimError> {
    if frame::is_finite(pose) && pose.translation.vector.norm() <= WORKSHOP {
        Ok(())
    } else {
        Err(SimError::BadPose { object: object.to_owned(), limit: WORKSHOP })
    }
}
