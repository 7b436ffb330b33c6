//! The guard: at which forces a motion of the hand ends early.

use serde::{Deserialize, Serialize};

use crate::check::within;
use crate::error::SimError;
use crate::tag::HAND;

/// [`Guard::rise`] unless it is set, newtons.
pub const GUARD_FORCE: f64 = 30.0;
/// [`Guard::abort`] unless it is set, newtons.
pub const ABORT_FORCE: f64 = 120.0;
/// The greatest force to which a guard can be set, newtons.
const MAX_GUARD: f64 = 1e3;

/// The forces at which a motion of the hand ends early, in newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// A motion ends when the force on the hand rises by so much above its least value since the start.
    pub rise: f64,
    /// A motion is aborted at this force on the hand.
    pub abort: f64,
}

impl Default for Guard {
    fn default() -> Guard {
        Guard { rise: GUARD_FORCE, abort: ABORT_FORCE }
    }
}

impl Guard {
    /// Says what is wrong with the forces, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        within(HAND, "the force of an abort must be more than 0 and at most 1000 N", &[self.abort], 1e-3, MAX_GUARD)?;
        within(HAND, "the guard must be more than 0 N and not above the abort", &[self.rise], 1e-3, self.abort)
    }
}
