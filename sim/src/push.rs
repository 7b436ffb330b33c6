//! Pushes: somebody's unyielding hand moves an object, with what turns on it.

use nalgebra::Vector3;
use rapier3d::math::Vector;
use rapier3d::prelude::{PhysicsWorld, RigidBodyHandle, RigidBodyType};
use serde::{Deserialize, Serialize};

use crate::frame::{Pose, from_engine, to_engine};
use crate::hinge::Pivot;
use crate::object::Mobility;

/// A body that a push carries.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Carried {
    body: RigidBodyHandle,
    start: Pose,
    /// What the body is again afterwards.
    after: RigidBodyType,
}

/// A push under way. The object is carried along a smooth path (fifth-order, at rest at both ends) as if an unyielding
/// hand moved it. What is in it or on it comes along by contact.
///
/// What turns on it is carried at the angle it has, and its hinge is out of the world meanwhile, because the engine
/// does not move the root of a chain of bodies that is neither fixed nor free.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Push {
    pub(crate) object: usize,
    /// The object itself, then what turns on it.
    carried: Vec<Carried>,
    displacement: Vector3<f64>,
    steps: u32,
    done: u32,
}

impl Push {
    /// Takes hold of an object of this body and mobility, and of what turns on it.
    pub(crate) fn begin(
        physics: &mut PhysicsWorld,
        pivots: &[Pivot],
        (object, body, mobility): (usize, RigidBodyHandle, Mobility),
        displacement: Vector3<f64>,
        steps: u32,
    ) -> Push {
        let kind = if mobility == Mobility::Dynamic { RigidBodyType::Dynamic } else { RigidBodyType::Fixed };
        let mut kinds = vec![(body, kind)];
        kinds.extend(turning_on(pivots, body).into_iter().map(|pivot| (pivot.bodies[1], RigidBodyType::Dynamic)));
        physics.multibody_joints.remove_multibody_articulations(body, true);
        let hold = |(handle, after): (RigidBodyHandle, RigidBodyType)| {
            let body = &mut physics.bodies[handle];
            body.set_body_type(RigidBodyType::KinematicPositionBased, true);
            Carried { body: handle, start: from_engine(body.position()), after }
        };
        let carried = kinds.into_iter().map(hold).collect();
        Push { object, carried, displacement, steps: steps.max(1), done: 0 }
    }

    /// Sets the goals of the bodies for the coming step.
    pub(crate) fn drive(&mut self, physics: &mut PhysicsWorld) {
        self.done = (self.done + 1).min(self.steps);
        let s = f64::from(self.done) / f64::from(self.steps);
        let way = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        for carried in &self.carried {
            let mut pose = carried.start;
            pose.translation.vector += self.displacement * way;
            physics.bodies[carried.body].set_next_kinematic_position(to_engine(&pose));
        }
    }

    /// Lets go once the path is done. Returns whether it has.
    ///
    /// A thing that is fixed again, and that something turns on, is out of the world for one step. The engine leaves a
    /// body that was moved among those that it moves, and a chain of bodies whose fixed root is one of these it moved
    /// twice in each step: the lid of a chest that had been pushed went round and round, through its stops.
    pub(crate) fn finish(&self, physics: &mut PhysicsWorld, pivots: &[Pivot]) -> bool {
        if self.done < self.steps {
            return false;
        }
        let Carried { body, after, .. } = self.carried[0];
        if after == RigidBodyType::Fixed && self.carried.len() > 1 {
            let body = &mut physics.bodies[body];
            body.set_enabled(!body.is_enabled());
            if !body.is_enabled() {
                return false;
            }
        }
        for carried in &self.carried {
            let body = &mut physics.bodies[carried.body];
            body.set_body_type(carried.after, true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
        }
        turning_on(pivots, body).into_iter().for_each(|pivot| pivot.join_again(physics));
        true
    }
}

/// What turns on a body, on what turns on it, and so on, each after what it turns on.
fn turning_on(pivots: &[Pivot], body: RigidBodyHandle) -> Vec<&Pivot> {
    let (mut found, mut bodies): (Vec<&Pivot>, _) = (Vec::new(), vec![body]);
    let mut next = 0;
    while let Some(parent) = bodies.get(next).copied() {
        let children: Vec<&Pivot> = pivots.iter().filter(|pivot| pivot.bodies[0] == parent).collect();
        bodies.extend(children.iter().map(|pivot| pivot.bodies[1]));
        found.extend(children);
        next += 1;
    }
    found
}
