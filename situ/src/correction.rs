//! A correction as a robot meets it: what it did until it failed, and what a teacher then showed.

use crate::demonstration::Demonstration;
use crate::place::{NodeId, Place};

/// What is known when a robot is corrected: `z`, `S` and `D` of the listing, and one thing more.
#[derive(Clone, Copy, Debug)]
pub struct Correction<'a> {
    /// `z`: the primitive that ran last to its end; START where none did.
    pub last: Place,
    /// The primitive that was under way when the robot failed or was stopped, if one was. The listing knows one `z` alone; but a robot
    /// knows what it was doing, and what failed is the first that a teacher may be showing another way of (decision D18).
    pub interrupted: Option<NodeId>,
    /// `D`, with the states `S`.
    pub demonstration: &'a Demonstration,
}

impl<'a> Correction<'a> {
    /// A correction between two primitives.
    pub fn after(last: Place, demonstration: &'a Demonstration) -> Self {
        Self { last, interrupted: None, demonstration }
    }
}
