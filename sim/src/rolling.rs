//! Rolling friction: the torque that a surface sets against a ball that rolls on it. The engine has none.
//!
//! A contact that presses with the normal force N can resist rolling with a torque of up to μ N r, where r is the
//! ball's radius and μ its coefficient of rolling friction, a number without unit. On a level plane a solid ball that
//! rolls without slipping slows down by 5/7 μ g, and on a slope of less than atan(μ) it stays where it is. The torque
//! acts on the ball, and its opposite on what the ball rolls on. It is no friction against spinning about the normal.
//!
//! Two things are approximate. The normal forces are those of the step before. Where several things touch the ball,
//! they resist together, with the sum of their limits, about the mean of their normals.

use nalgebra::Vector3;
use rapier3d::prelude::{PhysicsWorld, RigidBodyHandle};
use serde::{Deserialize, Serialize};

use crate::frame::{from_engine_vector, to_engine_vector};
use crate::step::DT;

/// The moment of inertia of a solid ball about its middle, in m r².
const INERTIA: f64 = 0.4;
/// Where the normal forces cancel each other down to less than this part of their sum, as between two fingers, no
/// direction is the normal. Then all turning counts as rolling.
const ONE_SIDED: f64 = 0.5;

/// A ball that does not roll for ever.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Roller {
    pub(crate) body: RigidBodyHandle,
    /// Metres.
    pub(crate) radius: f64,
    /// Coefficient of rolling friction.
    pub(crate) friction: f64,
}

/// A thing that touches a ball: the force with which it presses on the ball, newtons.
struct Support {
    body: Option<RigidBodyHandle>,
    force: Vector3<f64>,
}

impl Roller {
    /// Adds the torques of the coming step. Returns the bodies that have them, for [`release`].
    pub(crate) fn resist(&self, physics: &mut PhysicsWorld) -> Vec<RigidBodyHandle> {
        let body = &physics.bodies[self.body];
        if body.is_sleeping() || !body.is_dynamic() {
            return Vec::new();
        }
        let supports = self.supports(physics);
        let pressed: f64 = supports.iter().map(|support| support.force.norm()).sum();
        if pressed <= 0.0 {
            return Vec::new();
        }
        let limit = self.friction * pressed * self.radius;
        let torque = self.torque(physics, &supports, pressed, limit);
        let mut turned = vec![self.body];
        physics.bodies[self.body].add_torque(to_engine_vector(&torque), false);
        for Support { body, force } in supports {
            let Some(other) = body.filter(|other| physics.bodies[*other].is_dynamic()) else { continue };
            let share = -torque * (force.norm() / pressed);
            physics.bodies[other].add_torque(to_engine_vector(&share), false);
            turned.push(other);
        }
        turned
    }

    /// What presses on the ball.
    fn supports(&self, physics: &PhysicsWorld) -> Vec<Support> {
        let colliders = physics.bodies[self.body].colliders();
        let pairs = colliders.iter().flat_map(|&own| physics.contact_pairs_with(own).map(move |pair| (own, pair)));
        let active = pairs.filter(|(_, pair)| pair.has_any_active_contact());
        active
            .map(|(own, pair)| {
                let (other, sign) = if pair.collider1 == own { (pair.collider2, -1.0) } else { (pair.collider1, 1.0) };
                let force = from_engine_vector(pair.total_impulse()) * (sign / DT);
                Support { body: physics.colliders[other].parent(), force }
            })
            .collect()
    }

    /// The torque that would bring the rolling to an end within the step, or as much of it as the limit allows: N·m.
    fn torque(&self, physics: &PhysicsWorld, supports: &[Support], pressed: f64, limit: f64) -> Vector3<f64> {
        let ball = &physics.bodies[self.body];
        let mass = f64::from(ball.mass());
        let carried = supports.iter().fold(Vector3::zeros(), |sum: Vector3<f64>, Support { body, force }| {
            let turning = body.map_or(Vector3::zeros(), |body| from_engine_vector(physics.bodies[body].angvel()));
            sum + turning * (force.norm() / pressed)
        });
        let mut turning = from_engine_vector(ball.angvel()) - carried;
        let total: Vector3<f64> = supports.iter().map(|support| support.force).sum();
        let mut drawn = Vector3::zeros();
        if total.norm() > ONE_SIDED * pressed {
            let normal = total.normalize();
            turning -= normal * turning.dot(&normal);
            // What gravity adds during the step, about the point of contact.
            drawn = (normal * self.radius).cross(&(from_engine_vector(physics.gravity) * mass));
        }
        // About the point of contact a ball turns with its own inertia and with that of its way.
        let inertia = (INERTIA + 1.0) * mass * self.radius * self.radius;
        let stopping = -(turning * (inertia / DT) + drawn);
        stopping.cap_magnitude(limit)
    }
}

/// Takes the torques of a step that is over away again.
pub(crate) fn release(physics: &mut PhysicsWorld, turned: &[RigidBodyHandle]) {
    for &body in turned {
        physics.bodies[body].reset_torques(false);
    }
}
