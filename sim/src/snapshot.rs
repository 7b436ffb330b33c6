//! Snapshots: a world that has been put aside, and goes on bit for bit.

use rapier3d::prelude::PhysicsWorld;
use serde::{Deserialize, Serialize};

use crate::world::World;

/// Everything of a world at one instant: physics with its contact impulses, hand and controller, magnets, pushes, time.
///
/// In memory it shares the collision shapes with the world it was taken from. It can be written with serde and read
/// back.
#[derive(Clone, Serialize, Deserialize)]
pub struct Snapshot {
    world: World,
}

impl std::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Snapshot({:?})", self.world)
    }
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
