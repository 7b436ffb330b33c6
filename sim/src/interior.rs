//! The room inside a container.

use serde::{Deserialize, Serialize};

use crate::check::within;
use crate::convex::{MAX_SIZE, MIN_SIZE};
use crate::error::SimError;

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
