//! Convex solids: what objects and the links of the arm are put together from.

use std::ops::RangeInclusive;

use rapier3d::geometry::SharedShape;
use rapier3d::math::{Rotation, Vector};
use rapier3d::prelude::Pose as EnginePose;
use serde::{Deserialize, Serialize};

use crate::check::within;
use crate::error::SimError;

/// The smallest extent of a part in metres: below it single precision and the contact margin stop making sense.
pub(crate) const MIN_SIZE: f64 = 2e-4;
/// The largest extent of a part in metres: the table is not larger.
pub(crate) const MAX_SIZE: f64 = 2.0;
/// The fewest and the most sides of a polygonal prism or a cup.
pub(crate) const SIDES: RangeInclusive<u32> = 3..=64;

/// A convex solid, centred on the origin of its part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
        })
    }
}
