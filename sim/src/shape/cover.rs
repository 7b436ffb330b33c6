//! Covers: flat plates with a knob.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// A flat plate with a knob: the cover of a bowl or a bin. Frame: the centre of the *underside of its plate*.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cover {
    /// Half extents of the plate along x and y in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 2],
    /// Thickness of the plate in metres.
    #[serde(deserialize_with = "positive")]
    pub thickness: f64,
    /// Half extents of the knob in metres.
    #[serde(deserialize_with = "all_positive")]
    pub knob: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Cover {
    /// The cover as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Cover { half: [half_x, half_y], thickness, knob, density, friction } = *self;
        let part = |half, z| Part::new(Convex::Cuboid { half }, Pose::translation(0.0, 0.0, z), density, friction);
        let parts = vec![part([half_x, half_y, 0.5 * thickness], 0.5 * thickness), part(knob, thickness + knob[2])];
        let outline = Outline { top: thickness, reach: libm::hypot(half_x, half_y) };
        Object::new(name, parts, outline).with_color([222, 184, 96])
    }
}
