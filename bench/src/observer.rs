//! Who sees what an executor does, while it does it.

use situ_sim::World;

use crate::calibration::Choice;

/// Sees what an executor does. It changes nothing. What the memo has is not performed, so nobody sees it.
pub trait Observer {
    /// The executor has chosen what is to follow, if that is probable enough.
    fn chose(&mut self, _choice: &Choice) {}
    /// The hand sets off for a keyframe, counted from 0, of so many of a primitive on this reference object.
    fn sets_off(&mut self, _reference: &str, _index: usize, _keyframes: usize) {}
    /// A step of the physics has passed.
    fn step(&mut self, _world: &World) {}
}

/// Nobody.
impl Observer for () {}
