//! The world: a table, objects, beads and a hand, advanced in steps of 1/240 s. A snapshot is a world put aside.

use std::collections::BTreeMap;

use rapier3d::prelude::{
    ColliderBuilder, ColliderHandle, IntegrationParameters, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SpringCoefficients, Vector,
};
use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::error::SimError;
use crate::frame;
use crate::hand::{GripperCommand, Guard, Hand};
use crate::hinge::Pivot;
use crate::mechanism::{Bond, Guide};
use crate::object::Object;
use crate::push::Push;
use crate::rolling::{self, Roller};
use crate::step::{DT, steps_in};
use crate::tag::Tag;

/// Metres per second per second.
const GRAVITY: f32 = 9.81;
/// Typical size of things in metres. It scales the engine's tolerances; with 1 m beads tunnel and spill.
pub(crate) const LENGTH_UNIT: f32 = 0.02;
/// Natural frequency in Hz of contacts between movable bodies.
const CONTACT_FREQUENCY: f32 = 240.0;
/// Natural frequency in Hz of contacts with fixed bodies.
const STATIC_CONTACT_FREQUENCY: f32 = 480.0;
/// Damping ratio of contacts.
const CONTACT_DAMPING: f32 = 5.0;
/// Iterations of the solver in a step. 8 bring little, but see [`World::set_solver_iterations`].
const SOLVER_ITERATIONS: usize = 4;
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

/// An object with its body in the engine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Entry {
    pub(crate) object: Object,
    pub(crate) body: RigidBodyHandle,
}

/// A table-top world. All poses are in metres in the world frame: z up, the table's top at z = 0.
///
/// The same calls give the same bits on every machine and in every build. [`World::clone`] and [`World::snapshot`] give
/// worlds that go on alike.
#[derive(Serialize, Deserialize)]
pub struct World {
    pub(crate) physics: PhysicsWorld,
    pub(crate) entries: Vec<Entry>,
    pub(crate) names: BTreeMap<String, usize>,
    pub(crate) beads: Vec<RigidBodyHandle>,
    pub(crate) hand: Hand,
    pub(crate) arm: Option<Arm>,
    pub(crate) bonds: Vec<Bond>,
    pub(crate) pushes: Vec<Push>,
    pub(crate) guides: Vec<Guide>,
    pub(crate) pivots: Vec<Pivot>,
    pub(crate) rollers: Vec<Roller>,
    pub(crate) guard: Guard,
    pub(crate) steps: u64,
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
        let mut slab = |[x, y, z]: [f32; 3], top: f32| {
            physics.insert(
                RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, top - z)),
                ColliderBuilder::cuboid(x, y, z).friction(TABLE_FRICTION).user_data(Tag::Table.encode()),
            )
        };
        let (_, table) = slab(TABLE_HALF, 0.0);
        slab(FLOOR_HALF, -FLOOR_BELOW);
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
            pivots: Vec::new(),
            rollers: Vec::new(),
            guard: Guard::default(),
            steps: 0,
            table,
        }
    }

    /// One step of 1/240 s: the controllers of hand and arm, magnets, pushes, rolling friction, physics.
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
            push.drive(&mut self.physics);
        }
        let mut turned = Vec::new();
        for roller in &self.rollers {
            turned.extend(roller.resist(&mut self.physics));
        }
        self.physics.step();
        rolling::release(&mut self.physics, &turned);
        let (physics, pivots) = (&mut self.physics, &self.pivots);
        self.pushes.retain(|push| !push.finish(physics, pivots));
        self.hand.feel(&self.physics, self.arm.as_ref().map_or(&[], |arm| &arm.colliders));
        self.steps += 1;
    }

    /// Steps for so many simulated seconds (rounded to whole steps; nothing if negative or not a number).
    pub fn settle(&mut self, seconds: f64) {
        for _ in 0..steps_in(seconds) {
            self.step();
        }
    }

    /// Commands the gripper. It obeys during the following steps. A command that is not a number is ignored.
    pub fn command(&mut self, gripper: GripperCommand) {
        self.hand.obey(&self.physics, gripper);
    }

    /// Simulated seconds since the world was made.
    pub fn time(&self) -> f64 {
        self.steps as f64 * DT
    }

    /// Steps since the world was made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// About how many bytes a copy of the world takes.
    pub fn bytes(&self) -> usize {
        /// A body with its collider and their places in the engine's trees and lists.
        const BODY: usize = 1500;
        /// A further collider of a body.
        const COLLIDER: usize = 750;
        /// Two colliders that are near each other, with their contacts.
        const PAIR: usize = 400;
        let physics = &self.physics;
        BODY * physics.bodies.len()
            + COLLIDER * physics.colliders.len()
            + PAIR * physics.narrow_phase.contact_pairs().count()
    }

    /// Whether the world's numbers are still sound: all are finite, and nothing is beyond the floor. Else the run is
    /// spoilt.
    pub fn is_finite(&self) -> bool {
        self.physics.bodies.iter().all(|(_, body)| {
            let position = body.translation();
            position.is_finite()
                && body.rotation().is_finite()
                && body.linvel().is_finite()
                && position.length() <= FLOOR_HALF[0]
        })
    }

    /// Index of the object of this name.
    pub(crate) fn index(&self, name: &str) -> Result<usize, SimError> {
        self.names.get(name).copied().ok_or_else(|| SimError::UnknownObject { object: name.to_owned() })
    }
}

/// Everything of a world at one instant: physics with its contact impulses, hand and controller, magnets, pushes, time.
///
/// In memory it shares the collision shapes with the world it was taken from. It can be written with serde and read
/// back.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Snapshot {
    world: World,
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "World {{ time: {}, objects: {:?}, beads: {} }}", self.time(), self.names.keys(), self.beads.len())
    }
}

impl Clone for World {
    fn clone(&self) -> World {
        let physics = PhysicsWorld {
            gravity: self.physics.gravity,
            integration_parameters: self.physics.integration_parameters,
            islands: self.physics.islands.clone(),
            broad_phase: self.physics.broad_phase.clone(),
            narrow_phase: self.physics.narrow_phase.clone(),
            bodies: self.physics.bodies.clone(),
            colliders: self.physics.colliders.clone(),
            impulse_joints: self.physics.impulse_joints.clone(),
            multibody_joints: self.physics.multibody_joints.clone(),
            soft_bodies: self.physics.soft_bodies.clone(),
            // The pipelines hold working storage only.
            ..PhysicsWorld::default()
        };
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
            pivots: self.pivots.clone(),
            rollers: self.rollers.clone(),
            guard: self.guard,
            steps: self.steps,
            table: self.table,
        }
    }
}

impl World {
    /// Puts the present state aside.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot { world: self.clone() }
    }

    /// A world that goes on from the snapshot exactly as the one it was taken from.
    pub fn restore(snapshot: &Snapshot) -> World {
        snapshot.world.clone()
    }
}
