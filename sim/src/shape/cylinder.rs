//! Cylinders of one part.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::positive;

/// A cylinder that stands upright. Frame: the centre.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Radius in metres.
    #[serde(deserialize_with = "positive")]
    pub radius: f64,
    /// Height in metres.
    #[serde(deserialize_with = "positive")]
    pub height: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Cylinder {
    /// The cylinder as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Cylinder { radius, height, density, friction } = *self;
        let half_height = 0.5 * height;
        let part = Part::new(Convex::Cylinder { radius, half_height }, Pose::identity(), density, friction);
        Object::new(name, vec![part], Outline { top: half_height, reach: radius })
    }
}
