//! Housings: what a button slides in.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// A fixed box that something slides in. Frame: the centre of its *base*, unlike that of a block.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Housing {
    /// Half extents along x, y, z in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Housing {
    /// The housing as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Housing { half, density, friction } = *self;
        let part = Part::new(Convex::Cuboid { half }, Pose::translation(0.0, 0.0, half[2]), density, friction);
        let outline = Outline { top: 2.0 * half[2], reach: libm::hypot(half[0], half[1]) };
        Object::new(name, vec![part], outline).fixed().with_color([118, 124, 132])
    }
}
