//! Shapes without room inside: blocks, cylinders, balls, lids, covers, marks and furniture.

use serde::Deserialize;

use crate::frame::Pose;
use crate::object::{Convex, Object, Outline, Part, Rolling};
use crate::shape::number::{all_positive, positive};

/// A cuboid. Frame: the centre.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Half extents along x, y, z in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Block {
    /// The block as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Block { half, density, friction } = *self;
        let part = Part::cuboid(half, [0.0; 3], density, friction);
        Object::new(name, vec![part], Outline { top: half[2], reach: libm::hypot(half[0], half[1]) })
    }
}

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
    /// Coefficient of rolling friction, 0 to 1: on a level plane the ball slows down by 5/7 of it times 9.81 m/s². A
    /// ball without it rolls for ever.
    #[serde(default)]
    pub rolling_friction: f64,
}

impl Sphere {
    /// The ball as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Sphere { radius, density, friction, rolling_friction } = *self;
        let part = Part::new(Convex::Ball { radius }, Pose::identity(), density, friction);
        Object::new(name, vec![part], Outline { top: radius, reach: radius })
            .with_rolling(Rolling { radius, friction: rolling_friction })
    }
}

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
        let part = Part::cuboid(half, [0.0, 0.0, half[2]], density, friction);
        let outline = Outline { top: 2.0 * half[2], reach: libm::hypot(half[0], half[1]) };
        Object::new(name, vec![part], outline).fixed().with_color([118, 124, 132])
    }
}

/// A plate with a bar to take it by: a door, the lid of a box, a lever. Frame: the centre of the plate.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// Half extents of the plate along x, y, z in metres.
    #[serde(deserialize_with = "all_positive")]
    pub half: [f64; 3],
    /// Centre of the bar in metres.
    pub bar_at: [f64; 3],
    /// Half extents of the bar in metres.
    #[serde(deserialize_with = "all_positive")]
    pub bar: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Panel {
    /// The panel as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Panel { half, bar_at, bar, density, friction } = *self;
        let parts = vec![Part::cuboid(half, [0.0; 3], density, friction), Part::cuboid(bar, bar_at, density, friction)];
        let outline = Outline { top: half[2], reach: libm::hypot(half[0], half[1]) };
        Object::new(name, parts, outline).with_color([198, 166, 120])
    }
}

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
        let part = |half, x, y, z| Part::cuboid(half, [x, y, z], density, friction);
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

/// Corners of the polygon that stands for a circle.
const ROUND_SIDES: u32 = 32;

/// A round lid: a flange that lies on the rim, a plug that reaches into the cup, a knob on top.
///
/// Frame: the centre of the *underside of its flange*. So its pose on a cup is the centre of the rim.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lid {
    /// Radius of the flange in metres.
    #[serde(deserialize_with = "positive")]
    pub flange_radius: f64,
    /// Thickness of the flange in metres.
    #[serde(deserialize_with = "positive")]
    pub flange_thickness: f64,
    /// Radius of the plug in metres. It must be at least 1 mm less than the cup's, or the lid jams.
    #[serde(deserialize_with = "positive")]
    pub plug_radius: f64,
    /// How far the plug reaches below the flange, in metres.
    #[serde(deserialize_with = "positive")]
    pub plug_depth: f64,
    /// Half extents of the knob in metres.
    #[serde(deserialize_with = "all_positive")]
    pub knob: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Lid {
    /// The lid as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Lid { flange_radius, flange_thickness, plug_radius, plug_depth, knob, density, friction } = *self;
        let part = |shape, z| Part::new(shape, Pose::translation(0.0, 0.0, z), density, friction);
        let disc = |radius, thickness: f64| Convex::Prism { radius, half_height: 0.5 * thickness, sides: ROUND_SIDES };
        let parts = vec![
            part(disc(flange_radius, flange_thickness), 0.5 * flange_thickness),
            part(disc(plug_radius, plug_depth), -0.5 * plug_depth),
            part(Convex::Cuboid { half: knob }, flange_thickness + knob[2]),
        ];
        let outline = Outline { top: flange_thickness, reach: flange_radius };
        Object::new(name, parts, outline).with_color([222, 184, 96])
    }
}

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
        let part = |half, z| Part::cuboid(half, [0.0, 0.0, z], density, friction);
        let parts = vec![part([half_x, half_y, 0.5 * thickness], 0.5 * thickness), part(knob, thickness + knob[2])];
        let outline = Outline { top: thickness, reach: libm::hypot(half_x, half_y) };
        Object::new(name, parts, outline).with_color([222, 184, 96])
    }
}

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
        let plate = Part::cuboid([half_x, half_y, HALF_THICKNESS], [0.0, 0.0, HALF_THICKNESS], 0.0, 0.0);
        let part = Part { solid: false, ..plate };
        let outline = Outline { top: 0.0, reach: libm::hypot(half_x, half_y) };
        Object::new(name, vec![part], outline).fixed().with_color([120, 144, 130])
    }
}
