//! What stands on the table: a named body made of convex parts.

use rapier3d::geometry::SharedShape;
use rapier3d::math::{Rotation, Vector};
use rapier3d::prelude::Pose as EnginePose;
use serde::{Deserialize, Serialize};

use crate::error::SimError;
use crate::frame::{self, Pose};

/// The smallest extent of a part in metres: below it single precision and the contact margin stop making sense.
const MIN_SIZE: f64 = 2e-4;
/// The largest extent of a part in metres: the table is not larger.
const MAX_SIZE: f64 = 2.0;
/// The largest density in kg/m³ (osmium is 22 590).
const MAX_DENSITY: f64 = 3e4;
/// The largest coefficient of friction (rubber on rubber is about 2).
const MAX_FRICTION: f64 = 5.0;
/// The most parts that an object may have: a cup of 64 walls with floor and handle.
const MAX_PARTS: usize = 72;
/// The fewest and the most sides of a polygonal prism or a cup.
pub(crate) const SIDES: std::ops::RangeInclusive<u32> = 3..=64;
/// No pose may be further than this from the world's origin, in metres.
pub(crate) const WORKSHOP: f64 = 5.0;

/// Whether an object can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motion {
    /// It stays where it is put.
    Fixed,
    /// It moves by forces.
    Dynamic,
}

/// A convex shape, centred on the origin of its part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A box.
    Cuboid {
        /// Half extents along x, y, z in metres.
        half: [f64; 3],
    },
    /// A cylinder with its axis along z.
    Cylinder {
        /// Radius in metres.
        radius: f64,
        /// Half of its height in metres.
        half_height: f64,
    },
    /// A ball.
    Ball {
        /// Radius in metres.
        radius: f64,
    },
    /// A prism over a regular polygon, with its axis along z and a corner on the x axis.
    Prism {
        /// Distance of the corners from the axis in metres.
        radius: f64,
        /// Half of its height in metres.
        half_height: f64,
        /// Number of corners of the polygon, 3 to 64.
        sides: u32,
    },
}

/// One convex piece of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its shape.
    pub shape: Shape,
    /// Its pose in the object's frame.
    pub pose: Pose,
    /// kg/m³.
    pub density: f64,
    /// Coefficient of friction; two surfaces in contact rub with the mean of theirs.
    pub friction: f64,
    /// Whether other things collide with it. A mark on the table does not.
    pub solid: bool,
}

impl Part {
    /// A solid part.
    pub fn new(shape: Shape, pose: Pose, density: f64, friction: f64) -> Part {
        Part { shape, pose, density, friction, solid: true }
    }
}

/// The room inside a container, in the container's frame: z up, the axis through the frame's origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Interior {
    /// A truncated cone.
    Cone {
        /// Radius at the floor in metres.
        bottom_radius: f64,
        /// Radius at the rim in metres.
        top_radius: f64,
        /// Height of the floor's upper face in metres.
        floor: f64,
        /// Height of the rim in metres.
        height: f64,
    },
    /// A box.
    Box {
        /// Half of the inner extent along x in metres.
        half_x: f64,
        /// Half of the inner extent along y in metres.
        half_y: f64,
        /// Height of the floor's upper face in metres.
        floor: f64,
        /// Height of the rim in metres.
        height: f64,
    },
}

impl Interior {
    /// Height of the floor's upper face, in metres.
    pub fn floor(&self) -> f64 {
        match *self {
            Interior::Cone { floor, .. } | Interior::Box { floor, .. } => floor,
        }
    }

    /// Height of the rim, in metres.
    pub fn height(&self) -> f64 {
        match *self {
            Interior::Cone { height, .. } | Interior::Box { height, .. } => height,
        }
    }

    /// Whether a point in the container's frame is between the walls, above the floor and at most `above_rim` metres above the rim.
    pub fn contains(&self, point: [f64; 3], above_rim: f64) -> bool {
        let [x, y, z] = point;
        if !(z >= self.floor() && z <= self.height() + above_rim) {
            return false;
        }
        match *self {
            Interior::Cone { .. } => {
                let radius = self.radius_at(z);
                x * x + y * y <= radius * radius
            }
            Interior::Box { half_x, half_y, .. } => x.abs() <= half_x && y.abs() <= half_y,
        }
    }

    /// The radius of the largest circle about the axis at height `z` (clamped to between floor and rim), in metres.
    pub fn radius_at(&self, z: f64) -> f64 {
        match *self {
            Interior::Cone { bottom_radius, top_radius, floor, height } => {
                let s = ((z - floor) / (height - floor)).clamp(0.0, 1.0);
                bottom_radius + (top_radius - bottom_radius) * s
            }
            Interior::Box { half_x, half_y, .. } => half_x.min(half_y),
        }
    }

    fn check(&self, object: &str) -> Result<(), SimError> {
        let sizes = match *self {
            Interior::Cone { bottom_radius, top_radius, floor, height } => [bottom_radius, top_radius, height - floor],
            Interior::Box { half_x, half_y, floor, height } => [half_x, half_y, height - floor],
        };
        within(object, "inner sizes must be 0.0002 m to 2 m", &sizes, MIN_SIZE, MAX_SIZE)
    }
}

/// A named body on the table.
///
/// The frame's origin is at the *centre* of a block, at the centre of the *base* of containers and marks, and at the centre of the
/// *underside of the flange or plate* of lids and covers. So a keyframe relative to an object says how high above its base, not above its rim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name, unique in the world.
    pub name: String,
    /// Whether it can be moved.
    pub motion: Motion,
    /// The convex pieces it is made of.
    pub parts: Vec<Part>,
    /// Its colour in pictures: red, green, blue.
    pub color: [u8; 3],
    /// The room inside, if it is a container.
    pub container: Option<Interior>,
}

impl Object {
    /// A block (cuboid). Frame: the centre.
    pub fn block(name: impl Into<String>, half: [f64; 3], density: f64, friction: f64) -> Object {
        Object {
            name: name.into(),
            motion: Motion::Dynamic,
            parts: vec![Part::new(Shape::Cuboid { half }, Pose::identity(), density, friction)],
            color: [201, 76, 60],
            container: None,
        }
    }

    /// A mark on the table, without collision: a place where something belongs. Frame: the centre of its base.
    pub fn mat(name: impl Into<String>, half_x: f64, half_y: f64) -> Object {
        /// As thin as a sheet of felt.
        const HALF_THICKNESS: f64 = 5e-4;
        let shape = Shape::Cuboid { half: [half_x, half_y, HALF_THICKNESS] };
        let part = Part { solid: false, ..Part::new(shape, Pose::translation(0.0, 0.0, HALF_THICKNESS), 0.0, 0.0) };
        Object { name: name.into(), motion: Motion::Fixed, parts: vec![part], color: [120, 144, 130], container: None }
    }

    /// The same object in another colour.
    pub fn with_color(self, color: [u8; 3]) -> Object {
        Object { color, ..self }
    }

    /// The same object, immovable: a stand, a bin screwed to the table.
    pub fn fixed(self) -> Object {
        Object { motion: Motion::Fixed, ..self }
    }

    /// Says what is wrong with the description, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let name = &self.name;
        let count = self.parts.len();
        if !(1..=MAX_PARTS).contains(&count) {
            let what = "it must have 1 to 72 parts (a cup has 3 to 64 sides)";
            return Err(SimError::BadValue { object: name.clone(), what, value: count as f64 });
        }
        for part in &self.parts {
            part.shape.check(name)?;
            within(name, "density must be 0 to 30000 kg/m³", &[part.density], 0.0, MAX_DENSITY)?;
            within(name, "friction must be 0 to 5", &[part.friction], 0.0, MAX_FRICTION)?;
            check_pose(name, &part.pose)?;
        }
        if self.motion == Motion::Dynamic && !self.parts.iter().any(|p| p.solid && p.density > 0.0) {
            let what = "a dynamic object needs a solid part of positive density";
            return Err(SimError::BadValue { object: name.clone(), what, value: 0.0 });
        }
        self.container.as_ref().map_or(Ok(()), |interior| interior.check(name))
    }
}

impl Shape {
    fn check(&self, object: &str) -> Result<(), SimError> {
        let rule = "sizes of parts must be 0.0002 m to 2 m";
        match *self {
            Shape::Cuboid { half } => within(object, rule, &half, MIN_SIZE, MAX_SIZE),
            Shape::Cylinder { radius, half_height } => within(object, rule, &[radius, half_height], MIN_SIZE, MAX_SIZE),
            Shape::Ball { radius } => within(object, rule, &[radius], MIN_SIZE, MAX_SIZE),
            Shape::Prism { radius, half_height, sides } => {
                within(object, rule, &[radius, half_height], MIN_SIZE, MAX_SIZE)?;
                let (low, high) = (f64::from(*SIDES.start()), f64::from(*SIDES.end()));
                within(object, "a prism has 3 to 64 sides", &[f64::from(sides)], low, high)
            }
        }
    }

    /// The engine's shape, and its pose in the part's frame (the engine's cylinders stand along y).
    pub(crate) fn engine(&self, object: &str) -> Result<(SharedShape, EnginePose), SimError> {
        Ok(match *self {
            Shape::Cuboid { half: [x, y, z] } => {
                (SharedShape::cuboid(x as f32, y as f32, z as f32), EnginePose::IDENTITY)
            }
            Shape::Ball { radius } => (SharedShape::ball(radius as f32), EnginePose::IDENTITY),
            Shape::Cylinder { radius, half_height } => {
                let half = std::f32::consts::FRAC_1_SQRT_2;
                let upright = EnginePose::from_rotation(Rotation::from_xyzw(half, 0.0, 0.0, half));
                (SharedShape::cylinder(half_height as f32, radius as f32), upright)
            }
            Shape::Prism { radius, half_height, sides } => {
                let corners: Vec<Vector> = (0..sides)
                    .flat_map(|k| {
                        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(sides));
                        [half_height, -half_height]
                            .map(|z| Vector::new((radius * cosine) as f32, (radius * sine) as f32, z as f32))
                    })
                    .collect();
                let hull = SharedShape::convex_hull(&corners).ok_or_else(|| SimError::BadValue {
                    object: object.to_owned(),
                    what: "a prism must not be flat",
                    value: half_height,
                })?;
                (hull, EnginePose::IDENTITY)
            }
        })
    }
}

/// Err if any value is not within `[low, high]` (a value that is not a number is not).
pub(crate) fn within(object: &str, what: &'static str, values: &[f64], low: f64, high: f64) -> Result<(), SimError> {
    match values.iter().find(|&&v| !(low..=high).contains(&v)) {
        Some(&value) => Err(SimError::BadValue { object: object.to_owned(), what, value }),
        None => Ok(()),
    }
}

/// Err if the pose is not finite or outside the workshop.
pub(crate) fn check_pose(object: &str, pose: &Pose) -> Result<(), SimError> {
    if frame::is_finite(pose) && pose.translation.vector.norm() <= WORKSHOP {
        Ok(())
    } else {
        Err(SimError::BadPose { object: object.to_owned(), limit: WORKSHOP })
    }
}
