//! One convex piece of an object or of a link of the arm.

use serde::{Deserialize, Serialize};

use crate::check::{check_pose, within};
use crate::convex::Convex;
use crate::error::SimError;
use crate::frame::Pose;

/// The largest density in kg/m³ (osmium is 22 590).
const MAX_DENSITY: f64 = 3e4;
/// The largest coefficient of friction (rubber on rubber is about 2).
const MAX_FRICTION: f64 = 5.0;

/// One convex piece of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its solid.
    pub shape: Convex,
    /// Its pose in the object's frame.
    pub pose: Pose,
    /// kg/m³.
    pub density: f64,
    /// Coefficient of friction. Two surfaces in contact rub with the mean of theirs.
    pub friction: f64,
    /// Whether other things collide with it. A mark on the table does not.
    pub solid: bool,
}

impl Part {
    /// A solid part.
    pub fn new(shape: Convex, pose: Pose, density: f64, friction: f64) -> Part {
        Part { shape, pose, density, friction, solid: true }
    }

    /// Says what is wrong with the part, if anything.
    pub(crate) fn check(&self, object: &str) -> Result<(), SimError> {
        self.shape.check(object)?;
        within(object, "density must be 0 to 30000 kg/m³", &[self.density], 0.0, MAX_DENSITY)?;
        within(object, "friction must be 0 to 5", &[self.friction], 0.0, MAX_FRICTION)?;
        check_pose(object, &self.pose)
    }
}
