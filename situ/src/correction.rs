//! A correction as a robot meets it: what it did until it failed, and what a teacher then showed.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::demonstration::Demonstration;
use crate::place::{NodeId, Place};
use crate::trail::TrailStep;

/// What is known when a robot is corrected: `z`, `S` and `D` of the listing, and more.
#[derive(Clone, Copy, Debug)]
pub struct Correction<'a> {
    /// `z`: the primitive that ran last to its end; START where none did.
    pub last: Place,
    /// The primitive that was under way when the robot failed or was stopped, if one was. The listing knows `z` alone.
    /// But a robot knows what it was doing, and a teacher most probably shows another way of doing that (decision D18).
    pub interrupted: Option<NodeId>,
    /// The choices of the rollout that failed, in order, up to the failure (decision D23). Empty where nobody knows
    /// them: then the state in which the demonstration begins stands for all.
    pub trail: &'a [TrailStep],
    /// `D`, with the states `S`.
    pub demonstration: &'a Demonstration,
    /// What an oracle adds, for the methods that listen to one.
    pub oracle: Option<&'a Oracle>,
}

/// The ground truth about a changed task that no demonstration shows. Only `oracle_edit` listens to it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Oracle {
    /// The skills, by the teacher's names for them, that the changed task wants done in another way and that the robot
    /// has not been shown yet.
    pub changed: BTreeSet<Arc<str>>,
}

impl<'a> Correction<'a> {
    /// A correction between two primitives, without an oracle.
    pub fn after(last: Place, demonstration: &'a Demonstration) -> Self {
        Self { last, interrupted: None, trail: &[], demonstration, oracle: None }
    }
}
