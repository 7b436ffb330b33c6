//! A primitive of a few keyframes, its policy, and changes of it.

use situ::demonstration::{Gripper, Pose};
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::policy::KeyframePolicy;
use situ::primitive::Learner;
use situ::segment::{RelativeKeyframe, Segment};
use situ::state::{Feature, Schema, State};

/// A pick beside an object: above it, beside it on the way down, on it, up again, and off to the side. Metres.
pub(crate) const PLACES: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.30], [0.0, 0.15, 0.15], [0.0, 0.0, 0.02], [0.0, 0.0, 0.25], [0.2, 0.0, 0.25]];

pub(crate) fn keyframe(place: [f64; 3], closed: bool) -> RelativeKeyframe {
    let gripper = if closed { Gripper::Close(20.0) } else { Gripper::Open(0.08) };
    RelativeKeyframe { pose: Pose::translation(place[0], place[1], place[2]), gripper, hold: 0.5 }
}

/// The keyframes of the pick.
pub(crate) fn pick() -> Vec<RelativeKeyframe> {
    PLACES.iter().enumerate().map(|(index, place)| keyframe(*place, index >= 2)).collect()
}

pub(crate) fn segment(keyframes: Vec<RelativeKeyframe>) -> Segment {
    Segment { reference: "cup".into(), start: State::new([0.0]), keyframes, narration: Vec::new() }
}

/// The policy of these segments.
pub(crate) fn policy(segments: &[&Segment]) -> KeyframePolicy {
    let schema = Schema::new(vec![Feature { name: "s".to_owned(), scale: 1.0 }]).unwrap();
    let learner = KeyframeLearner::new(&schema, KeyframeParameters::default());
    let calibration = learner.calibrate(&[], &mut Default::default()).unwrap();
    learner.fit_policy(segments, &calibration, &mut Default::default()).unwrap()
}

/// The distance of two positions, metres.
pub(crate) fn apart(left: &Pose, right: &Pose) -> f64 {
    (left.translation.vector - right.translation.vector).norm()
}

/// The keyframe, moved in the frame of the reference object.
pub(crate) fn moved(keyframe: &RelativeKeyframe, by: [f64; 3]) -> RelativeKeyframe {
    RelativeKeyframe { pose: Pose::translation(by[0], by[1], by[2]) * keyframe.pose, ..*keyframe }
}
