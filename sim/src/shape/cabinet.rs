//! Cabinets: what a drawer slides in.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// The carcass of a cabinet, open towards −x, on a solid base, fixed. Frame: the centre of its base.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cabinet {
    /// Extents along x, y, z in metres.
    #[serde(deserialize_with = "all_positive")]
    pub size: [f64; 3],
    /// Height of the base, below the opening, in metres.
    #[serde(deserialize_with = "positive")]
    pub base: f64,
    /// Thickness of sides, back and top in metres.
    #[serde(deserialize_with = "positive")]
    pub wall: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Cabinet {
    /// The cabinet as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Cabinet { size: [depth, width, height], base, wall, density, friction } = *self;
        let (half_x, half_y, half_wall) = (0.5 * depth, 0.5 * width, 0.5 * wall);
        let part = |half, x, y, z| Part::new(Convex::Cuboid { half }, Pose::translation(x, y, z), density, friction);
        let (half_z, middle) = (0.5 * (height - base - wall), 0.5 * (height - wall + base));
        let side = [half_x, half_wall, half_z];
        let parts = vec![
            part([half_x, half_y, 0.5 * base], 0.0, 0.0, 0.5 * base),
            part([half_x, half_y, half_wall], 0.0, 0.0, height - half_wall),
            part(side, 0.0, half_y - half_wall, middle),
            part(side, 0.0, half_wall - half_y, middle),
            part([half_wall, half_y - wall, half_z], half_x - half_wall, 0.0, middle),
        ];
        let outline = Outline { top: height, reach: libm::hypot(half_x, half_y) };
        Object::new(name, parts, outline).fixed().with_color([158, 128, 96])
    }
}
