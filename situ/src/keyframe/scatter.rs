//! How far apart the same keyframes of one teacher are (decision D21): the unit in which a displacement means
//! something.

use core::f64::consts::PI;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::alignment::{Laid, partners};
use super::hmm::HmmParameters;
use super::pose::log;
use super::roles::{grouped, pooled};
use crate::demonstration::{Gripper, Pose};
use crate::segment::Segment;

/// Standard deviations of one keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Of positions along each axis, metres.
    pub position: f64,
    /// Of rotations about the axes of the gripper's frame, radians. A hand over a table is free about its approach.
    pub rotation: [f64; 3],
}

/// The scatter of a teacher, estimated from segments of the same role in the originals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// At keyframes at which the hand closes or opens.
    pub contact: Deviation,
    /// At all others.
    pub free: Deviation,
    /// Whether an estimate was outside of what is believed of a teacher.
    pub is_clamped: bool,
}

/// Decision D21: the parameters of the estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterParameters {
    /// What is believed before anything is seen: metres, radians.
    pub prior: (f64, f64),
    /// How many pairs of keyframes the prior counts for.
    pub prior_pairs: f64,
    /// The least scatter: a script without noise has none.
    pub least: (f64, f64),
    /// The greatest.
    pub greatest: (f64, f64),
}

impl ScatterParameters {
    /// The scatter that is believed before anything is seen, whatever is seen: that of one teacher.
    pub fn fixed() -> Self {
        let prior = Self::default().prior;
        Self { least: prior, greatest: prior, ..Self::default() }
    }
}

impl Default for ScatterParameters {
    /// The prior is that of decision D12.
    fn default() -> Self {
        Self {
            prior: (0.02, 9.0 * PI / 180.0),
            prior_pairs: 3.0,
            least: (0.005, 3.0 * PI / 180.0),
            greatest: (0.04, 60.0 * PI / 180.0),
        }
    }
}

/// The median of χ² with 3 degrees of freedom: what the median of squared lengths is, in units of one axis.
const CHI_SQUARED_3_MEDIAN: f64 = 2.365_973_884_375_338;
/// The same with 1: of squares along one axis.
const CHI_SQUARED_1_MEDIAN: f64 = 0.454_936_423_119_572_7;

impl Scatter {
    /// The standard deviation of a position, metres.
    pub(super) fn position(&self, is_contact: bool) -> f64 {
        if is_contact { self.contact.position } else { self.free.position }
    }

    /// The parameters of a signature by this teacher: a floor that is no lower than the scatter.
    pub(super) fn floor(&self, parameters: &HmmParameters) -> HmmParameters {
        HmmParameters {
            position_floor: parameters.position_floor.max(self.contact.position).max(self.free.position),
            rotation_floor: core::array::from_fn(|axis| {
                parameters.rotation_floor[axis].max(self.contact.rotation[axis]).max(self.free.rotation[axis])
            }),
            ..*parameters
        }
    }
}

/// The variance of one axis from squares over pairs, both of which scatter: by their median, which a needless keyframe
/// or a wrong partner does not move. `of_one` is the median where the variance is 1.
fn variance(mut squares: Vec<f64>, of_one: f64) -> f64 {
    if squares.is_empty() {
        return 0.0;
    }
    squares.sort_by(f64::total_cmp);
    let middle = squares.len() / 2;
    let median = if squares.len() % 2 == 1 { squares[middle] } else { 0.5 * (squares[middle - 1] + squares[middle]) };
    0.5 * median / of_one
}

/// Keyframes as they are laid. At the first of them nothing is known to change.
pub(super) fn laid(keyframes: impl Iterator<Item = (Pose, Gripper)>) -> Vec<Laid> {
    let mut before: Option<Gripper> = None;
    let lay = |(pose, gripper)| {
        let is_contact = before.replace(gripper).is_some_and(|before| before.is_moved_by(gripper));
        Laid { pose, is_contact }
    };
    keyframes.map(lay).collect()
}

impl ScatterParameters {
    /// The scatter of the teacher of these originals.
    pub(super) fn of(&self, originals: &[&[Arc<Segment>]]) -> Scatter {
        let (segments, roles) = pooled(originals);
        // Contacts, then the others: squared distances in position, and squared angles about each axis.
        let mut squares: [[Vec<f64>; 4]; 2] = Default::default();
        for members in grouped(&roles).values() {
            let keyframes = |index: &usize| {
                laid(segments[*index].keyframes.iter().map(|keyframe| (keyframe.pose, keyframe.gripper)))
            };
            let shown: Vec<Vec<Laid>> = members.iter().map(keyframes).collect();
            for (index, left) in shown.iter().enumerate() {
                for right in &shown[index + 1..] {
                    for (one, other) in partners(left, right) {
                        let (one, other) = (&left[one], &right[other]);
                        let apart = log(&one.pose, &other.pose);
                        let kind = &mut squares[usize::from(!(one.is_contact && other.is_contact))];
                        kind[0].push(apart.fixed_rows::<3>(0).norm_squared());
                        for axis in 0..3 {
                            kind[1 + axis].push(apart[3 + axis] * apart[3 + axis]);
                        }
                    }
                }
            }
        }
        let mut is_clamped = false;
        let (prior, least, greatest) = (self.prior, self.least, self.greatest);
        let mut deviation = |squares: Vec<f64>, of_one: f64, prior: f64, (least, greatest): (f64, f64)| {
            let seen = squares.len() as f64;
            let sum = seen * variance(squares, of_one) + self.prior_pairs * prior * prior;
            let deviation = libm::sqrt(sum / (seen + self.prior_pairs));
            let clamped = deviation.clamp(least, greatest);
            is_clamped |= clamped != deviation;
            clamped
        };
        let mut of = |[positions, x, y, z]: [Vec<f64>; 4]| Deviation {
            position: deviation(positions, CHI_SQUARED_3_MEDIAN, prior.0, (least.0, greatest.0)),
            rotation: [x, y, z].map(|angles| deviation(angles, CHI_SQUARED_1_MEDIAN, prior.1, (least.1, greatest.1))),
        };
        let [contact, free] = squares;
        let (contact, free) = (of(contact), of(free));
        Scatter { contact, free, is_clamped }
    }
}
