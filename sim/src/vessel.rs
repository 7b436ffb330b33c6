//! Containers and what closes them: cups with a handle, bins, lids, covers.

use serde::{Deserialize, Serialize};

use crate::frame::{Pose, pose_at, rotation_about};
use crate::object::{Interior, Motion, Object, Part, SIDES, Shape};

/// Corners of the polygon that stands for a circle in lids and floors.
const ROUND_SIDES: u32 = 32;
/// Walls end so high above the base, metres: more than the distance at which the engine makes contacts (0.4 mm).
const WALL_CLEARANCE: f64 = 6e-4;

/// A round container: pitcher, bowl, vase, the cup of a ladle. Metres, radians, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cup {
    /// Radius of the room inside, at its floor.
    pub inner_radius: f64,
    /// Height of the rim above the base.
    pub height: f64,
    /// Thickness of wall and floor.
    pub wall: f64,
    /// Angle by which the walls lean outwards, radians; 0 is a cylinder.
    pub flare: f64,
    /// Density of walls and floor.
    pub density: f64,
    /// Friction of walls and floor.
    pub friction: f64,
    /// Number of flat walls, 3 to 64.
    pub sides: u32,
}

impl Cup {
    /// The pitcher of the pouring task: 10 cm high, inner radius 4 cm.
    pub const PITCHER: Cup =
        Cup { inner_radius: 0.04, height: 0.10, wall: 0.005, flare: 0.0, density: 1500.0, friction: 0.4, sides: 16 };
    /// The bowl of the pouring task: 6 cm high, radius 5.5 cm at the floor, leaning outwards.
    pub const BOWL: Cup =
        Cup { inner_radius: 0.055, height: 0.06, wall: 0.005, flare: 0.35, density: 1500.0, friction: 0.4, sides: 16 };
}

/// A bar to take a cup by, and the struts that hold it. Metres, in the cup's frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Handle {
    /// Centre of the bar.
    pub center: [f64; 3],
    /// Half extents of the bar.
    pub half: [f64; 3],
    /// Heights of the struts between cup and bar; none for the stem of a ladle, which touches its cup.
    pub struts: Vec<f64>,
    /// Half extents of a strut across and along the bar; narrower than the bar, so that the fingers touch the bar only.
    pub strut_half: [f64; 2],
    /// Density of bar and struts.
    pub density: f64,
    /// Friction of bar and struts.
    pub friction: f64,
}

impl Default for Handle {
    /// The handle of the pitcher: a bar 16 mm square and 7 cm long, 8 cm from the axis on the side of −x.
    fn default() -> Handle {
        Handle {
            center: [-0.08, 0.0, 0.055],
            half: [0.008, 0.008, 0.035],
            struts: vec![0.085, 0.025],
            strut_half: [0.006, 0.005],
            density: 1500.0,
            friction: 0.8,
        }
    }
}

/// An open box. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Inner extent along x.
    pub inner_x: f64,
    /// Inner extent along y.
    pub inner_y: f64,
    /// Height of the rim above the base.
    pub height: f64,
    /// Thickness of wall and floor.
    pub wall: f64,
    /// Density.
    pub density: f64,
    /// Friction.
    pub friction: f64,
}

/// A round lid: a flange that lies on the rim, a plug that reaches into the cup, a knob on top. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lid {
    /// Radius of the flange.
    pub flange_radius: f64,
    /// Thickness of the flange.
    pub flange_thickness: f64,
    /// Radius of the plug; at least 1 mm less than the cup's, or it jams.
    pub plug_radius: f64,
    /// How far the plug reaches below the flange.
    pub plug_depth: f64,
    /// Half extents of the knob.
    pub knob_half: [f64; 3],
    /// Density.
    pub density: f64,
    /// Friction.
    pub friction: f64,
}

impl Lid {
    /// The lid that fits [`Cup::PITCHER`] with 2 mm of clearance; 46 g.
    pub const PITCHER: Lid = Lid {
        flange_radius: 0.047,
        flange_thickness: 0.004,
        plug_radius: 0.038,
        plug_depth: 0.012,
        knob_half: [0.008, 0.007, 0.013],
        density: 500.0,
        friction: 0.4,
    };
}

/// A flat plate with a knob: the cover of a bowl or a bin. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cover {
    /// Half extent of the plate along x.
    pub half_x: f64,
    /// Half extent of the plate along y.
    pub half_y: f64,
    /// Thickness of the plate.
    pub thickness: f64,
    /// Half extents of the knob.
    pub knob_half: [f64; 3],
    /// Density.
    pub density: f64,
    /// Friction.
    pub friction: f64,
}

impl Object {
    /// A round container of flat walls, with a handle if one is given. Frame: the centre of its base.
    ///
    /// The room inside is the cone through the middles of the walls, so beads in the corners between walls count as inside only up to there.
    pub fn cup(name: impl Into<String>, cup: &Cup, handle: Option<&Handle>) -> Object {
        let Cup { inner_radius, height, wall, flare, density, friction, sides } = *cup;
        let (sine, cosine) = libm::sincos(flare);
        let top_radius = inner_radius + (height - wall) * sine / cosine;
        let interior = Interior::Cone { bottom_radius: inner_radius, top_radius, floor: wall, height };
        // A cylinder, not a prism: the engine finds a ball's place on it in closed form, three times as fast.
        let floor = Shape::Cylinder { radius: inner_radius + 0.5 * wall / cosine, half_height: 0.5 * wall };
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
                parts.push(Part::new(Shape::Cuboid { half }, turn * stand, density, friction));
            }
        } else {
            parts.clear(); // refused by `World::add` with a message about the sides
        }
        if let Some(handle) = handle {
            parts.extend(handle_parts(handle, &interior, wall));
        }
        Object { name: name.into(), motion: Motion::Dynamic, parts, color: [86, 134, 176], container: Some(interior) }
    }

    /// An open box. Frame: the centre of its base.
    pub fn bin(name: impl Into<String>, bin: &Bin) -> Object {
        let Bin { inner_x, inner_y, height, wall, density, friction } = *bin;
        let (half_x, half_y, half_wall) = (0.5 * inner_x, 0.5 * inner_y, 0.5 * wall);
        let part = |half, x, y, z| Part::new(Shape::Cuboid { half }, Pose::translation(x, y, z), density, friction);
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
        let container = Some(Interior::Box { half_x, half_y, floor: wall, height });
        Object { name: name.into(), motion: Motion::Dynamic, parts, color: [176, 148, 86], container }
    }

    /// A round lid. Frame: the centre of the *underside of its flange*, so its pose on a cup is the centre of the rim.
    pub fn lid(name: impl Into<String>, lid: &Lid) -> Object {
        let Lid { flange_radius, flange_thickness, plug_radius, plug_depth, knob_half, density, friction } = *lid;
        let disc = |radius, thickness: f64, z| {
            let shape = Shape::Prism { radius, half_height: 0.5 * thickness, sides: ROUND_SIDES };
            Part::new(shape, Pose::translation(0.0, 0.0, z), density, friction)
        };
        let knob_z = flange_thickness + knob_half[2];
        let knob = Part::new(Shape::Cuboid { half: knob_half }, Pose::translation(0.0, 0.0, knob_z), density, friction);
        let parts = vec![
            disc(flange_radius, flange_thickness, 0.5 * flange_thickness),
            disc(plug_radius, plug_depth, -0.5 * plug_depth),
            knob,
        ];
        Object { name: name.into(), motion: Motion::Dynamic, parts, color: [222, 184, 96], container: None }
    }

    /// A flat cover with a knob. Frame: the centre of the *underside of its plate*.
    pub fn cover(name: impl Into<String>, cover: &Cover) -> Object {
        let Cover { half_x, half_y, thickness, knob_half, density, friction } = *cover;
        let part = |half, z| Part::new(Shape::Cuboid { half }, Pose::translation(0.0, 0.0, z), density, friction);
        let parts =
            vec![part([half_x, half_y, 0.5 * thickness], 0.5 * thickness), part(knob_half, thickness + knob_half[2])];
        Object { name: name.into(), motion: Motion::Dynamic, parts, color: [222, 184, 96], container: None }
    }
}

/// The bar, and struts from the middle of the wall to the bar.
fn handle_parts(handle: &Handle, interior: &Interior, wall: f64) -> Vec<Part> {
    let Handle { center, half, ref struts, strut_half, density, friction } = *handle;
    let mut parts = vec![Part::new(Shape::Cuboid { half }, pose_at(center, Default::default()), density, friction)];
    let side = center[0].signum();
    for &z in struts {
        let inner = interior.radius_at(z) + 0.5 * wall;
        let outer = center[0].abs() - half[0];
        let strut = Shape::Cuboid { half: [0.5 * (outer - inner), strut_half[0], strut_half[1]] };
        let pose = Pose::translation(side * 0.5 * (inner + outer), center[1], z);
        parts.push(Part::new(strut, pose, density, friction));
    }
    parts
}
