//! Magnets: a force that holds one object to its seat on another, until something pulls harder.

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::{PhysicsWorld, RigidBodyHandle};
use serde::{Deserialize, Serialize};

use crate::frame::{Pose, from_engine, to_engine_vector};

/// A lid held by a magnet. While `a` is within `range` of its seat on `b`, it is drawn along −z of the seat with
/// `force`, and `b` the other way.
///
/// Keep the force under 0.7 of the weight of `b`. Else whoever pulls at the lid lifts what it closes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Magnet {
    /// Name of the object that is held.
    pub a: String,
    /// Name of the object it is held to.
    pub b: String,
    /// Pose of `a` in the frame of `b` when it is seated.
    pub seat: Pose,
    /// Newtons.
    pub force: f64,
    /// Distance of the origin of `a` from its seat up to which the magnet draws, metres.
    pub range: f64,
}

/// A magnet between two bodies of the world, by index.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Bond {
    pub(crate) a: usize,
    pub(crate) b: usize,
    pub(crate) magnet: Magnet,
}

impl Bond {
    /// Adds this magnet's forces for the coming step.
    pub(crate) fn pull(&self, physics: &mut PhysicsWorld, a: RigidBodyHandle, b: RigidBodyHandle) {
        let place = from_engine(physics.bodies[a].position());
        let seat = from_engine(physics.bodies[b].position()) * self.magnet.seat;
        let gap = place.translation.vector - seat.translation.vector;
        if gap.norm() >= self.magnet.range {
            return;
        }
        let force = to_engine_vector(&(seat.rotation * Vector3::new(0.0, 0.0, -self.magnet.force)));
        let point = to_engine_vector(&(place * Point3::origin()).coords);
        // A sleeping body keeps still in any case. The force must not wake it: else a body under a magnet would never
        // rest.
        physics.bodies[a].add_force_at_point(force, point, false);
        physics.bodies[b].add_force_at_point(-force, point, false);
    }
}
