//! A rollout: a task model executed in an episode.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use situ::keyframe::policy::Execution;
use situ::method::Learned;
use situ::place::{NodeId, Place};
use situ_sim::{GripperCommand, MAX_OPENING, MotionEnd, World};
use situ_tasks::{Episode, Moment};
use situ_teachers::convert::{gripper_command, observe};

use crate::error::BenchError;

/// A rollout is stopped after so many primitives: more than twice as many as the longest task needs.
const MOST_PRIMITIVES: usize = 40;

/// How a rollout ended.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ended {
    /// The model chose END.
    End,
    /// No child was probable enough.
    NoConfidentChild,
    /// The reference object of the chosen primitive was not there.
    ReferenceAbsent,
    /// A motion was aborted: the force on the hand was too great.
    Aborted,
    /// The arm could not hold the hand at a keyframe.
    OutOfReach,
    /// The arm found no free way to a keyframe.
    NoPlan,
    /// Time was up, or too many primitives ran.
    TimeOut,
    /// The watching teacher stopped the robot, for this reason.
    Stopped(String),
    /// The numbers of the physics were no longer sound. That is nobody's failure.
    Spoilt,
}

impl fmt::Display for Ended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::End => "end",
            Self::NoConfidentChild => "no confident child",
            Self::ReferenceAbsent => "reference absent",
            Self::Aborted => "aborted",
            Self::OutOfReach => "out of reach",
            Self::NoPlan => "no plan",
            Self::TimeOut => "time-out",
            Self::Stopped(reason) => reason,
            Self::Spoilt => "spoilt",
        })
    }
}

/// How to execute.
#[derive(Clone, Copy, Debug)]
pub struct Execute {
    /// Sampled or mean keyframes.
    pub execution: Execution,
    /// Least probability of a child (decision D11).
    pub confidence: f64,
    /// Who watches. Nobody watches an evaluation.
    pub watched: Watched,
}

/// Who watches a rollout, and stops the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// Nobody.
    No,
    /// A teacher who stops the robot at the setting's moments, but lets the first so many pass.
    AfterMissing(u32),
    /// A teacher who stops the robot before this primitive, counted from 0 in the order in which they run.
    UntilPrimitive(usize),
}

/// A teacher who watches, and how many of the setting's moments have been missed so far.
struct Watch {
    watched: Watched,
    missed: u32,
}

impl Watch {
    /// Whether the teacher stops the robot at this moment.
    fn stops(&mut self, episode: &Episode, moment: Moment, reference: &str) -> Option<Ended> {
        let Watched::AfterMissing(misses) = self.watched else { return None };
        let intervention = episode.intervention(moment, reference)?;
        if self.missed < misses {
            self.missed += 1;
            return None;
        }
        Some(Ended::Stopped(intervention.name.clone()))
    }
}

/// The reason of a teacher who stops the robot before anything has gone wrong.
const TOO_EARLY: &str = "stopped early";

/// The result of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Rollout {
    /// How it ended.
    pub ended: Ended,
    /// The primitive that ran last to its end; START where none did.
    pub last: Place,
    /// The primitive that was begun and did not run to its end.
    pub interrupted: Option<NodeId>,
    /// Whether the goal holds in the world as it was left.
    pub success: bool,
    /// The primitives that were begun, with their probabilities.
    pub primitives: Vec<(Place, f64)>,
}

/// Executes the model from where the episode stands, as if nothing had run before. `observer` sees every simulated
/// step.
///
/// # Errors
/// Where the model names a node that it does not hold, which is a fault of the method.
pub fn rollout(
    model: &dyn Learned,
    episode: &mut Episode,
    execute: Execute,
    rng: &mut ChaCha8Rng,
    observer: &mut dyn FnMut(&World),
) -> Result<Rollout, BenchError> {
    let mut last = Place::Start;
    let mut interrupted = None;
    let mut primitives = Vec::new();
    let mut watch = Watch { watched: execute.watched, missed: 0 };
    let ended = loop {
        let state = observe(episode);
        let Some((child, probability)) = model.next(last, &state) else { break Ended::NoConfidentChild };
        if probability < execute.confidence {
            break Ended::NoConfidentChild;
        }
        let Place::Node(node) = child else { break Ended::End };
        if primitives.len() == MOST_PRIMITIVES {
            break Ended::TimeOut;
        }
        let (reference, keyframes) = model.keyframes(node, execute.execution, rng)?;
        let Some(frame) = episode.reference_pose(&reference) else { break Ended::ReferenceAbsent };
        if let Some(reason) = watch.stops(episode, Moment::Before, &reference) {
            break reason;
        }
        if execute.watched == Watched::UntilPrimitive(primitives.len()) {
            break Ended::Stopped(TOO_EARLY.to_owned());
        }
        primitives.push((child, probability));
        if let Some(reason) = perform(episode, &mut watch, &reference, &frame, &keyframes, observer) {
            interrupted = Some(node);
            break reason;
        }
        // A teacher who stops the robot after a primitive stops it after that primitive has run to its end.
        last = child;
        if let Some(reason) = watch.stops(episode, Moment::After, &reference) {
            break reason;
        }
    };
    let ended = if episode.is_sound() { ended } else { Ended::Spoilt };
    Ok(Rollout { ended, last, interrupted, success: episode.succeeded(), primitives })
}

/// Performs one primitive. Returns why it was not performed to its end, if it was not.
fn perform(
    episode: &mut Episode,
    watch: &mut Watch,
    reference: &str,
    frame: &situ::demonstration::Pose,
    keyframes: &[situ::segment::RelativeKeyframe],
    observer: &mut dyn FnMut(&World),
) -> Option<Ended> {
    for (index, keyframe) in keyframes.iter().enumerate() {
        let command = gripper_command(keyframe.gripper, MAX_OPENING);
        let gripper = (!same(command, episode.world().gripper())).then_some(command);
        let end = episode.perform(&(frame * keyframe.pose), gripper, keyframe.hold, observer);
        if !episode.is_sound() {
            return Some(Ended::Spoilt);
        }
        episode.reached_keyframe(reference, index);
        match end {
            MotionEnd::Aborted { .. } => return Some(Ended::Aborted),
            MotionEnd::OutOfReach => return Some(Ended::OutOfReach),
            MotionEnd::NoPlan => return Some(Ended::NoPlan),
            MotionEnd::Guarded { .. } => {
                if let Some(reason) = watch.stops(episode, Moment::Guard, reference) {
                    return Some(reason);
                }
            }
            MotionEnd::Reached => {}
        }
        if episode.finished_out_of_time() {
            return Some(Ended::TimeOut);
        }
    }
    None
}

/// A learned command is a mean. Within this of the command in force, it is that command. Metres.
const SAME_OPENING: f64 = 1e-3;
/// The same for a force, newtons.
const SAME_FORCE: f64 = 0.5;

fn same(left: GripperCommand, right: GripperCommand) -> bool {
    match (left, right) {
        (GripperCommand::Open(left), GripperCommand::Open(right)) => (left - right).abs() < SAME_OPENING,
        (GripperCommand::Close(left), GripperCommand::Close(right)) => (left - right).abs() < SAME_FORCE,
        _ => false,
    }
}
