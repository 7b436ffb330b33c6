//! Balls.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::positive;

/// A ball. Frame: the centre.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Radius in metres.
    #[serde(deserialize_with = "positive")]
    pub radius: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Sphere {
    /// The ball as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Sphere { radius, density, friction } = *self;
        let part = Part::new(Convex::Ball { radius }, Pose::identity(), density, friction);
        Object::new(name, vec![part], Outline { top: radius, reach: radius })
    }
}
