//! Mats: marks on the table.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::all_positive;

/// Half of a mat's thickness in metres: as thin as a sheet of felt.
const HALF_THICKNESS: f64 = 5e-4;

/// A mark on the table, fixed and without collision: a place where something belongs. Frame: the centre of its base.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mat {
    /// Half extents along x and y in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 2],
}

impl Mat {
    /// The mat as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let [half_x, half_y] = self.half;
        let shape = Convex::Cuboid { half: [half_x, half_y, HALF_THICKNESS] };
        let part = Part { solid: false, ..Part::new(shape, Pose::translation(0.0, 0.0, HALF_THICKNESS), 0.0, 0.0) };
        let outline = Outline { top: 0.0, reach: libm::hypot(half_x, half_y) };
        Object::new(name, vec![part], outline).fixed().with_color([120, 144, 130])
    }
}
