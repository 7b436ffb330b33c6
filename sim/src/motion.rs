//! Motions of the hand: straight to a pose or round what the arm would run into, with a guard against pressing on
//! things.

mod obstacles;
pub(crate) mod pace;
mod plan;
mod route;

use serde::{Deserialize, Serialize};

use crate::error::check_pose;
use crate::frame::Pose;
use crate::hand::GripperCommand;
use crate::motion::plan::Unplanned;
use crate::motion::route::Place;
use crate::step::steps_in;
use crate::tag::HAND;
use crate::world::World;

/// The guard is not heeded during the first steps: the start of the motion shakes what is held.
const GUARD_AFTER: usize = 12;
/// A hand that the guard stops goes back to where it was so many steps before. Else it would go on pressing.
const BACK_OFF: usize = 4;
/// A hand that is aborted goes back the way it came, for at most so many steps, until the force is below the guard's
/// again. A palm that still presses with the limit's force would abort whatever comes next.
const RETREAT: usize = 60;
/// How long it then stays there, in seconds.
const BACK_OFF_HOLD: f64 = 0.05;

/// The longest time that is waited for the fingers, seconds. Their whole stroke takes them 0.27 s.
const GRIP_LONGEST: f64 = 0.5;
/// How long the fingers must have stood still, seconds.
const GRIP_REST: f64 = 0.05;
/// Fingers whose distance changes by less than this in a step stand still, metres. They close at 1.25 mm a step.
const GRIP_STILL: f64 = 2e-5;

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
    /// The force on the hand went beyond the limit, and it has backed off. Also the answer to a target that is no pose
    /// in the workshop.
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
    /// Moves the hand to `target` (pose of the tool centre point): straight in position, spherical in rotation.
    ///
    /// Near things it goes at most 0.25 m/s and 1.5 rad/s. The further it is from everything, the faster it goes, up to
    /// 1 m/s and 3 rad/s: it can always slow down before it touches something. With a load that can spill it speeds up
    /// and turns no faster than near things.
    ///
    /// An arm that carries the hand must be able to follow ([`World::mount`]). Where it cannot, or would run into
    /// something, it finds a way round. The motion is slower where a joint could not keep up.
    ///
    /// The motion ends early when the hand meets with more resistance than the guard allows ([`crate::Guard`], 30 N
    /// unless set; see [`MotionEnd`]), or its palm with something that nothing moves. `observer` is called after each
    /// step.
    pub fn move_hand(&mut self, target: Pose, observer: &mut dyn FnMut(&World)) -> MotionEnd {
        let mut rest = self.hand_force();
        if check_pose(HAND, &target).is_err() {
            return MotionEnd::Aborted { force: rest };
        }
        let (route, pace) = match self.plan(target) {
            Ok(plan) => plan,
            Err(Unplanned::OutOfReach) => return MotionEnd::OutOfReach,
            Err(Unplanned::NoPlan) => return MotionEnd::NoPlan,
        };
        let mut passed = vec![route.start()];
        // A palm that is in something fixed already may leave.
        let mut may_block = !self.hand.is_blocked(&self.physics);
        for step in 1..=pace.steps {
            let (piece, part) = pace.at(step);
            let place = if step == pace.steps { route.end() } else { route.at(piece, part) };
            self.go(&place, observer);
            passed.push(place);
            let force = self.hand_force();
            // What is left of an earlier blow dies away. The guard starts from what remains of it.
            rest = rest.min(force);
            let risen = force - rest > self.guard.rise;
            let is_blocked = self.hand.is_blocked(&self.physics);
            let blocks = is_blocked && may_block;
            may_block |= !is_blocked;
            // A hand that something presses on already may leave: only what this motion adds aborts it.
            if force > self.guard.abort && risen {
                self.retreat(&passed, observer);
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

    /// Keeps the hand where it is for so many seconds. A gripper command takes effect meanwhile. `observer` is called
    /// after each step.
    pub fn hold(&mut self, seconds: f64, observer: &mut dyn FnMut(&World)) {
        for _ in 0..steps_in(seconds) {
            self.step();
            observer(self);
        }
    }

    /// Gives the gripper a command and waits until the fingers have obeyed: until they have stood still for 0.05 s, and
    /// at most half a second. `observer` is called after each step.
    pub fn grip(&mut self, command: GripperCommand, observer: &mut dyn FnMut(&World)) {
        self.command(command);
        let (mut before, mut still) = (self.opening(), 0);
        for _ in 0..steps_in(GRIP_LONGEST) {
            self.step();
            observer(self);
            let opening = self.opening();
            still = if (opening - before).abs() < GRIP_STILL { still + 1 } else { 0 };
            before = opening;
            if still == steps_in(GRIP_REST) && self.hand.has_obeyed(&self.physics) {
                break;
            }
        }
    }

    /// Goes back over the places that were passed, until the force on the hand is below the guard's.
    fn retreat(&mut self, passed: &[Place], observer: &mut dyn FnMut(&World)) {
        for place in passed.iter().rev().take(RETREAT) {
            self.go(place, observer);
            if self.hand_force() < self.guard.rise {
                break;
            }
        }
        self.hold(BACK_OFF_HOLD, observer);
    }

    /// One step, after which hand and arm are at a place.
    fn go(&mut self, place: &Place, observer: &mut dyn FnMut(&World)) {
        self.aim(place);
        self.step();
        observer(self);
    }

    /// Where hand and arm are to be after the next step.
    fn aim(&mut self, place: &Place) {
        self.hand.aim(place.tcp);
        if let (Some(arm), Some(configuration)) = (&mut self.arm, place.configuration) {
            arm.configuration = configuration;
        }
    }
}
