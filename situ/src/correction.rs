//! A correction as a robot meets it: what it did until it failed, and what a teacher then showed.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::demonstration::Demonstration;
use crate::place::{NodeId, Place};

/// What is known when a robot is corrected: `z`, `S` and `D` of the listing, and more.
#[derive(Clone, Copy, Debug)]
pub struct Correction<'a> {
    /// `z`: the primitive that ran last to its end; START where none did.
    pub last: Place,
    /// The primitive that was under way when the robot failed or was stopped, if one was. The listing knows one `z` alone; but a robot
    /// knows what it was doing, and what failed is the first that a teacher may be showing another way of (decision D18).
    pub interrupted: Option<NodeId>,
    /// `D`, with the states `S`.
    pub demonstration: &'a Demonstration,
    /// What somebody tells who knows the task. `oracle_edit` alone listens.
    pub told: Option<&'a Told>,
}

/// What nobody can see in a demonstration, and an oracle is told.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// The skills, by the teacher's names for them, that the changed task wants done in another way and that the robot has not been shown yet.
    pub changed: BTreeSet<Arc<str>>,
}

impl<'a> Correction<'a> {
    /// A correction between two primitives, of which nothing is told.
    pub fn after(last: Place, demonstration: &'a Demonstration) -> Self {
        Self { last, interrupted: None, demonstration, told: None }
    }
}
