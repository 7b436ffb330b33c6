//! What acts on objects besides the hand: magnets and slides.

use nalgebra::{Point3, Quaternion, Unit, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, PhysicsWorld, RigidBodyHandle,
};
use serde::{Deserialize, Serialize};

use crate::error::{SimError, within};
use crate::frame::{Pose, from_engine, to_engine, to_engine_vector};

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

/// The longest travel of a slide in metres.
const MAX_TRAVEL: f64 = 1.0;
/// The largest friction of a slide in newtons: more than any hand here can pull.
const MAX_FRICTION: f64 = 1e3;
/// The largest damping in N·s/m.
const MAX_DAMPING: f64 = 1e4;
/// The largest stiffness of the spring in N/m.
const MAX_SPRING: f64 = 1e5;
/// The rate in N·s/m at which dry friction builds up with speed. It stands for stiction: under a load that is 1 N less
/// than the friction, a slide creeps by 1 µm/s.
const STICTION: f32 = 1e6;

/// One object slides along an axis of another. Metres, newtons.
///
/// Friction works at any speed and holds the child where it is left. Damping grows with the speed. The spring draws to
/// the start of the range. The two objects do not collide with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slide {
    /// Name of the object that carries the other.
    pub parent: String,
    /// Name of the object that slides.
    #[serde(rename = "object")]
    pub child: String,
    /// The direction of growing values, in the parent's frame (any length but zero).
    pub axis: [f64; 3],
    /// Length of the range: values go from 0 to this.
    pub travel: f64,
    /// The value at which the child is when the slide is made.
    #[serde(default)]
    pub value: f64,
    /// Dry friction: the least force that moves the child.
    pub friction: f64,
    /// Viscous friction, N·s/m.
    #[serde(default)]
    pub damping: f64,
    /// Stiffness of a spring that draws to value 0, N/m.
    #[serde(default)]
    pub spring: f64,
}

/// A slide between two bodies of the world.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Guide {
    /// Index of the object that slides.
    pub(crate) child: usize,
    /// Its body, after that of its parent.
    bodies: [RigidBodyHandle; 2],
    /// Pose of the child in the parent's frame at value 0.
    seat: Pose,
    /// Unit length, in the parent's frame.
    axis: Vector3<f64>,
    /// Length of the range, metres.
    pub(crate) travel: f64,
}

impl Guide {
    /// Joins the bodies of a parent and of the child of this index, where they are.
    pub(crate) fn build(
        physics: &mut PhysicsWorld,
        slide: &Slide,
        child: usize,
        bodies: [RigidBodyHandle; 2],
    ) -> Guide {
        let axis = Vector3::from(slide.axis).normalize();
        let [frame, place] = bodies.map(|body| from_engine(physics.bodies[body].position()));
        let mut seat = frame.inverse() * place;
        seat.translation.vector -= axis * slide.value;
        for joint in slide.engine(&seat, &axis) {
            physics.insert_impulse_joint(bodies[0], bodies[1], joint);
        }
        Guide { child, bodies, seat, axis, travel: slide.travel }
    }

    /// The child's way from the start of its range, in metres.
    pub(crate) fn value(&self, physics: &PhysicsWorld) -> f64 {
        let [parent, child] = self.bodies.map(|body| from_engine(physics.bodies[body].position()));
        let place = parent.inverse() * child;
        (place.translation.vector - self.seat.translation.vector).dot(&self.axis)
    }
}

impl Slide {
    /// Says what is wrong with the numbers, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let child = &self.child;
        let length = Vector3::from(self.axis).norm();
        within(child, "a slide's axis must not be zero", &[length], 1e-6, f64::MAX)?;
        within(child, "a slide's travel must be 0.001 to 1 m", &[self.travel], 1e-3, MAX_TRAVEL)?;
        within(child, "a slide's value must be 0 to its travel", &[self.value], 0.0, self.travel)?;
        within(child, "a slide's friction must be 0 to 1000 N", &[self.friction], 0.0, MAX_FRICTION)?;
        within(child, "a slide's damping must be 0 to 10000 N·s/m", &[self.damping], 0.0, MAX_DAMPING)?;
        within(child, "a slide's spring must be 0 to 100000 N/m", &[self.spring], 0.0, MAX_SPRING)
    }

    /// The joints of the engine that make up the slide, with x along its axis. A joint of the engine has one motor for
    /// each axis, and a motor has one limit. Friction is limited, spring and damper are not, so there are two joints.
    fn engine(&self, seat: &Pose, axis: &Vector3<f64>) -> Vec<GenericJoint> {
        let turn = from_x_to(axis);
        let on_parent = Pose::from_parts(seat.translation, turn);
        let on_child = Pose::from_parts(Default::default(), seat.rotation.inverse() * turn);
        let joint = |locked| {
            GenericJointBuilder::new(locked)
                .local_frame1(to_engine(&on_parent))
                .local_frame2(to_engine(&on_child))
                .motor_model(JointAxis::LinX, MotorModel::ForceBased)
                .contacts_enabled(false)
        };
        let rail = joint(JointAxesMask::LOCKED_PRISMATIC_AXES)
            .limits(JointAxis::LinX, [0.0, self.travel as f32])
            .motor_velocity(JointAxis::LinX, 0.0, STICTION)
            .motor_max_force(JointAxis::LinX, self.friction as f32);
        let damper =
            joint(JointAxesMask::empty()).set_motor(JointAxis::LinX, 0.0, 0.0, self.spring as f32, self.damping as f32);
        let has_damper = self.spring > 0.0 || self.damping > 0.0;
        std::iter::once(rail).chain(has_damper.then_some(damper)).map(GenericJointBuilder::build).collect()
    }
}

/// The shortest turn from the x axis to a direction of unit length.
pub(crate) fn from_x_to(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    /// Within this of −x the axis of the turn has no direction to speak of. Any axis across x will do.
    const OPPOSITE: f64 = 1e-9;
    if 1.0 + axis.x < OPPOSITE {
        return Unit::new_unchecked(Quaternion::new(0.0, 0.0, 0.0, 1.0));
    }
    Unit::new_normalize(Quaternion::from_parts(1.0 + axis.x, Vector3::x().cross(axis)))
}
