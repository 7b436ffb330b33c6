//! A demonstration as a recording at a fixed rate, which the original needs, interpolated between keyframes.
//!
//! The gripper goes straight from keyframe to keyframe at the planner's speed and turns at an even rate. It stands
//! still where it rested and where its command changed. The recording begins at the first keyframe, because it is
//! unknown where the hand came from.

use crate::demonstration::{Demonstration, Gripper, Keyframe, Pose};
use crate::keyframe::pose::{METRES_PER_RADIAN, arc_length, exp, log};

/// Frames per second (Niekum et al. 2015: 10 Hz).
pub(super) const RATE: f64 = 10.0;
/// The speed of the gripper, metres per second: that of the planner. A turn counts as in decision D5, so this is
/// 2.5 rad/s.
const SPEED: f64 = 0.25;
/// The frames in which the gripper opens or closes: half a second.
const GRIPPER_FRAMES: usize = 5;
/// The greatest number of frames of a way or a rest: 100 s. A longer one is a mistake, and would use up the memory.
const MOST_FRAMES: f64 = 1000.0;

/// One frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// The pose of the gripper, world frame.
    pub(super) pose: Pose,
    /// The pose of the reference object now, world frame. Between two keyframes that name it, it moves from the one
    /// pose to the other.
    pub(super) object: Pose,
    /// The pose of the reference object at its segment's first keyframe (decision D0b), world frame.
    pub(super) frozen: Pose,
    /// 1 is open, −1 is closed. It is not 1 and 0, because the dynamics have no intercept: a coordinate that is never 0
    /// replaces it.
    pub(super) opening: f64,
    /// The command in force.
    pub(super) command: Gripper,
    /// Seconds of rest that begin here.
    pub(super) rest: f64,
    /// The index of the keyframe that the frame leads to or rests at. That keyframe names the reference object.
    pub(super) keyframe: usize,
    /// The index of its segment by reference object.
    pub(super) segment: u32,
    /// The index of the keyframe whose state the world has here. After the last keyframe it is the final state.
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

/// The pose at this share of the way.
fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    exp(from, &(log(from, to) * share))
}

/// The number of frames of a straight way, at least one.
fn frames_of(from: &Pose, to: &Pose) -> usize {
    let length = arc_length(&log(from, to), METRES_PER_RADIAN);
    (libm::ceil(length / SPEED * RATE).min(MOST_FRAMES) as usize).max(1)
}

/// The frames of a demonstration, at least two.
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
