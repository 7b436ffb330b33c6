//! Where the robot had stopped before a correction, in the words of the original that it followed.
//!
//! The attempt is a rollout of a policy and no demonstration, so its own segments have no names. A segment of the
//! original counts as completed at the first moment after the one before at which the gripper is where that segment
//! ends, seen from its object as it stood when the segment began, and as closed or open as there. What was not
//! completed when the person took over is what was under way, if the gripper had moved since.

use crate::import::drawn::SegmentEnd;
use crate::import::frames::Frame;
use crate::import::polyline::Tolerance;

/// Where an attempt stopped, in segments of the original.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Reached {
    /// The last one that was completed.
    pub(super) after: Option<u32>,
    /// The one under way.
    pub(super) interrupted: Option<u32>,
}

/// How far an attempt came along an original whose segments end so.
pub(super) fn reached(frames: &[Frame], closed: &[bool], ends: &[SegmentEnd], tolerance: Tolerance) -> Reached {
    let (mut done, mut begun): (usize, usize) = (0, 0);
    for (index, frame) in frames.iter().enumerate() {
        let Some(end) = ends.get(done) else { break };
        let expected = frames[begun].objects[end.object] * end.pose;
        if closed[index] == end.closed && tolerance.apart(&frame.hand, &expected) <= 1.0 {
            (done, begun) = (done + 1, index);
        }
    }
    let has_moved = frames
        .get(begun..)
        .unwrap_or_default()
        .iter()
        .any(|frame| frames.get(begun).is_some_and(|first| tolerance.apart(&first.hand, &frame.hand) > 1.0));
    let number = |index: usize| u32::try_from(index).ok();
    Reached {
        after: done.checked_sub(1).and_then(number),
        interrupted: (done < ends.len() && has_moved).then(|| number(done)).flatten(),
    }
}
