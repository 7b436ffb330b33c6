//! A rollout: a task model executed in an episode.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use situ::demonstration::Pose;
use situ::keyframe::policy::Execution;
use situ::method::Learned;
use situ::place::{NodeId, Place};
use situ::segment::RelativeKeyframe;
use situ::state::State;
use situ::trail::{StepEnd, TrailStep};
use situ_tasks::{Episode, Moment};
use situ_teachers::convert::observe;

use crate::calibration::{Choice, Due};
use crate::ended::Ended;
use crate::error::BenchError;
use crate::executor::{Executor, Follows, Pursuit};
use crate::memo::{Action, Cursor, Performed};
use crate::observer::Observer;
use crate::stride::Stride;

/// A rollout is stopped after so many primitives: more than twice as many as the longest task needs.
const MOST_PRIMITIVES: usize = 40;

/// How to execute.
#[derive(Clone, Copy, Debug)]
pub struct Execute {
    /// Sampled or mean keyframes.
    pub execution: Execution,
    /// Least probability of a child (decision D11).
    pub confidence: f64,
    /// What is done where a primitive fails.
    pub executor: Executor,
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
#[derive(Clone, Copy)]
struct Watch {
    watched: Watched,
    missed: u32,
}

impl Watch {
    /// How many more moments the teacher lets pass; `None` where nobody watches for them.
    fn patience(&self) -> Option<u32> {
        match self.watched {
            Watched::AfterMissing(misses) => Some(misses - self.missed),
            Watched::No | Watched::UntilPrimitive(_) => None,
        }
    }

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
    /// Whether it held there, or after some primitive before.
    pub once: bool,
    /// The number of primitives that were begun.
    pub primitives: usize,
    /// The primitives that were chosen, in order, and how each ended.
    pub trail: Vec<TrailStep>,
    /// What the executor had to choose, in order.
    pub choices: Vec<Choice>,
}

/// Executes the model from where the episode stands, as if nothing had run before. The observer sees it.
///
/// # Errors
/// Where the model names a node that it does not hold, which is a fault of the method.
pub fn rollout(
    model: &dyn Learned,
    cursor: &mut Cursor<'_>,
    execute: Execute,
    rng: &mut ChaCha8Rng,
    observer: &mut dyn Observer,
) -> Result<Rollout, BenchError> {
    let mut pursuit = Pursuit::new(execute.executor, execute.confidence);
    let (mut interrupted, mut once) = (None, false);
    let (mut primitives, mut choices, mut trail) = (0, Vec::new(), Vec::new());
    let mut watch = Watch { watched: execute.watched, missed: 0 };
    let ended = loop {
        let state = observe(cursor.episode());
        let Some(Follows { place, probability, way }) = pursuit.next(model, &state)? else {
            break Ended::NoConfidentChild;
        };
        check_probability(pursuit.last(), probability)?;
        choices.push(Choice { last: pursuit.last(), child: place, probability, due: due(cursor.episode()) });
        observer.chose(&choices[choices.len() - 1]);
        if probability < execute.confidence {
            break Ended::NoConfidentChild;
        }
        let Place::Node(node) = place else { break Ended::End };
        if primitives == MOST_PRIMITIVES {
            break Ended::TimeOut;
        }
        let (reference, keyframes) = keyframes_of(model, (node, way), &state, execute.execution, rng)?;
        trail.push(TrailStep { state, node, end: StepEnd::Prevented });
        let Some(frame) = cursor.episode().reference_pose(&reference) else { break Ended::ReferenceAbsent };
        if let Some(reason) = watch.stops(cursor.episode(), Moment::Before, &reference) {
            break reason;
        }
        if execute.watched == Watched::UntilPrimitive(primitives) {
            break Ended::Stopped(TOO_EARLY.to_owned());
        }
        primitives += 1;
        pursuit.begins(node, way);
        let action = Action { reference: reference.clone(), keyframes, patience: watch.patience() };
        let performed =
            cursor.perform(action, |episode, action| perform(episode, (watch, &mut *observer), action, &frame));
        watch.missed += performed.missed;
        once |= cursor.episode().succeeded();
        let end = if performed.ended.is_some() { StepEnd::Interrupted } else { StepEnd::Finished };
        trail.last_mut().expect("it was chosen").end = end;
        interrupted = performed.ended.is_some().then_some(node);
        match performed.ended {
            Some(Ended::Aborted | Ended::OutOfReach | Ended::NoPlan) if pursuit.goes_on() => continue,
            Some(reason) => break reason,
            None => {}
        }
        // A teacher who stops the robot after a primitive stops it after that primitive has run to its end.
        pursuit.finished(node);
        if let Some(reason) = watch.stops(cursor.episode(), Moment::After, &reference) {
            break reason;
        }
    };
    let ended = if cursor.episode().is_sound() { ended } else { Ended::Spoilt };
    let success = cursor.episode().succeeded();
    Ok(Rollout { ended, last: pursuit.last(), interrupted, success, once: once || success, primitives, trail, choices })
}

/// The most keyframes of a primitive: no person shows so many.
const MOST_KEYFRAMES: usize = 10_000;

/// Refuses a probability that is none.
fn check_probability(last: Place, probability: f64) -> Result<(), BenchError> {
    if (0.0..=1.0).contains(&probability) { Ok(()) } else { Err(BenchError::Improbable { last, probability }) }
}

/// The reference object and the keyframes of one execution of a way of a primitive.
fn keyframes_of(
    model: &dyn Learned,
    (node, way): (NodeId, usize),
    state: &State,
    execution: Execution,
    rng: &mut ChaCha8Rng,
) -> Result<(Arc<str>, Vec<RelativeKeyframe>), BenchError> {
    let (reference, keyframes) = model.keyframes(node, way, state, execution, rng)?;
    check_keyframes(&keyframes).map_err(|problem| BenchError::Unusable { node, problem })?;
    Ok((reference, keyframes))
}

/// Refuses keyframes that no hand can go through.
fn check_keyframes(keyframes: &[RelativeKeyframe]) -> Result<(), String> {
    if keyframes.len() > MOST_KEYFRAMES {
        return Err(format!("{} keyframes, expected at most {MOST_KEYFRAMES}", keyframes.len()));
    }
    let is_number = |keyframe: &RelativeKeyframe| {
        let pose = keyframe.pose.translation.vector.iter().chain(keyframe.pose.rotation.coords.iter());
        pose.chain([&keyframe.gripper.value(), &keyframe.hold]).all(|number| number.is_finite())
    };
    match keyframes.iter().position(|keyframe| !is_number(keyframe)) {
        Some(index) => Err(format!("keyframe {index}: expected finite numbers")),
        None => Ok(()),
    }
}

/// What the task's program would do next.
fn due(episode: &Episode) -> Due {
    if episode.succeeded() {
        return Due::End;
    }
    episode.next_skill().map_or(Due::Unknown, |skill| Due::Skill(skill.name.clone()))
}

/// Performs one primitive.
fn perform(
    episode: &mut Episode,
    (watch, observer): (Watch, &mut dyn Observer),
    action: &Action,
    frame: &Pose,
) -> Performed {
    let mut guards = Guards { watch, met: false, observer };
    let ended = go_through(episode, &mut guards, &action.reference, frame, &action.keyframes);
    Performed { ended, guarded: guards.met, missed: guards.watch.missed - watch.missed }
}

/// A watch over the motions of a primitive, whether the guard has stopped one of them, and who sees them.
struct Guards<'a> {
    watch: Watch,
    met: bool,
    observer: &'a mut dyn Observer,
}

/// Goes through the keyframes of a primitive. Returns why it was not performed to its end, if it was not.
fn go_through(
    episode: &mut Episode,
    guards: &mut Guards<'_>,
    reference: &str,
    frame: &Pose,
    keyframes: &[RelativeKeyframe],
) -> Option<Ended> {
    for (index, keyframe) in keyframes.iter().enumerate() {
        guards.observer.sets_off(reference, index, keyframes.len());
        let RelativeKeyframe { pose, gripper, hold } = keyframe;
        let stride = Stride { target: frame * pose, gripper: *gripper, hold: *hold, about: (reference, index) };
        match stride.go(episode, &mut |world| guards.observer.step(world)) {
            Err(reason) => return Some(reason),
            Ok(Some(_)) => {
                guards.met = true;
                if let Some(reason) = guards.watch.stops(episode, Moment::Guard, reference) {
                    return Some(reason);
                }
            }
            Ok(None) => {}
        }
        if episode.finished_out_of_time() {
            return Some(Ended::TimeOut);
        }
    }
    None
}
