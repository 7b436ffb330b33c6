//! Hinges: one object turns about an axis of another, as a door, a lid or a lever does.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, PhysicsWorld, RigidBodyHandle,
};
use serde::{Deserialize, Serialize};

use crate::error::{SimError, within};
use crate::frame::{Pose, from_engine, pose_at, rotation_about, to_engine};
use crate::mechanism::from_x_to;

/// The least and the largest travel of a hinge in radians. The engine knows an angle up to half a turn.
const LEAST_TRAVEL: f64 = 0.01;
const MAX_TRAVEL: f64 = 3.0;
/// The furthest that the axis may be from the parent's origin, metres.
const FURTHEST: f64 = 2.0;
/// The largest friction of a hinge in N·m: more than any hand here can turn.
const MAX_FRICTION: f64 = 100.0;
/// The largest damping in N·m·s.
const MAX_DAMPING: f64 = 1e3;
/// The largest stiffness of the spring in N·m.
const MAX_SPRING: f64 = 1e3;
/// The rate in N·m·s at which dry friction builds up with the rate of turning. It stands for stiction: under a torque
/// that is 0.1 N·m less than the friction, a hinge creeps by 10 µrad/s.
const STICTION: f32 = 1e4;

/// One object turns about an axis of another. Metres, radians, newtons.
///
/// Friction works at any rate and holds the child where it is left. Damping grows with the rate. The spring draws to
/// the start of the range. The two objects do not collide with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hinge {
    /// Name of the object that carries the other.
    pub parent: String,
    /// Name of the object that turns.
    #[serde(rename = "object")]
    pub child: String,
    /// A point of the axis, in the parent's frame, metres.
    pub at: [f64; 3],
    /// The direction of the axis in the parent's frame (any length but zero). Values grow by the right-hand rule.
    pub axis: [f64; 3],
    /// Length of the range, radians: values go from 0 to this.
    pub travel: f64,
    /// The value at which the child is when the hinge is made.
    #[serde(default)]
    pub value: f64,
    /// Dry friction: the least torque that turns the child, N·m.
    pub friction: f64,
    /// Viscous friction, N·m·s.
    #[serde(default)]
    pub damping: f64,
    /// Stiffness of a spring that draws to value 0, N·m for each radian.
    #[serde(default)]
    pub spring: f64,
}

/// A hinge between two bodies of the world.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Pivot {
    /// Index of the object that turns.
    pub(crate) child: usize,
    /// Its body, after that of its parent.
    pub(crate) bodies: [RigidBodyHandle; 2],
    /// Rotation of the child in the parent's frame at value 0.
    seat: UnitQuaternion<f64>,
    /// Unit length, in the parent's frame.
    axis: Vector3<f64>,
    /// What it was built from.
    hinge: Hinge,
}

impl Pivot {
    /// Joins the bodies of a parent and of the child of this index, where they are. None where the engine refuses, as
    /// it does a ring of hinges.
    pub(crate) fn build(
        physics: &mut PhysicsWorld,
        hinge: &Hinge,
        child: usize,
        bodies: [RigidBodyHandle; 2],
    ) -> Option<Pivot> {
        let axis = Vector3::from(hinge.axis).normalize();
        let place = place_on(physics, bodies);
        let seat = hinge.turned(&place, -hinge.value).rotation;
        let pivot = Pivot { child, bodies, seat, axis, hinge: hinge.clone() };
        pivot.join(physics, &place, hinge.value)?;
        if hinge.spring > 0.0 {
            physics.insert_impulse_joint(bodies[0], bodies[1], hinge.spring(&place, &axis));
        }
        Some(pivot)
    }

    /// Joins the bodies, the child at this place on its parent and at this value. None where the engine refuses.
    fn join(&self, physics: &mut PhysicsWorld, place: &Pose, value: f64) -> Option<()> {
        let [parent, child] = self.bodies;
        let handle = physics.insert_multibody_joint(parent, child, self.hinge.pin(place, &self.axis, value))?;
        if let Some((multibody, link)) = physics.multibody_joints.get_mut(handle) {
            let coordinate = multibody.link(link)?.assembly_id();
            multibody.damping_mut()[coordinate] = self.hinge.damping as f32;
        }
        Some(())
    }

    /// Joins the bodies anew where they are, once they have been taken apart.
    pub(crate) fn join_again(&self, physics: &mut PhysicsWorld) {
        let (place, value) = (place_on(physics, self.bodies), self.value(physics).clamp(0.0, self.hinge.travel));
        let joined = self.join(physics, &place, value);
        debug_assert!(joined.is_some(), "what the engine took once it takes again");
    }

    /// Length of the range, radians.
    pub(crate) fn travel(&self) -> f64 {
        self.hinge.travel
    }

    /// The child's turn from the start of its range, in radians within half a turn.
    pub(crate) fn value(&self, physics: &PhysicsWorld) -> f64 {
        let [parent, child] = self.bodies.map(|body| from_engine(physics.bodies[body].position()).rotation);
        let turn = parent.inverse() * child * self.seat.inverse();
        let (along, rest) = (turn.imag().dot(&self.axis), turn.scalar());
        // Two quaternions stand for one rotation: the one that turns by less than half a turn counts.
        2.0 * libm::atan2(along * rest.signum(), rest.abs())
    }
}

/// The child's place in its parent's frame.
fn place_on(physics: &PhysicsWorld, bodies: [RigidBodyHandle; 2]) -> Pose {
    let [frame, place] = bodies.map(|body| from_engine(physics.bodies[body].position()));
    frame.inverse() * place
}

impl Hinge {
    /// A pose in the parent's frame that has been turned about the axis by so many radians.
    pub fn turned(&self, pose: &Pose, angle: f64) -> Pose {
        let turn = rotation_about(self.axis, angle);
        let at = Vector3::from(self.at);
        let place = at + turn * (pose * Point3::origin() - at).coords;
        pose_at(place.into(), turn * pose.rotation)
    }

    /// Says what is wrong with the numbers, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let child = &self.child;
        let length = Vector3::from(self.axis).norm();
        within(child, "a hinge's axis must not be zero", &[length], 1e-6, f64::MAX)?;
        within(child, "a hinge must be within 2 m of its parent's origin", &self.at, -FURTHEST, FURTHEST)?;
        within(child, "a hinge's travel must be 0.01 to 3 rad", &[self.travel], LEAST_TRAVEL, MAX_TRAVEL)?;
        within(child, "a hinge's value must be 0 to its travel", &[self.value], 0.0, self.travel)?;
        within(child, "a hinge's friction must be 0 to 100 N·m", &[self.friction], 0.0, MAX_FRICTION)?;
        within(child, "a hinge's damping must be 0 to 1000 N·m·s", &[self.damping], 0.0, MAX_DAMPING)?;
        within(child, "a hinge's spring must be 0 to 1000 N·m", &[self.spring], 0.0, MAX_SPRING)
    }

    /// The joint of the engine: it turns about its x axis, and its angle is 0 where the child is when it is made.
    ///
    /// It is one of reduced coordinates. The engine's other joints lock five axes by impulses, and these do not
    /// converge with a friction about the sixth: a lid that friction should hold sank by 0.02 rad/s, and a bar slipped
    /// from the fingers.
    fn pin(&self, place: &Pose, axis: &Vector3<f64>, value: f64) -> GenericJoint {
        let limits = [-value, self.travel - value].map(|limit| limit as f32);
        self.joint(JointAxesMask::LOCKED_REVOLUTE_AXES, place, axis)
            .limits(JointAxis::AngX, limits)
            .motor_velocity(JointAxis::AngX, 0.0, STICTION)
            .motor_max_force(JointAxis::AngX, self.friction as f32)
            .build()
    }

    /// The joint of the spring, which has a motor of its own because that of the pin has a limit.
    fn spring(&self, place: &Pose, axis: &Vector3<f64>) -> GenericJoint {
        let joint = self.joint(JointAxesMask::empty(), place, axis);
        joint.set_motor(JointAxis::AngX, -self.value as f32, 0.0, self.spring as f32, 0.0).build()
    }

    /// A joint between the parent and a child at this place in the parent's frame, with x along the axis.
    fn joint(&self, locked: JointAxesMask, place: &Pose, axis: &Vector3<f64>) -> GenericJointBuilder {
        let on_parent = pose_at(self.at, from_x_to(axis));
        let on_child = place.inverse() * on_parent;
        GenericJointBuilder::new(locked)
            .local_frame1(to_engine(&on_parent))
            .local_frame2(to_engine(&on_child))
            .motor_model(JointAxis::AngX, MotorModel::ForceBased)
            .contacts_enabled(false)
    }
}
