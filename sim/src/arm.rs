//! The arm that carries the hand: its model, its kinematics, its body in the engine.
//!
//! Its links are kinematic bodies that follow our own kinematics exactly. So the arm adds reach, limits and collisions
//! to a hand, and no lag.

pub(crate) mod body;
pub(crate) mod connect;
pub(crate) mod kinematics;
pub(crate) mod model;
pub(crate) mod shells;

pub use model::{ArmModel, Configuration, JOINTS, Joint};
