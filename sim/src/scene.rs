//! Setting a scene: what stands on the table, what is in it, what holds it, what carries the hand, and who bumps into
//! it.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rapier3d::geometry::{Group, InteractionGroups};
use rapier3d::prelude::{ColliderBuilder, RigidBodyBuilder};

use crate::arm::{Arm, ArmModel};
use crate::beads::Beads;
use crate::error::{SimError, check_pose, within};
use crate::frame::{Pose, from_engine, to_engine, to_engine_vector};
use crate::hand::Guard;
use crate::hinge::{Hinge, Pivot};
use crate::mechanism::{Bond, Guide, Magnet, Slide};
use crate::object::{Mobility, Object};
use crate::push::Push;
use crate::rolling::Roller;
use crate::step::DT;
use crate::tag::{ARM, HAND, TABLE, Tag};
use crate::world::{Entry, LENGTH_UNIT, World};

/// A heap of beads that are all slower than this, m/s, for [`BEADS_REST_AFTER`] rests until something touches it. By
/// then it lies within a millimetre of where it would come to lie, and it costs nothing.
const BEADS_REST_BELOW: f32 = 4e-3;
/// How long a heap of beads has to be slow before it rests, seconds.
const BEADS_REST_AFTER: f32 = 0.25;
/// How long beads are left to come to rest after they have been put in, seconds.
const FILL_SETTLE: f64 = 0.5;
/// What messages about scattered beads are about.
const BEADS: &str = "beads";
/// The most iterations of the solver in a step.
const MOST_ITERATIONS: usize = 64;

impl World {
    /// Puts an object into the world, at rest. `pose` is that of its frame (see [`Object`]).
    ///
    /// # Errors
    /// The name is taken (`table`, `hand` and `arm` always are), the pose is not finite or more than 5 m away, or a
    /// dimension or a property of the material is impossible.
    pub fn add(&mut self, object: Object, pose: Pose) -> Result<(), SimError> {
        if [TABLE, HAND, ARM].contains(&object.name.as_str()) || self.names.contains_key(&object.name) {
            return Err(SimError::DuplicateName { object: object.name });
        }
        object.check()?;
        check_pose(&object.name, &pose)?;
        let index = self.entries.len();
        let colliders = object
            .parts
            .iter()
            .map(|part| {
                let (shape, upright) = part.shape.engine(&object.name)?;
                let collider = ColliderBuilder::new(shape)
                    .position(to_engine(&part.pose) * upright)
                    .density(part.density as f32)
                    .friction(part.friction as f32)
                    .user_data(Tag::Object(index).encode());
                Ok(if part.solid { collider } else { collider.collision_groups(no_groups()).density(0.0) })
            })
            .collect::<Result<Vec<_>, SimError>>()?;
        let body = match object.mobility {
            Mobility::Fixed => RigidBodyBuilder::fixed(),
            Mobility::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let body = self.physics.insert_body(body.pose(to_engine(&pose)));
        for collider in colliders {
            self.physics.insert_collider(collider, Some(body));
        }
        if let Some(rolling) = object.rolling.filter(|rolling| rolling.friction > 0.0) {
            self.rollers.push(Roller { body, radius: rolling.radius, friction: rolling.friction });
        }
        self.names.insert(object.name.clone(), index);
        self.entries.push(Entry { object, body });
        Ok(())
    }

    /// Puts beads into a container, in layers from its floor up, and lets half a second pass until they have settled.
    ///
    /// # Errors
    /// There is no such object, it has no interior, the beads do not fit below its rim, or a property of theirs is
    /// impossible.
    pub fn fill(&mut self, container: &str, beads: &Beads) -> Result<(), SimError> {
        let entry = &self.entries[self.index(container)?];
        let Some(interior) = entry.object.container else {
            return Err(SimError::NoInterior { object: container.to_owned() });
        };
        let pose = from_engine(self.physics.bodies[entry.body].position());
        let centers = beads.layout(container, &interior)?;
        let centers = centers.into_iter().map(|center| (pose * Point3::from(center)).coords);
        self.put_beads(beads, centers);
        self.settle(FILL_SETTLE);
        Ok(())
    }

    /// Puts one bead at each of these centres (metres, world frame), at rest; no time passes. `count` is not heeded,
    /// and nothing checks whether anything else is there.
    ///
    /// # Errors
    /// A centre is not finite or more than 5 m away, or a property of the beads is impossible.
    pub fn scatter(&mut self, beads: &Beads, centers: &[[f64; 3]]) -> Result<(), SimError> {
        beads.check(BEADS)?;
        centers.iter().try_for_each(|&[x, y, z]| check_pose(BEADS, &Pose::translation(x, y, z)))?;
        self.put_beads(beads, centers.iter().map(|&center| center.into()));
        Ok(())
    }

    /// One bead at each centre in the world.
    fn put_beads(&mut self, beads: &Beads, centers: impl Iterator<Item = Vector3<f64>>) {
        for center in centers {
            let body = RigidBodyBuilder::dynamic()
                .translation(to_engine_vector(&center))
                .angular_damping(beads.angular_damping as f32);
            let ball = ColliderBuilder::ball(beads.radius as f32)
                .density(beads.density as f32)
                .friction(beads.friction as f32)
                .user_data(Tag::Bead.encode());
            let (body, _) = self.physics.insert(body, ball);
            let activation = self.physics.bodies[body].activation_mut();
            activation.normalized_linear_threshold = BEADS_REST_BELOW / LENGTH_UNIT;
            activation.time_until_sleep = BEADS_REST_AFTER;
            self.beads.push(body);
        }
    }

    /// Adds a magnet between two objects.
    ///
    /// # Errors
    /// One of the objects does not exist, or force, range or seat are impossible.
    pub fn magnet(&mut self, magnet: Magnet) -> Result<(), SimError> {
        let (a, b) = (self.index(&magnet.a)?, self.index(&magnet.b)?);
        within(&magnet.a, "a magnet's force must be 0 to 100 N", &[magnet.force], 0.0, 100.0)?;
        within(&magnet.a, "a magnet's range must be 0 to 0.1 m", &[magnet.range], 0.0, 0.1)?;
        check_pose(&magnet.a, &magnet.seat)?;
        self.bonds.push(Bond { a, b, magnet });
        Ok(())
    }

    /// Lets one object slide along an axis of another. The child stays where it is: that place is `value` of the slide.
    ///
    /// # Errors
    /// One of the objects does not exist, they are the same, the child is fixed or slides already, or a number is
    /// impossible.
    pub fn slide(&mut self, slide: &Slide) -> Result<(), SimError> {
        let (parent, child) = (self.index(&slide.parent)?, self.index(&slide.child)?);
        slide.check()?;
        if !self.may_be_joined(parent, child) {
            return Err(SimError::NoSlide { object: slide.child.clone() });
        }
        let bodies = [parent, child].map(|index| self.entries[index].body);
        self.guides.push(Guide::build(&mut self.physics, slide, child, bodies));
        Ok(())
    }

    /// Lets one object turn about an axis of another. The child stays where it is: that place is `value` of the hinge.
    ///
    /// # Errors
    /// One of the objects does not exist, they are the same, the child is fixed or slides or turns already, or a number
    /// is impossible.
    pub fn hinge(&mut self, hinge: &Hinge) -> Result<(), SimError> {
        let (parent, child) = (self.index(&hinge.parent)?, self.index(&hinge.child)?);
        hinge.check()?;
        if !self.may_be_joined(parent, child) {
            return Err(SimError::NoHinge { object: hinge.child.clone() });
        }
        let bodies = [parent, child].map(|index| self.entries[index].body);
        let pivot = Pivot::build(&mut self.physics, hinge, child, bodies);
        self.pivots.push(pivot.ok_or_else(|| SimError::NoHinge { object: hinge.child.clone() })?);
        Ok(())
    }

    /// Somebody bumps into an object: during the next `seconds` it slides by `displacement` (metres, world frame),
    /// whatever stands in the way.
    ///
    /// What is in it comes along, and so does what turns on it, which keeps its angle meanwhile. A push replaces one
    /// that is under way for the same object.
    ///
    /// # Errors
    /// There is no such object, it turns on a hinge, the displacement leads out of the workshop, or the duration is not
    /// between 0.01 and 60 s.
    pub fn push(&mut self, object: &str, displacement: [f64; 3], seconds: f64) -> Result<(), SimError> {
        let index = self.index(object)?;
        if self.pivots.iter().any(|pivot| pivot.child == index) {
            return Err(SimError::NoPush { object: object.to_owned() });
        }
        within(object, "a push must take 0.01 to 60 s", &[seconds], 0.01, 60.0)?;
        let entry = &self.entries[index];
        let displacement = Vector3::from(displacement);
        let mut end = from_engine(self.physics.bodies[entry.body].position());
        end.translation.vector += displacement;
        check_pose(object, &end)?;
        self.pushes.retain(|push| push.object != index);
        let steps = libm::round(seconds / DT) as u32;
        let pushed = (index, entry.body, entry.object.mobility);
        let push = Push::begin(&mut self.physics, &self.pivots, pushed, displacement, steps);
        self.pushes.push(push);
        Ok(())
    }

    /// Whether an object moves, is another than its parent, and has neither slide nor hinge.
    fn may_be_joined(&self, parent: usize, child: usize) -> bool {
        let slides = self.guides.iter().map(|guide| guide.child);
        let mut joined = slides.chain(self.pivots.iter().map(|pivot| pivot.child));
        parent != child
            && !joined.any(|other| other == child)
            && self.entries[child].object.mobility == Mobility::Dynamic
    }

    /// Mounts an arm that carries the hand, from now on: motions keep to what it can reach and go round what it would
    /// run into. `seed` is that of its planner.
    ///
    /// # Errors
    /// There is an arm already, a shell of the model is impossible, or the hand is out of the arm's reach.
    pub fn mount(&mut self, model: Arc<ArmModel>, seed: u64) -> Result<(), SimError> {
        if self.arm.is_some() {
            return Err(SimError::Arm { reason: "there is an arm already".to_owned() });
        }
        self.arm = Some(Arm::build(&mut self.physics, model, self.hand.target(), seed)?);
        Ok(())
    }

    /// Puts the hand elsewhere at once, at rest, the pads `opening` metres apart (clamped to what it can do).
    ///
    /// It is meant for setting a scene, before an arm is mounted: nothing checks whether something is in the way. The
    /// call is ignored where the target is not finite or further than 5 m away, and where there is an arm.
    pub fn place_gripper(&mut self, tcp: Pose, opening: f64) {
        if check_pose(HAND, &tcp).is_ok() && opening.is_finite() && self.arm.is_none() {
            self.hand.place(&mut self.physics, tcp, opening);
        }
    }

    /// The forces at which a motion of the hand ends early, from now on.
    ///
    /// # Errors
    /// They are not more than 0, not finite, or the guard is above the limit of the abort.
    pub fn set_guard(&mut self, guard: Guard) -> Result<(), SimError> {
        guard.check()?;
        self.guard = guard;
        Ok(())
    }

    /// Iterations of the solver in a step from now on, clamped to 1 to 64.
    ///
    /// The default of 4 is right for what lies about. It does not converge where the hand squeezes something on a
    /// slide: a squeeze of 10 N on the fin of a drawer comes out as up to 25 N on either finger, with 16 iterations as
    /// up to 15 N. Only a scene of few contacts can bear the cost.
    pub fn set_solver_iterations(&mut self, iterations: usize) {
        self.physics.integration_parameters.num_solver_iterations = iterations.clamp(1, MOST_ITERATIONS);
    }
}

/// Collides with nothing.
fn no_groups() -> InteractionGroups {
    InteractionGroups::none().with_memberships(Group::NONE)
}
