//! A push: somebody bumps into an object, which slides some way over the table.

use nalgebra::Vector3;
use rapier3d::math::Vector;
use rapier3d::prelude::{PhysicsWorld, RigidBodyHandle, RigidBodyType};
use serde::{Deserialize, Serialize};

use crate::frame::{Pose, from_engine, to_engine};

/// A push under way. The object is carried along a smooth path (fifth-order, at rest at both ends) as if an unyielding
/// hand moved it. What is in it or on it comes along by contact.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Push {
    pub(crate) object: usize,
    start: Pose,
    displacement: Vector3<f64>,
    steps: u32,
    done: u32,
    /// Whether the object moves freely again afterwards.
    dynamic: bool,
}

impl Push {
    /// Takes hold of the body.
    pub(crate) fn begin(
        physics: &mut PhysicsWorld,
        object: usize,
        body: RigidBodyHandle,
        displacement: Vector3<f64>,
        steps: u32,
        dynamic: bool,
    ) -> Push {
        let body = &mut physics.bodies[body];
        let start = from_engine(body.position());
        body.set_body_type(RigidBodyType::KinematicPositionBased, true);
        Push { object, start, displacement, steps: steps.max(1), done: 0, dynamic }
    }

    /// Sets the body's goal for the coming step.
    pub(crate) fn drive(&mut self, physics: &mut PhysicsWorld, body: RigidBodyHandle) {
        self.done += 1;
        let s = f64::from(self.done) / f64::from(self.steps);
        let way = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let mut pose = self.start;
        pose.translation.vector += self.displacement * way;
        physics.bodies[body].set_next_kinematic_position(to_engine(&pose));
    }

    /// Lets go once the path is done. Returns whether it is.
    pub(crate) fn finish(&self, physics: &mut PhysicsWorld, body: RigidBodyHandle) -> bool {
        if self.done < self.steps {
            return false;
        }
        let kind = if self.dynamic { RigidBodyType::Dynamic } else { RigidBodyType::Fixed };
        let body = &mut physics.bodies[body];
        body.set_body_type(kind, true);
        body.set_linvel(Vector::ZERO, true);
        body.set_angvel(Vector::ZERO, true);
        true
    }
}
