//! A demonstration as a recording at a fixed rate: what the original was fed, interpolated between keyframes.
//!
//! The gripper goes straight from keyframe to keyframe, turning at an even rate, at the planner's speed; it stands
//! still where it rested and where its command changed. The recording begins at the first keyframe: where the hand came
//! from is not known.

use crate::demonstration::{Demonstration, Gripper, Keyframe, Pose};
use crate::keyframe::pose::{exp, log};

/// Frames a second (Niekum et al. 2015: 10 Hz).
pub(super) const RATE: f64 = 10.0;
/// Speed of the gripper, metres a second: the planner's.
const SPEED: f64 = 0.25;
/// Metres that a radian counts: 0.25 m/s is 2.5 rad/s. As in decision D5.
const METRES_PER_RADIAN: f64 = 0.1;
/// Frames in which the gripper opens or closes: half a second.
const GRIPPER_FRAMES: usize = 5;
/// Frames of a way or a rest at most: 100 s. What is longer is a mistake, and would take all memory.
const MOST_FRAMES: f64 = 1000.0;

/// One frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// The gripper, world frame.
    pub(super) pose: Pose,
    /// The reference object as it is now, world frame; between two keyframes that name it, on the way from the one pose
    /// to the other.
    pub(super) object: Pose,
    /// The reference object as it was at its segment's first keyframe (decision D0b), world frame.
    pub(super) frozen: Pose,
    /// 1 open, −1 closed. Not 1 and 0: the dynamics have no intercept, and a coordinate that is never 0 serves as one.
    pub(super) opening: f64,
    /// The command in force.
    pub(super) command: Gripper,
    /// Seconds of rest that begin here.
    pub(super) rest: f64,
    /// The keyframe that the frame leads to or rests at; it names the reference object.
    pub(super) keyframe: usize,
    /// The index of its segment by reference object.
    pub(super) segment: u32,
    /// The keyframe whose state is the world here; past the last, the final state.
    pub(super) state: usize,
}

/// Open as 1, closed as −1.
fn opening(gripper: Gripper) -> f64 {
    match gripper {
        Gripper::Opening(fraction) => 2.0 * fraction - 1.0,
        Gripper::Open(_) => 1.0,
        Gripper::Close(_) => -1.0,
    }
}

/// The point at this share of the way.
fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    exp(from, &(log(from, to) * share))
}

/// Frames of a straight way: one at least.
fn frames_of(from: &Pose, to: &Pose) -> usize {
    let step = log(from, to);
    let (metres, radians) = (step.fixed_rows::<3>(0).into_owned(), step.fixed_rows::<3>(3).into_owned());
    let length = libm::sqrt(metres.dot(&metres)) + METRES_PER_RADIAN * libm::sqrt(radians.dot(&radians));
    (libm::ceil(length / SPEED * RATE).min(MOST_FRAMES) as usize).max(1)
}

/// The frames of a demonstration: two at least.
pub(super) fn record(demonstration: &Demonstration) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut before: Option<&Keyframe> = None;
    let (mut segment, mut frozen) = (0, Pose::identity());
    for (index, keyframe) in demonstration.keyframes().iter().enumerate() {
        let same_object = before.is_some_and(|before| before.reference == keyframe.reference);
        if !same_object {
            segment += u32::from(before.is_some());
            frozen = keyframe.reference_pose;
        }
        let old = before.map_or(keyframe.gripper, |before| before.gripper);
        let from = before.map_or(keyframe.gripper_pose, |before| before.gripper_pose);
        let object_from =
            before.filter(|_| same_object).map_or(keyframe.reference_pose, |before| before.reference_pose);
        let way = if before.is_some() { frames_of(&from, &keyframe.gripper_pose) } else { 1 };
        for frame in 1..=way {
            let share = frame as f64 / way as f64;
            frames.push(Frame {
                pose: between(&from, &keyframe.gripper_pose, share),
                object: between(&object_from, &keyframe.reference_pose, share),
                frozen,
                opening: opening(old),
                command: old,
                rest: 0.0,
                keyframe: index,
                segment,
                state: index,
            });
        }
        let (shut, opened) = (opening(old), opening(keyframe.gripper));
        let turn = if shut == opened { 0 } else { GRIPPER_FRAMES };
        let rest = libm::round((keyframe.hold * RATE).min(MOST_FRAMES)) as usize;
        let arrived = Frame { command: keyframe.gripper, ..frames[frames.len() - 1].clone() };
        for frame in 1..=turn.max(rest) {
            let share = if frame < turn { frame as f64 / turn as f64 } else { 1.0 };
            frames.push(Frame {
                opening: shut + (opened - shut) * share,
                rest: if frame == 1 { keyframe.hold } else { 0.0 },
                state: index + 1,
                ..arrived.clone()
            });
        }
        before = Some(keyframe);
    }
    if frames.len() == 1 {
        frames.push(frames[0].clone());
    }
    frames
}
