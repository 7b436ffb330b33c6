//! Containers: cups, bins and drawers.

use serde::Deserialize;

use crate::frame::{Pose, pose_at, rotation_about};
use crate::object::{Convex, Interior, Object, Outline, Part, SIDES};
use crate::shape::number::{all_positive, positive, sides};

/// The walls end so high above the base, metres: more than the distance at which the engine makes contacts (0.4 mm).
const WALL_CLEARANCE: f64 = 6e-4;

/// A round container: pitcher, bowl, vase, the cup of a ladle. Frame: the centre of its base.
///
/// The room inside is the cone through the middles of the walls. So the beads in the corners between walls count as
/// inside only up to there.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cup {
    /// Radius of the room inside, at its floor, in metres.
    #[serde(deserialize_with = "positive")]
    pub inner_radius: f64,
    /// Height of the rim above the base in metres.
    #[serde(deserialize_with = "positive")]
    pub height: f64,
    /// Thickness of wall and floor in metres.
    #[serde(deserialize_with = "positive")]
    pub wall: f64,
    /// Angle by which the walls lean outwards, radians; 0 is a cylinder.
    #[serde(default)]
    pub flare: f64,
    /// Density of walls and floor, kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction of walls and floor.
    pub friction: f64,
    /// Number of flat walls, 3 to 64.
    #[serde(deserialize_with = "sides")]
    pub sides: u32,
    /// What it is taken by, if it has one.
    pub handle: Option<Handle>,
}

/// A bar to take a cup by, and the struts that hold it. Metres, in the cup's frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Handle {
    /// Centre of the bar.
    pub center: [f64; 3],
    /// Half extents of the bar.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 3],
    /// Heights of the struts between cup and bar; none for the stem of a ladle, which touches its cup.
    pub struts: Vec<f64>,
    /// Half extents of a strut across and along the bar. They are less than the bar's, so that the fingers touch the
    /// bar only.
    #[serde(deserialize_with = "all_positive")]
    pub strut_half: [f64; 2],
    /// Density of bar and struts, kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction of bar and struts.
    pub friction: f64,
}

impl Cup {
    /// The cup as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Cup { inner_radius, height, wall, flare, density, friction, sides, ref handle } = *self;
        let (sine, cosine) = libm::sincos(flare);
        let top_radius = inner_radius + (height - wall) * sine / cosine;
        let room = Interior::Cone { bottom_radius: inner_radius, top_radius, floor: wall, height };
        // A cylinder, not a prism: the engine finds a ball's place on it in closed form, three times as fast.
        let floor = Convex::Cylinder { radius: inner_radius + 0.5 * wall / cosine, half_height: 0.5 * wall };
        let mut parts = vec![Part::new(floor, Pose::translation(0.0, 0.0, 0.5 * wall), density, friction)];
        if SIDES.contains(&sides) {
            // The walls hide the floor's edge but end just above the table, so only the floor rests on it.
            let low = WALL_CLEARANCE.min(0.5 * wall);
            let middle = 0.5 * (low + height);
            let radius = inner_radius + (middle - wall) * sine / cosine;
            let half_width = (top_radius + wall) * libm::tan(std::f64::consts::PI / f64::from(sides));
            let half = [0.5 * wall, half_width, 0.5 * (height - low) / cosine];
            let lean = rotation_about([0.0, 1.0, 0.0], flare);
            for k in 0..sides {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(sides);
                let turn = pose_at([0.0; 3], rotation_about([0.0, 0.0, 1.0], angle));
                let stand = pose_at([radius + 0.5 * wall * cosine, 0.0, middle - 0.5 * wall * sine], lean);
                parts.push(Part::new(Convex::Cuboid { half }, turn * stand, density, friction));
            }
        } else {
            parts.clear(); // refused by `World::add` with a message about the sides
        }
        parts.extend(handle.iter().flat_map(|handle| handle.parts(&room, wall)));
        let outline = Outline { top: height, reach: inner_radius + wall + height * libm::tan(flare) };
        Object::new(name, parts, outline).with_color([86, 134, 176]).with_room(room)
    }
}

impl Handle {
    /// The bar, and struts from the middle of the cup's wall to the bar.
    fn parts(&self, room: &Interior, wall: f64) -> Vec<Part> {
        let Handle { center, half, ref struts, strut_half, density, friction } = *self;
        let mut parts = vec![Part::cuboid(half, center, density, friction)];
        let side = center[0].signum();
        for &z in struts {
            let inner = room.radius_at(z) + 0.5 * wall;
            let outer = center[0].abs() - half[0];
            let strut = [0.5 * (outer - inner), strut_half[0], strut_half[1]];
            let at = [side * 0.5 * (inner + outer), center[1], z];
            parts.push(Part::cuboid(strut, at, density, friction));
        }
        parts
    }
}

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
        let part = |half, x, y, z| Part::cuboid(half, [x, y, z], density, friction);
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
        let part = |half, at| Part::cuboid(half, at, density, friction);
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
