//! A hand that is as it was after half a turn about its axis (decision D24): one representative for each hold.
//!
//! From the keyframe at which the hand closes to the one at which it opens, what is in the hand turns with it. So all
//! poses of a hold turn together, or none: turned one by one, a pitcher that is held would be averaged over two grasps.
//! The segments of a hold begin with the one that leads to the grasp. Of the two sequences the one is taken that is
//! nearer in rotation to what is known.

use core::f64::consts::PI;
use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};

use super::hmm::Emission;
use super::interpolate::resample;
use super::learner::KeyframeLearner;
use super::policy::KeyframePolicy;
use crate::demonstration::{Gripper, Pose};
use crate::segment::Segment;
use crate::state::Axis;
use crate::task_model::TaskModel;

/// Half a turn about an axis of the gripper's frame.
fn half_turn(axis: Axis) -> UnitQuaternion<f64> {
    let axis = match axis {
        Axis::X => Vector3::x_axis(),
        Axis::Y => Vector3::y_axis(),
        Axis::Z => Vector3::z_axis(),
    };
    UnitQuaternion::from_axis_angle(&axis, PI)
}

/// An opening below this share of the stroke is a closed hand.
const CLOSED: f64 = 0.5;

fn closes(command: Gripper) -> bool {
    match command {
        Gripper::Close(_) => true,
        Gripper::Open(_) => false,
        Gripper::Opening(share) => share < CLOSED,
    }
}

fn is_closed(segment: &Segment) -> bool {
    segment.keyframes.last().is_some_and(|keyframe| closes(keyframe.gripper))
}

fn is_closed_by(policy: &KeyframePolicy) -> bool {
    policy.hmm.emissions.last().and_then(Emission::gripper_command).is_some_and(closes)
}

/// The segments of each hold, and each other segment by itself.
fn holds(segments: &[Segment]) -> Vec<Range<usize>> {
    let mut holds: Vec<Range<usize>> = Vec::new();
    let mut goes_on = false;
    for (index, segment) in segments.iter().enumerate() {
        match holds.last_mut().filter(|_| goes_on) {
            Some(hold) => hold.end = index + 1,
            None => holds.push(index..index + 1),
        }
        goes_on = is_closed(segment);
    }
    holds
}

fn turn(segments: &mut [Segment], axis: Axis) {
    let turn = half_turn(axis);
    for keyframe in segments.iter_mut().flat_map(|segment| &mut segment.keyframes) {
        keyframe.pose.rotation *= turn;
    }
}

/// How far two paths of as many poses are apart in rotation, radians: the mean; and the same with the first turned.
fn apart(path: &[Pose], known: &[Pose], axis: Axis) -> [f64; 2] {
    let turn = half_turn(axis);
    let mut sums = [0.0; 2];
    for (own, known) in path.iter().zip(known) {
        sums[0] += own.rotation.angle_to(&known.rotation);
        sums[1] += (own.rotation * turn).angle_to(&known.rotation);
    }
    sums.map(|sum| sum / path.len() as f64)
}

impl KeyframeLearner {
    /// The path of a segment: always the same number of poses (decision D5).
    pub(super) fn path_of(&self, segment: &Segment) -> Vec<Pose> {
        let poses: Vec<_> = segment.keyframes.iter().map(|keyframe| keyframe.pose).collect();
        resample(&poses, self.parameters.signature_points, self.parameters.metres_per_radian)
    }

    /// Originals, one list of segments each, with one representative for each hold: that which is nearer to the same
    /// hold of the demonstrations before. A hold is the same that is about the same objects, as often visited before.
    pub fn one_representative(&self, mut originals: Vec<Vec<Segment>>) -> Vec<Vec<Segment>> {
        let Some(axis) = self.half_turn else { return originals };
        for index in 1..originals.len() {
            let (before, rest) = originals.split_at_mut(index);
            let own = &mut rest[0];
            for hold in holds(own) {
                let mut sums = [0.0; 2];
                for place in hold.clone() {
                    let role = role(own, place);
                    let path = self.path_of(&own[place]);
                    for other in before.iter() {
                        let Some(known) = (0..other.len()).find(|known| self::role(other, *known) == role) else {
                            continue;
                        };
                        let [plain, turned] = apart(&path, &self.path_of(&other[known]), axis);
                        sums[0] += plain;
                        sums[1] += turned;
                    }
                }
                if sums[1] < sums[0] {
                    turn(&mut own[hold], axis);
                }
            }
        }
        originals
    }

    /// The segments of a correction with the representative of each hold that is nearer to what the model knows: to the
    /// nearest way of a primitive about the segment's object that ends with the hand as the segment does.
    pub fn as_the_model_has_it(&self, mut segments: Vec<Segment>, model: &TaskModel<Self>) -> Vec<Segment> {
        let Some(axis) = self.half_turn else { return segments };
        for hold in holds(&segments) {
            let mut sums = [0.0; 2];
            for segment in &segments[hold.clone()] {
                let path = self.path_of(segment);
                let nodes = model.nodes_of(&segment.reference).filter_map(|id| model.node(id).ok());
                let ways = nodes.flat_map(|node| node.policies());
                let known = ways.filter(|policy| is_closed_by(policy) == is_closed(segment));
                let least = known.map(|policy| apart(&path, &crate::primitive::Learner::path(self, policy), axis));
                let least = least.reduce(|one, other| [one[0].min(other[0]), one[1].min(other[1])]);
                let [plain, turned] = least.unwrap_or_default();
                sums[0] += plain;
                sums[1] += turned;
            }
            if sums[1] < sums[0] {
                turn(&mut segments[hold], axis);
            }
        }
        segments
    }
}

/// The object of a segment, and how often it was visited before.
fn role(segments: &[Segment], place: usize) -> (&str, usize) {
    let reference = &*segments[place].reference;
    (reference, segments[..place].iter().filter(|segment| *segment.reference == *reference).count())
}
