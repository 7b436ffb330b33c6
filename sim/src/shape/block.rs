//! Blocks: cuboids of one part.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// A cuboid. Frame: the centre.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Half extents along x, y, z in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Block {
    /// The block as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Block { half, density, friction } = *self;
        let part = Part::new(Convex::Cuboid { half }, Pose::identity(), density, friction);
        Object::new(name, vec![part], Outline { top: half[2], reach: libm::hypot(half[0], half[1]) })
    }
}
