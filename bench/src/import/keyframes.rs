//! Which frames of an episode are its keyframes.
//!
//! Where a column marks them, those: a frame whose mark is not 0 and not that of the frame before. Otherwise the frames
//! at which the gripper closes or opens, and between them the points of a polyline that no frame is farther from than
//! the tolerance. The first frame is none, since nothing has moved yet. The last is one, unless it is as good as the
//! keyframe before.

use situ::demonstration::{Gripper, Pose};

use crate::import::frames::Frame;
use crate::import::mapping::Mapping;
use crate::import::polyline::{Tolerance, polyline};

/// Why a frame is a keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    Marked,
    Closes,
    Opens,
    Bends,
    Ends,
}

impl Reason {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Marked => "marked",
            Self::Closes => "closes",
            Self::Opens => "opens",
            Self::Bends => "the way bends",
            Self::Ends => "the end",
        }
    }
}

/// A frame that is a keyframe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picked {
    pub(super) frame: usize,
    pub(super) reason: Reason,
}

/// Whether the gripper is closed, frame by frame. Between the two thresholds it stays what it was; at the beginning it
/// is what it is nearer to. A gripper of which nothing is recorded is open.
pub(super) fn closed(frames: &[Frame], mapping: &Mapping) -> Vec<bool> {
    let length = mapping.keys.opening.unit.length();
    let per_unit = length.map_or(1.0, |length| length.per_metre());
    let (below, above) = (mapping.close_below() / per_unit, mapping.open_above() / per_unit);
    let mut is_closed = None;
    let mut of = |frame: &Frame| {
        let before = is_closed;
        let by_number = |value: f64| match before {
            _ if value < below => true,
            _ if value > above => false,
            Some(before) => before,
            None => value < f64::midpoint(below, above),
        };
        let now = match (frame.command, frame.opening) {
            (Some(Gripper::Close(_)), _) => true,
            (Some(Gripper::Open(_)), _) if length.is_none() => false,
            (Some(Gripper::Opening(_)), _) if length.is_some() => before.unwrap_or(false),
            (Some(Gripper::Opening(value) | Gripper::Open(value)), _) | (None, Some(value)) => by_number(value),
            (None, None) => false,
        };
        is_closed = Some(now);
        now
    };
    frames.iter().map(&mut of).collect()
}

/// The keyframes of an episode's frames, in order. Marks count where there are any.
pub(super) fn pick(frames: &[Frame], closed: &[bool], mapping: &Mapping) -> Vec<Picked> {
    let marked = marked(frames);
    if !marked.is_empty() {
        return marked;
    }
    let keys = &mapping.keys.keyframes;
    let tolerance = Tolerance { metres: keys.metres, radians: keys.radians };
    let Some(last) = frames.len().checked_sub(1) else { return Vec::new() };
    let changes = (1..frames.len()).filter(|frame| closed[*frame] != closed[frame - 1]);
    let reason = |frame: usize| if closed[frame] { Reason::Closes } else { Reason::Opens };
    let mut ends: Vec<Picked> = changes.map(|frame| Picked { frame, reason: reason(frame) }).collect();
    if ends.last().is_none_or(|end| end.frame != last) {
        ends.push(Picked { frame: last, reason: Reason::Ends });
    }
    let poses: Vec<Pose> = frames.iter().map(|frame| frame.hand).collect();
    let (mut picked, mut from): (Vec<Picked>, usize) = (Vec::new(), 0);
    for end in ends {
        let points = polyline(&poses[from..=end.frame], tolerance);
        let inner = points.iter().filter(|point| **point > 0 && from + **point < end.frame);
        let before = picked.len();
        picked.extend(inner.map(|point| Picked { frame: from + point, reason: Reason::Bends }));
        let is_new = picked.len() > before || tolerance.apart(&poses[from], &poses[end.frame]) > 1.0;
        if end.reason != Reason::Ends || is_new || picked.is_empty() {
            picked.push(end);
        }
        from = end.frame;
    }
    picked
}

fn marked(frames: &[Frame]) -> Vec<Picked> {
    let mark = |frame: usize| frames[frame].mark.unwrap_or(0.0);
    let is_new = |frame: &usize| mark(*frame) != 0.0 && (*frame == 0 || mark(*frame) != mark(frame - 1));
    (0..frames.len()).filter(is_new).map(|frame| Picked { frame, reason: Reason::Marked }).collect()
}

/// The last frame at which the gripper is still at rest at a keyframe, before the frame `end`. From there the motion to
/// the next keyframe begins.
pub(super) fn departure(frames: &[Frame], at: usize, end: usize, mapping: &Mapping) -> usize {
    let keys = &mapping.keys.keyframes;
    let pose = &frames[at].hand;
    let rests = |frame: &usize| {
        let hand = &frames[*frame].hand;
        (hand.translation.vector - pose.translation.vector).norm() <= keys.rest_metres
            && hand.rotation.angle_to(&pose.rotation) <= keys.rest_radians
    };
    (at + 1..end).take_while(rests).last().unwrap_or(at)
}
