//! The arm in the engine: bodies that go where its joints' angles put them.

use std::sync::Arc;

use rapier3d::prelude::{ColliderBuilder, ColliderHandle, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};
use serde::{Deserialize, Serialize};

use crate::arm::model::{ArmModel, Configuration};
use crate::arm::shells::Shells;
use crate::error::SimError;
use crate::frame::{Pose, to_engine, to_engine_near};
use crate::hand::hand_groups;
use crate::tag::Tag;

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
    /// Where the spare joint is drawn to: the angles at which the arm was mounted.
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
    /// Builds an arm that holds the hand at `tcp`. `seed` is that of its planner.
    ///
    /// # Errors
    /// A shell of the model is impossible, or the pose is out of reach.
    pub(crate) fn build(
        physics: &mut PhysicsWorld,
        model: Arc<ArmModel>,
        tcp: &Pose,
        seed: u64,
    ) -> Result<Arm, SimError> {
        let shells = Shells::new(&model)?;
        let middle = model.middle();
        let rest = model.solutions(tcp, &middle, &middle, seed).next();
        let rest = rest.ok_or_else(|| SimError::Arm { reason: "the hand is out of its reach".to_owned() })?;
        let (mut bodies, mut colliders) = (Vec::new(), Vec::new());
        for (link, parts) in model.shells.iter().enumerate() {
            let body = if link == 0 {
                RigidBodyBuilder::fixed().pose(to_engine(&model.mount))
            } else {
                RigidBodyBuilder::kinematic_position_based()
            };
            let body = physics.insert_body(body);
            for (part, (shape, local)) in parts.iter().zip(shells.of_link(link)) {
                let collider = ColliderBuilder::new(shape.clone())
                    .position(*local)
                    .friction(part.friction as f32)
                    .collision_groups(hand_groups())
                    .user_data(Tag::Arm.encode());
                colliders.push(physics.insert_collider(collider, Some(body)));
            }
            if link > 0 {
                bodies.push(body);
            }
        }
        let arm = Arm { model, shells, bodies, colliders, configuration: rest, rest, seed, plans: 0 };
        let posture = arm.model.posture(&arm.configuration);
        for (body, frame) in arm.bodies.iter().zip(&posture.links) {
            physics.bodies[*body].set_position(to_engine(frame), true);
            physics.bodies[*body].set_next_kinematic_position(to_engine(frame));
        }
        Ok(arm)
    }

    /// Sets the links' goals for the coming step.
    pub(crate) fn drive(&self, physics: &mut PhysicsWorld) {
        let posture = self.model.posture(&self.configuration);
        for (body, frame) in self.bodies.iter().zip(&posture.links) {
            let body = &mut physics.bodies[*body];
            body.set_next_kinematic_position(to_engine_near(frame, body.position()));
        }
    }

    /// A seed for the next plan. No two plans of an arm share one.
    pub(crate) fn next_seed(&mut self) -> u64 {
        /// 2⁶⁴ over the golden ratio: its multiples are spread evenly.
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        self.plans += 1;
        self.seed.wrapping_add(self.plans.wrapping_mul(GOLDEN))
    }
}
