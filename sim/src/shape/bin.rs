//! Bins: open boxes.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::interior::Interior;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// An open box. Frame: the centre of its base.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bin {
    /// Inner extents along x and y in metres.
    #[serde(deserialize_with = "all_positive")]
    pub inner: [f64; 2],
    /// Height of the rim above the base in metres.
    #[serde(deserialize_with = "positive")]
    pub height: f64,
    /// Thickness of wall and floor in metres.
    #[serde(deserialize_with = "positive")]
    pub wall: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Bin {
    /// The bin as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Bin { inner, height, wall, density, friction } = *self;
        let [half_x, half_y] = inner.map(|extent| 0.5 * extent);
        let half_wall = 0.5 * wall;
        let part = |half, x, y, z| Part::new(Convex::Cuboid { half }, Pose::translation(x, y, z), density, friction);
        let (low, half_z) = (0.5 * (height + half_wall), 0.5 * (height - half_wall));
        let across = [half_wall, half_y + wall, half_z];
        let along = [half_x + wall, half_wall, half_z];
        let parts = vec![
            part([half_x + wall, half_y + wall, half_wall], 0.0, 0.0, half_wall),
            part(across, half_x + half_wall, 0.0, low),
            part(across, -half_x - half_wall, 0.0, low),
            part(along, 0.0, half_y + half_wall, low),
            part(along, 0.0, -half_y - half_wall, low),
        ];
        let outline = Outline { top: height, reach: libm::hypot(half_x + wall, half_y + wall) };
        let room = Interior::Box { half_x, half_y, floor: wall, height };
        Object::new(name, parts, outline).with_color([176, 148, 86]).with_room(room)
    }
}
