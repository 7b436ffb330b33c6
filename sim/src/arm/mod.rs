//! The arm that carries the hand: where it can reach, what it would run into, and how it gets from one keyframe to the next.
//!
//! Its links are kinematic bodies that follow our own kinematics exactly, so it adds reach, limits and collisions to a hand, and no lag.

pub(crate) mod connect;
pub(crate) mod kinematics;
pub(crate) mod model;
pub(crate) mod obstacles;
pub(crate) mod plan;

use std::sync::Arc;

use rapier3d::prelude::{ColliderBuilder, ColliderHandle, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};
use serde::{Deserialize, Serialize};

pub use kinematics::Configuration;
pub use model::{ArmModel, JOINTS, Joint};
use obstacles::Shells;

use crate::error::SimError;
use crate::frame::{Pose, to_engine, to_engine_near};
use crate::hand::hand_groups;
use crate::world::{Tag, World};

/// Bodies and controller of an arm.
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "Mounted", into = "Mounted")]
pub(crate) struct Arm {
    pub(crate) model: Arc<ArmModel>,
    pub(crate) shells: Shells,
    bodies: Vec<RigidBodyHandle>,
    pub(crate) colliders: Vec<ColliderHandle>,
    /// The angles after the next step.
    pub(crate) configuration: Configuration,
    /// Where the spare joint is drawn to: the angles at which it was mounted.
    pub(crate) rest: Configuration,
    seed: u64,
    plans: u64,
}

/// An arm as it is written: without what follows from its model.
#[derive(Clone, Serialize, Deserialize)]
struct Mounted {
    model: Arc<ArmModel>,
    bodies: Vec<RigidBodyHandle>,
    colliders: Vec<ColliderHandle>,
    configuration: Configuration,
    rest: Configuration,
    seed: u64,
    plans: u64,
}

impl From<Arm> for Mounted {
    fn from(arm: Arm) -> Mounted {
        let Arm { model, shells: _, bodies, colliders, configuration, rest, seed, plans } = arm;
        Mounted { model, bodies, colliders, configuration, rest, seed, plans }
    }
}

impl TryFrom<Mounted> for Arm {
    type Error = SimError;

    fn try_from(mounted: Mounted) -> Result<Arm, SimError> {
        let Mounted { model, bodies, colliders, configuration, rest, seed, plans } = mounted;
        let shells = Shells::new(&model)?;
        Ok(Arm { model, shells, bodies, colliders, configuration, rest, seed, plans })
    }
}

impl Arm {
    /// Sets the links' goals for the coming step.
    pub(crate) fn drive(&self, physics: &mut PhysicsWorld) {
        let posture = self.model.posture(&self.configuration);
        for (body, frame) in self.bodies.iter().zip(&posture.links) {
            let body = &mut physics.bodies[*body];
            body.set_next_kinematic_position(to_engine_near(frame, body.position()));
        }
    }

    /// Puts the links at once where they belong.
    fn place(&self, physics: &mut PhysicsWorld) {
        let posture = self.model.posture(&self.configuration);
        for (body, frame) in self.bodies.iter().zip(&posture.links) {
            physics.bodies[*body].set_position(to_engine(frame), true);
            physics.bodies[*body].set_next_kinematic_position(to_engine(frame));
        }
    }

    /// A seed for the next plan: no two plans of an arm share one.
    pub(crate) fn next_seed(&mut self) -> u64 {
        /// 2⁶⁴ over the golden ratio: multiples of it are spread evenly.
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        self.plans += 1;
        self.seed.wrapping_add(self.plans.wrapping_mul(GOLDEN))
    }

    /// A configuration in which the arm holds the hand at a pose, near the middle of the joints' ranges if there is one. None if the pose is
    /// out of reach.
    fn at_ease(&self, tcp: &Pose) -> Option<Configuration> {
        let middle = self.model.middle();
        self.model.solutions(tcp, &middle, &middle, self.seed).next()
    }
}

impl World {
    /// Mounts an arm that carries the hand, from now on: motions keep to what it can reach and go round what it would run into. `seed` is
    /// that of its planner.
    ///
    /// # Errors
    /// There is an arm already, a shell of the model is impossible, or the hand is out of the arm's reach.
    pub fn mount(&mut self, model: Arc<ArmModel>, seed: u64) -> Result<(), SimError> {
        if self.arm.is_some() {
            return Err(SimError::Arm { reason: "there is an arm already".to_owned() });
        }
        let shells = Shells::new(&model)?;
        let rest = model.middle();
        let (mut bodies, mut colliders) = (Vec::new(), Vec::new());
        for (link, parts) in model.shells.iter().enumerate() {
            let body = if link == 0 {
                RigidBodyBuilder::fixed().pose(to_engine(&model.mount))
            } else {
                RigidBodyBuilder::kinematic_position_based()
            };
            let body = self.physics.insert_body(body);
            for (part, (shape, local)) in parts.iter().zip(shells.of_link(link)) {
                let collider = ColliderBuilder::new(shape.clone())
                    .position(*local)
                    .friction(part.friction as f32)
                    .collision_groups(hand_groups())
                    .user_data(Tag::Arm.encode());
                colliders.push(self.physics.insert_collider(collider, Some(body)));
            }
            if link > 0 {
                bodies.push(body);
            }
        }
        let mut arm = Arm { model, shells, bodies, colliders, configuration: rest, rest, seed, plans: 0 };
        let configuration = arm
            .at_ease(self.hand.target())
            .ok_or_else(|| SimError::Arm { reason: "the hand is out of its reach".to_owned() })?;
        (arm.configuration, arm.rest) = (configuration, configuration);
        arm.place(&mut self.physics);
        self.arm = Some(arm);
        Ok(())
    }

    /// The angles of the arm's joints in radians, from the mount to the hand; none without an arm.
    pub fn configuration(&self) -> Option<Configuration> {
        self.arm.as_ref().map(|arm| arm.configuration)
    }
}
