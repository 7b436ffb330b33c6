//! What stands on the table: a named body made of convex parts, perhaps with room inside.

use std::ops::RangeInclusive;
use std::sync::Arc;

use rapier3d::geometry::SharedShape;
use rapier3d::math::{Rotation, Vector};
use rapier3d::prelude::Pose as EnginePose;
use serde::{Deserialize, Serialize};

use crate::error::{SimError, check_pose, within};
use crate::frame::{Pose, pose_at};
use crate::symmetry::Symmetry;

/// The most parts that an object may have: a cup of 64 walls with floor and handle.
const MAX_PARTS: usize = 72;

/// Whether an object can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mobility {
    /// It stays where it is put.
    Fixed,
    /// It moves by forces.
    Dynamic,
}

/// The outline of an object in its frame: what it takes to say that another object is on it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Height of the upper face above the origin, in metres: a rim, the plate of a cover, the top of a block.
    pub top: f64,
    /// Radius of the circle about the z axis that holds the object without its handle, in metres.
    pub reach: f64,
}

/// A named body on the table. A [`crate::Shape`] makes one.
///
/// The frame's origin is at the *centre* of blocks, cylinders and balls, at the centre of the *base* of containers,
/// furniture and marks, and at the centre of the *underside of the flange or plate* of lids and covers. So a keyframe
/// relative to an object says how high above its base, not above its rim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name, unique in the world.
    pub name: String,
    /// Whether it can be moved.
    pub mobility: Mobility,
    /// The convex pieces it is made of.
    pub parts: Vec<Part>,
    /// Its colour in pictures: red, green, blue.
    pub color: [u8; 3],
    /// The room inside, if it is a container.
    pub container: Option<Interior>,
    /// What another object can be on.
    pub outline: Outline,
    /// What keeps it from rolling for ever, if something does. It is a ball, then.
    pub rolling: Option<Rolling>,
    /// The turns after which it looks as before, if there are some.
    pub symmetry: Option<Symmetry>,
}

/// How a ball rolls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rolling {
    /// Radius of the ball in metres.
    pub radius: f64,
    /// Coefficient of rolling friction, without unit: a contact that presses with the force N resists with a torque of
    /// up to this times N times the radius.
    pub friction: f64,
}

impl Object {
    /// A brick-red object that moves by forces and is no container.
    pub fn new(name: impl Into<String>, parts: Vec<Part>, outline: Outline) -> Object {
        let (mobility, color) = (Mobility::Dynamic, [201, 76, 60]);
        Object { name: name.into(), mobility, parts, color, container: None, outline, rolling: None, symmetry: None }
    }

    /// The same object in another colour.
    pub fn with_color(self, color: [u8; 3]) -> Object {
        Object { color, ..self }
    }

    /// The same object as a container.
    pub fn with_room(self, room: Interior) -> Object {
        Object { container: Some(room), ..self }
    }

    /// The same object of other material: all densities and all coefficients of friction times these factors. The
    /// coefficient of rolling friction stays.
    pub fn with_material(self, density: f64, friction: f64) -> Object {
        let scaled = |part: Part| Part { density: density * part.density, friction: friction * part.friction, ..part };
        Object { parts: self.parts.into_iter().map(scaled).collect(), ..self }
    }

    /// The same object as a ball that does not roll for ever.
    pub fn with_rolling(self, rolling: Rolling) -> Object {
        Object { rolling: Some(rolling), ..self }
    }

    /// The same object, known to look as before after some turns.
    pub fn with_symmetry(self, symmetry: Symmetry) -> Object {
        Object { symmetry: Some(symmetry), ..self }
    }

    /// The same object, immovable: a stand, a bin screwed to the table.
    pub fn fixed(self) -> Object {
        Object { mobility: Mobility::Fixed, ..self }
    }

    /// Says what is wrong with the description, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let refuse = |what, value| Err(SimError::BadValue { object: self.name.clone(), what, value });
        let count = self.parts.len();
        if !(1..=MAX_PARTS).contains(&count) {
            return refuse("it must have 1 to 72 parts (a cup has 3 to 64 sides)", count as f64);
        }
        self.parts.iter().try_for_each(|part| part.check(&self.name))?;
        if self.mobility == Mobility::Dynamic && !self.parts.iter().any(|part| part.solid && part.density > 0.0) {
            return refuse("a dynamic object needs a solid part of positive density", 0.0);
        }
        if let Some(Rolling { radius, friction }) = &self.rolling {
            within(&self.name, "a ball's radius must be 0.0002 m to 2 m", &[*radius], MIN_SIZE, MAX_SIZE)?;
            within(&self.name, "rolling friction must be 0 to 1", &[*friction], 0.0, MAX_ROLLING)?;
        }
        self.symmetry.map_or(Ok(()), |symmetry| symmetry.check(&self.name))?;
        self.container.as_ref().map_or(Ok(()), |interior| interior.check(&self.name))
    }
}

/// The largest density in kg/m³ (osmium is 22 590).
const MAX_DENSITY: f64 = 3e4;
/// The largest coefficient of friction (rubber on rubber is about 2).
const MAX_FRICTION: f64 = 5.0;

/// The largest coefficient of rolling friction. A ball with more would rather slip: 1 is what a cube has on its edge.
const MAX_ROLLING: f64 = 1.0;

/// One convex piece of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its solid.
    pub shape: Convex,
    /// Its pose in the object's frame.
    pub pose: Pose,
    /// kg/m³.
    pub density: f64,
    /// Coefficient of friction. Two surfaces in contact rub with the mean of theirs.
    pub friction: f64,
    /// Whether other things collide with it. A mark on the table does not.
    pub solid: bool,
}

impl Part {
    /// A solid part.
    pub fn new(shape: Convex, pose: Pose, density: f64, friction: f64) -> Part {
        Part { shape, pose, density, friction, solid: true }
    }

    /// A solid cuboid of these half extents, centred at `at`, its edges along the frame's axes.
    pub(crate) fn cuboid(half: [f64; 3], at: [f64; 3], density: f64, friction: f64) -> Part {
        Part::new(Convex::Cuboid { half }, pose_at(at, Default::default()), density, friction)
    }

    /// Says what is wrong with the part, if anything.
    pub(crate) fn check(&self, object: &str) -> Result<(), SimError> {
        self.shape.check(object)?;
        within(object, "density must be 0 to 30000 kg/m³", &[self.density], 0.0, MAX_DENSITY)?;
        within(object, "friction must be 0 to 5", &[self.friction], 0.0, MAX_FRICTION)?;
        check_pose(object, &self.pose)
    }
}

/// The smallest extent of a part in metres: below it single precision and the contact margin stop making sense.
pub(crate) const MIN_SIZE: f64 = 2e-4;
/// The largest extent of a part in metres: the table is not larger.
pub(crate) const MAX_SIZE: f64 = 2.0;
/// The fewest and the most sides of a polygonal prism or a cup.
pub(crate) const SIDES: RangeInclusive<u32> = 3..=64;

/// A convex solid, centred on the origin of its part unless it is a hull.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Convex {
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
    /// The convex hull of points.
    Hull {
        /// The points, in the part's frame, metres.
        corners: Arc<[[f64; 3]]>,
    },
}

impl Convex {
    /// Says what is wrong with the dimensions, if anything.
    pub(crate) fn check(&self, object: &str) -> Result<(), SimError> {
        let rule = "sizes of parts must be 0.0002 m to 2 m";
        match *self {
            Convex::Cuboid { half } => within(object, rule, &half, MIN_SIZE, MAX_SIZE),
            Convex::Cylinder { radius, half_height } => {
                within(object, rule, &[radius, half_height], MIN_SIZE, MAX_SIZE)
            }
            Convex::Ball { radius } => within(object, rule, &[radius], MIN_SIZE, MAX_SIZE),
            Convex::Prism { radius, half_height, sides } => {
                within(object, rule, &[radius, half_height], MIN_SIZE, MAX_SIZE)?;
                let (low, high) = (f64::from(*SIDES.start()), f64::from(*SIDES.end()));
                within(object, "a prism has 3 to 64 sides", &[f64::from(sides)], low, high)
            }
            Convex::Hull { ref corners } => {
                within(object, "corners of a hull must be within 2 m", corners.as_flattened(), -MAX_SIZE, MAX_SIZE)
            }
        }
    }

    /// The engine's shape, and its pose in the part's frame (the engine's cylinders stand along y).
    pub(crate) fn engine(&self, object: &str) -> Result<(SharedShape, EnginePose), SimError> {
        Ok(match *self {
            Convex::Cuboid { half: [x, y, z] } => {
                (SharedShape::cuboid(x as f32, y as f32, z as f32), EnginePose::IDENTITY)
            }
            Convex::Ball { radius } => (SharedShape::ball(radius as f32), EnginePose::IDENTITY),
            Convex::Cylinder { radius, half_height } => {
                let half = std::f32::consts::FRAC_1_SQRT_2;
                let upright = EnginePose::from_rotation(Rotation::from_xyzw(half, 0.0, 0.0, half));
                (SharedShape::cylinder(half_height as f32, radius as f32), upright)
            }
            Convex::Prism { radius, half_height, sides } => {
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
            Convex::Hull { ref corners } => {
                let points: Vec<Vector> =
                    corners.iter().map(|&[x, y, z]| Vector::new(x as f32, y as f32, z as f32)).collect();
                let hull = SharedShape::convex_hull(&points).ok_or_else(|| SimError::BadValue {
                    object: object.to_owned(),
                    what: "a hull must not be flat",
                    value: points.len() as f64,
                })?;
                (hull, EnginePose::IDENTITY)
            }
        })
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

    /// Whether a point in the container's frame is between the walls, above the floor and at most `above_rim` metres
    /// above the rim.
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

    /// Says what is wrong with the dimensions, if anything.
    pub(crate) fn check(&self, object: &str) -> Result<(), SimError> {
        let sizes = match *self {
            Interior::Cone { bottom_radius, top_radius, floor, height } => [bottom_radius, top_radius, height - floor],
            Interior::Box { half_x, half_y, floor, height } => [half_x, half_y, height - floor],
        };
        within(object, "inner sizes must be 0.0002 m to 2 m", &sizes, MIN_SIZE, MAX_SIZE)
    }
}
