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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::demonstration::Kind;
    use crate::state::{Feature, Schema, State};

    /// One keyframe each: a place on the x axis, metres; a command; and a rest, seconds.
    pub(crate) fn shown(keyframes: &[(f64, Gripper, f64)]) -> Vec<Frame> {
        let schema = Schema::new(vec![Feature { name: "x".to_owned(), scale: 1.0 }]).unwrap();
        let keyframe = |&(x, gripper, hold): &(f64, Gripper, f64)| Keyframe {
            reference: "cup".into(),
            reference_pose: Pose::identity(),
            gripper_pose: Pose::translation(x, 0.0, 0.0),
            gripper,
            hold,
            state: State::new([0.0]),
            announced: false,
            narration: None,
        };
        let keyframes = keyframes.iter().map(keyframe).collect();
        let end = State::new([0.0]);
        record(&Demonstration::new("shown", Kind::Original, &schema, keyframes, end, true).unwrap())
    }

    #[test]
    fn the_hand_moves_evenly_turns_evenly_and_rests() {
        let (open, shut) = (Gripper::Open(0.08), Gripper::Close(20.0));
        // 10 cm at 25 cm/s are four frames, half a second of turning five, and a second of rest ten.
        let frames = shown(&[(0.0, open, 0.0), (0.1, shut, 0.0), (0.1, shut, 1.0)]);
        let places: Vec<f64> = frames.iter().map(|frame| frame.pose.translation.x).collect();
        let openings: Vec<f64> = frames.iter().map(|frame| frame.opening).collect();
        let near = |found: &[f64], expected: &[f64]| {
            let pairs = found.iter().zip(expected);
            found.len() == expected.len() && pairs.into_iter().all(|(found, expected)| (found - expected).abs() < 1e-12)
        };
        let (way, turn, stay) = ([0.0, 0.025, 0.05, 0.075, 0.1], [0.6, 0.2, -0.2, -0.6, -1.0], 11);
        assert!(near(&places, &[&way[..], &[0.1; 5], &vec![0.1; stay]].concat()), "{places:?}");
        assert!(near(&openings, &[&[1.0; 5][..], &turn, &vec![-1.0; stay]].concat()), "{openings:?}");
        let rests: Vec<(usize, f64)> =
            frames.iter().map(|frame| frame.rest).enumerate().filter(|(_, rest)| *rest > 0.0).collect();
        assert_eq!(rests, [(11, 1.0)]);
        let commands: Vec<bool> = frames.iter().map(|frame| frame.command == shut).collect();
        assert_eq!(commands, [vec![false; 5], vec![true; 5 + stay]].concat());
    }
}
