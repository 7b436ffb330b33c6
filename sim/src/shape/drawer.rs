//! Drawers: what slides in a cabinet.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::pose_at;
use crate::interior::Interior;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// A drawer: an open box, a front panel towards −x, and a fin on it to take it by. Frame: the centre of the base of its
/// box.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drawer {
    /// Inner extents along x and y in metres.
    #[serde(deserialize_with = "all_positive")]
    pub inner: [f64; 2],
    /// Height of the rim above the base in metres.
    #[serde(deserialize_with = "positive")]
    pub height: f64,
    /// Thickness of walls and floor in metres.
    #[serde(deserialize_with = "positive")]
    pub wall: f64,
    /// Half of the front panel's thickness, width and height in metres. Its lower edge is at the base.
    #[serde(deserialize_with = "all_positive")]
    pub panel: [f64; 3],
    /// Half extents of the fin in metres. It stands upright before the middle of the panel.
    #[serde(deserialize_with = "all_positive")]
    pub fin: [f64; 3],
    /// Height of the fin's centre above the base in metres.
    pub fin_z: f64,
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Drawer {
    /// The drawer as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Drawer { inner, height, wall, panel, fin, fin_z, density, friction } = *self;
        let [half_x, half_y] = inner.map(|extent| 0.5 * extent);
        let half_wall = 0.5 * wall;
        let part = |half, at| Part::new(Convex::Cuboid { half }, pose_at(at, Default::default()), density, friction);
        let (half_z, middle) = (0.5 * (height - wall), 0.5 * (height + wall));
        let side = [half_x, half_wall, half_z];
        let panel_x = -half_x - panel[0];
        let parts = vec![
            part([half_x + half_wall, half_y + wall, half_wall], [half_wall, 0.0, half_wall]),
            part([half_wall, half_y + wall, half_z], [half_x + half_wall, 0.0, middle]),
            part(side, [0.0, half_y + half_wall, middle]),
            part(side, [0.0, -half_y - half_wall, middle]),
            part(panel, [panel_x, 0.0, panel[2]]),
            part(fin, [panel_x - panel[0] - fin[0], 0.0, fin_z]),
        ];
        let outline = Outline { top: height, reach: libm::hypot(half_x, half_y) };
        let room = Interior::Box { half_x, half_y, floor: wall, height };
        Object::new(name, parts, outline).with_color([198, 166, 120]).with_room(room)
    }
}
