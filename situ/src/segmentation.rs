//! Segmentation of a keyframe demonstration by the reference object that the teacher names (paper, "Segmentation"), or
//! by what the teacher says of each keyframe.

use std::sync::Arc;

use crate::demonstration::{Demonstration, Keyframe};
use crate::segment::{RelativeKeyframe, Segment};

/// Splits a demonstration wherever the teacher names a reference object: another one, or the same one anew (decision
/// D0c′).
///
/// Each segment's keyframes are expressed in the frame that its reference object had at the segment's *first* keyframe:
/// an object that moves with the hand would otherwise make the lift after a grasp vanish (decision D0b). Consecutive
/// skills on one object are one segment where the object is not named anew (decision D0c). A demonstration has a
/// keyframe, so there is at least one segment.
pub fn by_reference_object(demonstration: &Demonstration) -> Vec<Segment> {
    demonstration.keyframes().chunk_by(goes_on).map(segment).collect()
}

/// The number of keyframes of each segment of [`by_reference_object`], in order.
pub fn lengths(demonstration: &Demonstration) -> Vec<usize> {
    demonstration.keyframes().chunk_by(goes_on).map(<[_]>::len).collect()
}

/// Whether no reference object is named at the second of two keyframes.
fn goes_on(left: &Keyframe, right: &Keyframe) -> bool {
    left.reference == right.reference && !right.announced
}

/// Splits a demonstration wherever the reference object or the teacher's name for what is being done changes.
pub fn by_narration(demonstration: &Demonstration) -> Vec<Segment> {
    let is_one = |left: &Keyframe, right: &Keyframe| goes_on(left, right) && left.narration == right.narration;
    demonstration.keyframes().chunk_by(is_one).map(segment).collect()
}

/// The segment of a run of keyframes about one reference object.
fn segment(run: &[Keyframe]) -> Segment {
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
        narration: narration(run),
    }
}

fn narration(run: &[Keyframe]) -> Vec<Arc<str>> {
    let mut names =
        run.iter().map(|keyframe| keyframe.narration.clone()).collect::<Option<Vec<_>>>().unwrap_or_default();
    names.dedup();
    names
}
