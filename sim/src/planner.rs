//! Motions of the hand: straight to a pose, with a guard against pressing on things.

use serde::{Deserialize, Serialize};

use crate::arm::plan::Unplanned;
use crate::check::{check_pose, within};
use crate::error::SimError;
use crate::frame::Pose;
use crate::world::{DT, HAND, World, steps_in};

/// The hand's largest speed in m/s.
pub const MAX_SPEED: f64 = 0.25;
/// The hand's largest rate of turning in rad/s.
pub const MAX_TURN: f64 = 1.5;
/// Time in which the hand reaches its largest speed, seconds.
const RAMP: f64 = 0.15;
/// [`Guard::rise`] unless it is set.
pub const GUARD_FORCE: f64 = 30.0;
/// [`Guard::abort`] unless it is set.
pub const ABORT_FORCE: f64 = 120.0;
/// No guard can be set to more than this, in newtons.
const MAX_GUARD: f64 = 1e3;
/// The guard is not heeded during the first steps: starting the motion shakes what is held.
const GUARD_AFTER: usize = 12;
/// A stopped hand goes back to where it was so many steps before, or it would go on pressing.
const BACK_OFF: usize = 4;
/// One that is aborted goes back the way it came until the force is below the guard's again, for at most so many steps: a palm that still
/// presses with the limit's force would abort whatever comes next.
const RETREAT: usize = 60;
/// How long it then stays there, in seconds.
const BACK_OFF_HOLD: f64 = 0.05;

/// The forces at which a motion of the hand ends early, in newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// A motion ends when the force on the hand rises by so much above the least since the start.
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
    pub(crate) fn check(&self) -> Result<(), SimError> {
        within(HAND, "the force of an abort must be more than 0 and at most 1000 N", &[self.abort], 1e-3, MAX_GUARD)?;
        within(HAND, "the guard must be more than 0 N and not above the abort", &[self.rise], 1e-3, self.abort)
    }
}

/// How a motion ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum MotionEnd {
    /// The hand is at its target.
    Reached,
    /// The hand met with resistance and has backed off.
    Guarded {
        /// Force on the hand in newtons when it stopped.
        force: f64,
    },
    /// The force on the hand went beyond the limit; it has backed off. Also the answer to a target that is no pose in the workshop.
    Aborted {
        /// Force on the hand in newtons when it stopped.
        force: f64,
    },
    /// The arm cannot hold the hand at the target: nothing has moved.
    OutOfReach,
    /// The arm could, but no way there was found on which it runs into nothing: nothing has moved.
    NoPlan,
}

impl MotionEnd {
    /// Whether a skill goes on after such an end: the target was reached, or the guard stopped the hand before it.
    pub fn goes_on(&self) -> bool {
        matches!(self, MotionEnd::Reached | MotionEnd::Guarded { .. })
    }
}

impl World {
    /// Moves the hand to `target` (pose of the tool centre point): straight in position, spherical in rotation, at most 0.25 m/s and 1.5 rad/s.
    ///
    /// An arm that carries the hand must be able to follow ([`World::mount`]). Where it cannot, or would run into something, it finds a way
    /// round; the motion is slower where a joint could not keep up.
    ///
    /// The motion ends early when the hand meets with more resistance than the guard allows ([`Guard`], 30 N unless set; see [`MotionEnd`]), or
    /// its palm with something that nothing moves. `observer` is called after each step.
    pub fn move_hand(&mut self, target: Pose, observer: &mut dyn FnMut(&World)) -> MotionEnd {
        let mut rest = self.hand_force();
        if check_pose(HAND, &target).is_err() {
            return MotionEnd::Aborted { force: rest };
        }
        let route = match self.plan(target) {
            Ok(route) => route,
            Err(Unplanned::OutOfReach) => return MotionEnd::OutOfReach,
            Err(Unplanned::NoPlan) => return MotionEnd::NoPlan,
        };
        let course = Course::new(route.length());
        let mut passed = vec![route.at(0.0)];
        // A palm that is in something fixed already may leave.
        let mut may_block = !self.hand.is_blocked(&self.physics);
        for step in 1..=course.steps {
            let place = route.at(if step == course.steps { 1.0 } else { course.way(step) });
            self.aim(&place);
            passed.push(place);
            self.step();
            observer(self);
            let force = self.hand_force();
            // What is left of an earlier blow dies away; the guard is set to what remains.
            rest = rest.min(force);
            let risen = force - rest > self.guard.rise;
            let is_blocked = self.hand.is_blocked(&self.physics);
            let blocks = is_blocked && may_block;
            may_block |= !is_blocked;
            // A hand that something presses on already may leave: only what this motion adds aborts it.
            if force > self.guard.abort && risen {
                for place in passed.iter().rev().take(RETREAT) {
                    self.aim(place);
                    self.step();
                    observer(self);
                    if self.hand_force() < self.guard.rise {
                        break;
                    }
                }
                self.hold(BACK_OFF_HOLD, observer);
                return MotionEnd::Aborted { force };
            }
            if blocks || (step > GUARD_AFTER && risen) {
                self.aim(&passed[passed.len().saturating_sub(1 + BACK_OFF)]);
                self.hold(BACK_OFF_HOLD, observer);
                return MotionEnd::Guarded { force };
            }
        }
        MotionEnd::Reached
    }

    /// Keeps the hand where it is for so many seconds; a gripper command takes effect meanwhile. `observer` is called after each step.
    pub fn hold(&mut self, seconds: f64, observer: &mut dyn FnMut(&World)) {
        for _ in 0..steps_in(seconds) {
            self.step();
            observer(self);
        }
    }
}

/// A course in time from 0 to 1: speeding up evenly, going evenly, slowing down evenly.
struct Course {
    /// Length of the way in seconds at full speed.
    length: f64,
    /// Seconds until full speed (or half of the time, if it is never reached).
    ramp: f64,
    /// Seconds in all.
    duration: f64,
    steps: usize,
}

impl Course {
    fn new(length: f64) -> Course {
        let (ramp, duration) = if length >= RAMP {
            (RAMP, length + RAMP)
        } else {
            let ramp = libm::sqrt(length * RAMP);
            (ramp, 2.0 * ramp)
        };
        Course { length, ramp, duration, steps: libm::ceil(duration / DT) as usize }
    }

    /// The part of the way that is done after so many steps.
    fn way(&self, step: usize) -> f64 {
        let time = self.duration * step as f64 / self.steps as f64;
        let left = self.duration - time;
        let speeding = |t: f64| 0.5 * t * t / RAMP;
        let done = if time < self.ramp {
            speeding(time)
        } else if left < self.ramp {
            self.length - speeding(left)
        } else {
            speeding(self.ramp) + (time - self.ramp)
        };
        (done / self.length).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_smooth_and_keeps_its_limits() {
        for length in [1e-6, 0.02, 0.149, 0.15, 0.4, 3.0] {
            let course = Course::new(length);
            let ways: Vec<f64> = (0..=course.steps).map(|k| course.way(k)).collect();
            assert!(ways[0].abs() < 1e-12 && (ways[course.steps] - 1.0).abs() < 1e-12);
            let pace = course.duration / course.steps as f64;
            for pair in ways.windows(2) {
                let speed = (pair[1] - pair[0]) * length / pace;
                assert!((-1e-9..=1.0 + 1e-9).contains(&speed), "{length}: {speed}");
            }
            for three in ways.windows(3) {
                let change = (three[2] - 2.0 * three[1] + three[0]).abs() * length / (pace * pace);
                assert!(change <= 1.0 / RAMP + 1e-6, "{length}: {change}");
            }
        }
        assert_eq!(Course::new(0.0).steps, 0);
    }
}
