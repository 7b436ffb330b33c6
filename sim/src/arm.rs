//! The arm that carries the hand: its model, its kinematics, and its bodies in the engine.
//!
//! Its links are kinematic bodies that follow our own kinematics exactly. So the arm adds reach, limits and collisions
//! to a hand, and no lag.

use std::sync::Arc;

use rapier3d::geometry::SharedShape;
use rapier3d::prelude::{
    ColliderBuilder, ColliderHandle, PhysicsWorld, Pose as EnginePose, RigidBodyBuilder, RigidBodyHandle,
};
use serde::{Deserialize, Serialize};

use crate::error::SimError;
use crate::frame::{Pose, to_engine, to_engine_near};
use crate::hand::hand_groups;
use crate::object::Part;
use crate::tag::Tag;

pub(crate) mod connect;
pub(crate) mod kinematics;
pub(crate) mod model;

pub use model::{ArmModel, Configuration, JOINTS, Joint};

/// A model with its shells in the engine's words. It is written as its model, since the shells follow from that.
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "Arc<ArmModel>", into = "Arc<ArmModel>")]
pub(crate) struct Shells {
    pub(crate) model: Arc<ArmModel>,
    /// The shells of the mount, then of the link after each joint, each in the frame of its link.
    links: Vec<Vec<(SharedShape, EnginePose)>>,
}

impl From<Shells> for Arc<ArmModel> {
    fn from(shells: Shells) -> Arc<ArmModel> {
        shells.model
    }
}

impl TryFrom<Arc<ArmModel>> for Shells {
    type Error = SimError;

    /// # Errors
    /// A shell of the model is impossible.
    fn try_from(model: Arc<ArmModel>) -> Result<Shells, SimError> {
        let engine = |part: &Part| {
            let (shape, upright) = part.shape.engine(&model.name)?;
            Ok((shape, to_engine(&part.pose) * upright))
        };
        let links = model.shells.iter().map(|parts| parts.iter().map(engine).collect());
        let links = links.collect::<Result<_, SimError>>()?;
        Ok(Shells { model, links })
    }
}

impl Shells {
    /// The shells of one link, 0 being the mount; none for a link that does not exist.
    pub(crate) fn of_link(&self, link: usize) -> &[(SharedShape, EnginePose)] {
        self.links.get(link).map_or(&[], Vec::as_slice)
    }
}

/// Bodies and controller of an arm.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Arm {
    #[serde(rename = "model")]
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
        let shells = Shells::try_from(Arc::clone(&model))?;
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
        let arm = Arm { shells, bodies, colliders, configuration: rest, rest, seed, plans: 0 };
        let posture = model.posture(&rest);
        for (body, frame) in arm.bodies.iter().zip(&posture.links) {
            physics.bodies[*body].set_position(to_engine(frame), true);
            physics.bodies[*body].set_next_kinematic_position(to_engine(frame));
        }
        Ok(arm)
    }

    /// Sets the links' goals for the coming step.
    pub(crate) fn drive(&self, physics: &mut PhysicsWorld) {
        let posture = self.shells.model.posture(&self.configuration);
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
