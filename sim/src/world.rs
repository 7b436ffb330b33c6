//! The world: a table, objects, beads and a hand, advanced in steps of 1/240 s.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::geometry::{Group, InteractionGroups};
use rapier3d::prelude::{
    ColliderBuilder, ColliderHandle, IntegrationParameters, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SpringCoefficients, Vector,
};
use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::beads::Beads;
use crate::check::{check_pose, within};
use crate::error::SimError;
use crate::frame::{self, Pose, from_engine, to_engine, to_engine_vector};
use crate::hand::{Gripper, Hand};
use crate::magnet::{Bond, Magnet};
use crate::object::{Motion, Object};
use crate::planner::Guard;
use crate::push::Push;
use crate::route::Place;
use crate::slide::Guide;

/// Duration of a step in seconds. At 120 Hz a full pitcher slips 10 mm in the hand.
pub const DT: f64 = 1.0 / 240.0;
/// The name by which [`World::touching`] knows the table.
pub const TABLE: &str = "table";
/// The name by which [`World::touching`] knows the hand.
pub const HAND: &str = "hand";
/// The name by which [`World::touching`] knows the arm.
pub const ARM: &str = "arm";

/// Metres per second per second.
const GRAVITY: f32 = 9.81;
/// Typical size of things in metres, which scales the engine's tolerances; with 1 m beads tunnel and spill.
const LENGTH_UNIT: f32 = 0.02;
/// A heap of beads that are all slower than this, m/s…
const BEADS_REST_BELOW: f32 = 4e-3;
/// …for so long, seconds, rests until something touches it: within a millimetre it lies where it would come to lie, and costs nothing.
const BEADS_REST_AFTER: f32 = 0.25;
/// Natural frequency in Hz of contacts between movable bodies.
const CONTACT_FREQUENCY: f32 = 240.0;
/// Natural frequency in Hz of contacts with fixed bodies.
const STATIC_CONTACT_FREQUENCY: f32 = 480.0;
/// Damping ratio of contacts.
const CONTACT_DAMPING: f32 = 5.0;
/// Iterations of the solver in a step; 8 bring little, but see [`World::set_solver_iterations`].
const SOLVER_ITERATIONS: usize = 4;
/// The most iterations of the solver in a step.
const MOST_ITERATIONS: usize = 64;
/// Half extents of the table in metres: wide enough that a spilled bead comes to rest on it.
const TABLE_HALF: [f32; 3] = [1.5, 1.5, 0.05];
/// Half extents of the floor in metres: a bead that is pinched flies off at 10 m/s, and comes to rest on it.
const FLOOR_HALF: [f32; 3] = [50.0, 50.0, 0.05];
/// How far the floor's top is below the table's, in metres.
const FLOOR_BELOW: f32 = 0.75;
/// Friction of the table's top.
const TABLE_FRICTION: f32 = 0.6;
/// Where the tool centre point is in a new world: 30 cm above the middle of the table.
const HOME: [f64; 3] = [0.0, 0.0, 0.3];
/// How long beads are left to come to rest after they have been put in, seconds.
const FILL_SETTLE: f64 = 0.5;

/// What a collider belongs to; kept in the engine's user data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tag {
    /// The table.
    Table,
    /// Palm or finger.
    Hand,
    /// A link of the arm.
    Arm,
    /// A bead.
    Bead,
    /// The object of this index.
    Object(usize),
}

impl Tag {
    pub(crate) fn encode(self) -> u128 {
        match self {
            Tag::Table => 0,
            Tag::Hand => 1,
            Tag::Bead => 2,
            Tag::Arm => 3,
            Tag::Object(index) => 4 + index as u128,
        }
    }

    pub(crate) fn decode(data: u128) -> Tag {
        match data {
            0 => Tag::Table,
            1 => Tag::Hand,
            2 => Tag::Bead,
            3 => Tag::Arm,
            index => Tag::Object((index - 4) as usize),
        }
    }
}

/// An object with its body in the engine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Entry {
    pub(crate) object: Object,
    pub(crate) body: RigidBodyHandle,
}

/// A table-top world. All poses are in metres in the world frame: z up, the table's top at z = 0.
///
/// The same calls give the same bits on every machine and in every build. [`World::clone`] and [`World::snapshot`] give worlds that go on alike.
#[derive(Serialize, Deserialize)]
pub struct World {
    pub(crate) physics: PhysicsWorld,
    pub(crate) entries: Vec<Entry>,
    pub(crate) names: BTreeMap<String, usize>,
    pub(crate) beads: Vec<RigidBodyHandle>,
    pub(crate) hand: Hand,
    pub(crate) arm: Option<Arm>,
    bonds: Vec<Bond>,
    pushes: Vec<Push>,
    pub(crate) guides: Vec<Guide>,
    pub(crate) guard: Guard,
    steps: u64,
    pub(crate) table: ColliderHandle,
}

impl Default for World {
    fn default() -> World {
        World::new()
    }
}

impl World {
    /// An empty table, with the gripper open above its middle.
    pub fn new() -> World {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        let softness = |natural_frequency| SpringCoefficients { natural_frequency, damping_ratio: CONTACT_DAMPING };
        physics.integration_parameters = IntegrationParameters {
            dt: DT as f32,
            length_unit: LENGTH_UNIT,
            contact_recycling: false, // with it, a held pitcher slips 157 mm
            contact_softness: softness(CONTACT_FREQUENCY),
            static_contact_softness: softness(STATIC_CONTACT_FREQUENCY),
            num_solver_iterations: SOLVER_ITERATIONS,
            ..IntegrationParameters::default()
        };
        let [x, y, z] = TABLE_HALF;
        let (_, table) = physics.insert(
            RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -z)),
            ColliderBuilder::cuboid(x, y, z).friction(TABLE_FRICTION).user_data(Tag::Table.encode()),
        );
        let [x, y, z] = FLOOR_HALF;
        physics.insert(
            RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -FLOOR_BELOW - z)),
            ColliderBuilder::cuboid(x, y, z).friction(TABLE_FRICTION).user_data(Tag::Table.encode()),
        );
        let hand = Hand::build(&mut physics, frame::pose_at(HOME, Default::default()));
        World {
            physics,
            entries: Vec::new(),
            names: BTreeMap::new(),
            beads: Vec::new(),
            hand,
            arm: None,
            bonds: Vec::new(),
            pushes: Vec::new(),
            guides: Vec::new(),
            guard: Guard::default(),
            steps: 0,
            table,
        }
    }

    /// Puts an object into the world, at rest. `pose` is that of its frame (see [`Object`]).
    ///
    /// # Errors
    /// The name is taken (`table`, `hand` and `arm` always are), the pose is not finite or more than 5 m away, or a dimension or a property of the
    /// material is impossible.
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
        let body = match object.motion {
            Motion::Fixed => RigidBodyBuilder::fixed(),
            Motion::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let body = self.physics.insert_body(body.pose(to_engine(&pose)));
        for collider in colliders {
            self.physics.insert_collider(collider, Some(body));
        }
        self.names.insert(object.name.clone(), index);
        self.entries.push(Entry { object, body });
        Ok(())
    }

    /// Puts beads into a container, in layers from its floor up, and lets half a second pass for them to settle.
    ///
    /// # Errors
    /// There is no such object, it has no interior, the beads do not fit below its rim, or a property of theirs is impossible.
    pub fn fill(&mut self, container: &str, beads: &Beads) -> Result<(), SimError> {
        let entry = &self.entries[self.index(container)?];
        let Some(interior) = entry.object.container else {
            return Err(SimError::NoInterior { object: container.to_owned() });
        };
        let pose = from_engine(self.physics.bodies[entry.body].position());
        for center in beads.layout(container, &interior)? {
            let at = pose * nalgebra::Point3::from(center);
            let body = RigidBodyBuilder::dynamic()
                .translation(to_engine_vector(&at.coords))
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
        self.settle(FILL_SETTLE);
        Ok(())
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
    /// The default of 4 is right for what lies about. It does not converge where the hand squeezes something on a joint: the 10 N on the fin
    /// of a drawer come out as up to 25 N on either finger, with 16 iterations as up to 15 N. Only a scene of few contacts can bear the cost.
    pub fn set_solver_iterations(&mut self, iterations: usize) {
        self.physics.integration_parameters.num_solver_iterations = iterations.clamp(1, MOST_ITERATIONS);
    }

    /// Puts the hand elsewhere at once, at rest, the pads `opening` metres apart (clamped to what it can do).
    ///
    /// For setting up a scene, before an arm is mounted: nothing checks whether something is in the way. A target that is not finite, or
    /// further than 5 m away, is ignored, as is any once there is an arm.
    pub fn place_gripper(&mut self, tcp: Pose, opening: f64) {
        if check_pose(HAND, &tcp).is_ok() && opening.is_finite() && self.arm.is_none() {
            self.hand.place(&mut self.physics, tcp, opening);
        }
    }

    /// Where hand and arm are to be after the next step.
    pub(crate) fn aim(&mut self, place: &Place) {
        self.hand.aim(place.tcp);
        if let (Some(arm), Some(configuration)) = (&mut self.arm, place.configuration) {
            arm.configuration = configuration;
        }
    }

    /// Somebody bumps into an object: during the next `seconds` it slides by `displacement` (metres, world frame), whatever stands in the way.
    ///
    /// What is in it comes along. A push replaces one that is under way for the same object.
    ///
    /// # Errors
    /// There is no such object, the displacement leads out of the workshop, or the duration is not between 0.01 and 60 s.
    pub fn push(&mut self, object: &str, displacement: [f64; 3], seconds: f64) -> Result<(), SimError> {
        let index = self.index(object)?;
        within(object, "a push must take 0.01 to 60 s", &[seconds], 0.01, 60.0)?;
        let entry = &self.entries[index];
        let displacement = Vector3::from(displacement);
        let mut end = from_engine(self.physics.bodies[entry.body].position());
        end.translation.vector += displacement;
        check_pose(object, &end)?;
        self.pushes.retain(|push| push.object != index);
        let steps = libm::round(seconds / DT) as u32;
        let dynamic = entry.object.motion == Motion::Dynamic;
        let push = Push::begin(&mut self.physics, index, entry.body, displacement, steps, dynamic);
        self.pushes.push(push);
        Ok(())
    }

    /// One step of 1/240 s: the controllers of hand and arm, magnets, pushes, physics.
    pub fn step(&mut self) {
        self.hand.drive(&mut self.physics);
        if let Some(arm) = &self.arm {
            arm.drive(&mut self.physics);
        }
        for bond in &self.bonds {
            for index in [bond.a, bond.b] {
                let body = &mut self.physics.bodies[self.entries[index].body];
                body.reset_forces(false);
                body.reset_torques(false);
            }
        }
        for bond in &self.bonds {
            bond.pull(&mut self.physics, self.entries[bond.a].body, self.entries[bond.b].body);
        }
        for push in &mut self.pushes {
            push.drive(&mut self.physics, self.entries[push.object].body);
        }
        self.physics.step();
        let (physics, entries) = (&mut self.physics, &self.entries);
        self.pushes.retain(|push| !push.finish(physics, entries[push.object].body));
        self.hand.feel(&self.physics, self.arm.as_ref().map_or(&[], |arm| &arm.colliders));
        self.steps += 1;
    }

    /// Steps for so many simulated seconds (rounded to whole steps; nothing if negative or not a number).
    pub fn settle(&mut self, seconds: f64) {
        for _ in 0..steps_in(seconds) {
            self.step();
        }
    }

    /// Simulated seconds since the world was made.
    pub fn time(&self) -> f64 {
        self.steps as f64 * DT
    }

    /// Commands the gripper; it obeys during the following steps. A command that is not a number is ignored.
    pub fn command(&mut self, gripper: Gripper) {
        self.hand.obey(&self.physics, gripper);
    }

    /// This world with other physics: what a copy needs.
    pub(crate) fn with_physics(&self, physics: PhysicsWorld) -> World {
        World {
            physics,
            entries: self.entries.clone(),
            names: self.names.clone(),
            beads: self.beads.clone(),
            hand: self.hand.clone(),
            arm: self.arm.clone(),
            bonds: self.bonds.clone(),
            pushes: self.pushes.clone(),
            guides: self.guides.clone(),
            guard: self.guard,
            steps: self.steps,
            table: self.table,
        }
    }

    /// Index of the object of this name.
    pub(crate) fn index(&self, name: &str) -> Result<usize, SimError> {
        self.names.get(name).copied().ok_or_else(|| SimError::UnknownObject { object: name.to_owned() })
    }

    /// Whether the world's numbers are still sound: nothing infinite, nothing beyond the floor. Else the run is spoilt.
    pub fn is_finite(&self) -> bool {
        self.physics.bodies.iter().all(|(_, body)| {
            let position = body.translation();
            position.is_finite()
                && body.rotation().is_finite()
                && body.linvel().is_finite()
                && position.length() <= FLOOR_HALF[0]
        })
    }
}

/// Whole steps in so many seconds; none if negative or not a number, at most an hour's worth.
pub(crate) fn steps_in(seconds: f64) -> u64 {
    /// An hour.
    const LONGEST: f64 = 3600.0;
    if seconds > 0.0 { libm::round(seconds.min(LONGEST) / DT) as u64 } else { 0 }
}

/// Collides with nothing.
fn no_groups() -> InteractionGroups {
    InteractionGroups::none().with_memberships(Group::NONE)
}
