//! Segmentation of a keyframe demonstration by change of reference object (paper, "Segmentation").

use crate::demonstration::{Demonstration, RelativeKeyframe, Segment};

/// Splits a demonstration wherever the named reference object changes.
///
/// Each segment's keyframes are expressed in the frame that its reference object had at the segment's *first* keyframe:
/// an object that moves with the hand would otherwise make the lift after a grasp vanish (decision D0b). Consecutive
/// skills on one object become one segment (decision D0c). A demonstration has a keyframe, so there is at least one segment.
pub fn by_reference_object(demonstration: &Demonstration) -> Vec<Segment> {
    demonstration
        .keyframes()
        .chunk_by(|left, right| left.reference == right.reference)
        .map(|run| {
            let frame = run[0].reference_pose.inverse();
            Segment {
                reference: run[0].reference.clone(),
                start: run[0].state.clone(),
                keyframes: run
                    .iter()
                    .map(|keyframe| RelativeKeyframe {
                        pose: frame * keyframe.gripper_pose,
                        gripper: keyframe.gripper,
                        hold: keyframe.hold,
                    })
                    .collect(),
            }
        })
        .collect()
}
