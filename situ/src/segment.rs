//! Segments: the keyframes of a demonstration about one reference object, relative to it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::demonstration::{Gripper, Pose};
use crate::state::State;

/// A keyframe relative to its segment's reference object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelativeKeyframe {
    /// Pose of the gripper in the frame of the reference object, frozen at the segment's first keyframe (decision D0b).
    pub pose: Pose,
    /// The gripper command in force from this keyframe on.
    pub gripper: Gripper,
    /// Seconds of rest at the keyframe.
    pub hold: f64,
}

/// A segment `d` of a demonstration: the keyframes about one reference object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// The reference object.
    pub reference: Arc<str>,
    /// The state `S[i]`: the world before the motion to the segment's first keyframe (decision D0).
    pub start: State,
    /// At least one keyframe, relative to the reference object.
    pub keyframes: Vec<RelativeKeyframe>,
    /// What the teacher called it: one name, or several in order where skills on one object follow each other. Empty
    /// unless every keyframe was named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub narration: Vec<Arc<str>>,
}
