//! The policy of a primitive: a hidden Markov model over keyframes, and the signature by which policies are compared.

use core::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Matrix6;
use rand::Rng;
use serde::{Deserialize, Serialize};

use super::alignment::Laid;
use super::divergence::FittedModel;
use super::hmm::{Emission, Hmm, Observation};
use super::pose::{self, Tangent};
use super::scatter::laid;
use crate::demonstration::Gripper;
use crate::random::standard_normal;
use crate::segment::{RelativeKeyframe, Segment};

/// A fitted policy `π`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyframePolicy {
    /// The reference object; everything here is in its frame.
    pub(super) reference: Arc<str>,
    /// Each hidden state is a "true" keyframe (paper, "Primitive Specification").
    pub(super) hmm: Hmm,
    /// Seconds of rest at each hidden state: the mean over the keyframes that the state explains.
    pub(super) holds: Vec<f64>,
    /// The model over the interpolated segments (decision D5).
    pub(super) signature: Hmm,
    /// The interpolated segments themselves, which the cross-likelihood needs. They follow from the segments.
    #[serde(skip)]
    pub(super) trajectories: Vec<Vec<Observation>>,
    /// Their log likelihood under the signature, nats.
    pub(super) log_likelihood: f64,
}

/// How a policy is executed (decision D15).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Execution {
    /// Each keyframe is drawn from the scatter of the data, within bounds.
    Sample,
    /// Each keyframe is the mean.
    Mean,
}

/// A segment as its policy sees it: poses and gripper commands.
pub(super) fn observations(segment: &Segment) -> Vec<Observation> {
    let keyframes = segment.keyframes.iter();
    keyframes.map(|keyframe| Observation { pose: keyframe.pose, gripper: Some(keyframe.gripper) }).collect()
}

/// The greatest standard deviation of a sampled position, metres. Above it grasps fail (decision D15).
const SAMPLED_POSITION: f64 = 0.005;
/// The greatest standard deviation of a sampled rotation, radians: 2°.
const SAMPLED_ROTATION: f64 = 2.0 * PI / 180.0;
/// The 95th percentile of χ² with 6 degrees of freedom. A draw beyond it is drawn again.
pub(crate) const CHI_SQUARED_6_95: f64 = 12.591_587_243_743_977;

impl KeyframePolicy {
    /// The reference object.
    pub fn reference(&self) -> &Arc<str> {
        &self.reference
    }

    /// The model over keyframes.
    pub fn hmm(&self) -> &Hmm {
        &self.hmm
    }

    /// The log-likelihood of a segment's keyframes, nats; negative infinity where they are impossible. The segment is
    /// about the policy's reference object.
    pub fn log_likelihood_of(&self, segment: &Segment) -> f64 {
        self.hmm.log_likelihood(&observations(segment))
    }

    /// The keyframes of one execution, relative to the reference object: one per hidden state, in order.
    pub fn keyframes(&self, execution: Execution, rng: &mut impl Rng) -> Vec<RelativeKeyframe> {
        let mut keyframes = self.mean_keyframes();
        if execution == Execution::Sample {
            for (keyframe, emission) in keyframes.iter_mut().zip(&self.hmm.emissions) {
                keyframe.pose = pose::exp(&keyframe.pose, &draw(&emission.scatter, rng));
            }
        }
        keyframes
    }

    /// The keyframes of the mean execution, one per hidden state.
    pub fn mean_keyframes(&self) -> Vec<RelativeKeyframe> {
        let states = self.hmm.emissions.iter().zip(&self.holds);
        let keyframe = |(emission, hold): (&Emission, &f64)| RelativeKeyframe {
            pose: emission.mean,
            gripper: emission.gripper_command().expect("a policy's model is fitted with gripper commands"),
            hold: *hold,
        };
        states.map(keyframe).collect()
    }

    /// The signature with the segments that it was fitted to.
    pub(super) fn explained(&self) -> FittedModel<'_, Emission> {
        FittedModel::new(&self.signature, &self.trajectories, self.log_likelihood)
    }

    /// Whether the gripper is closed when the policy has run to its end (decision D6b).
    pub(super) fn ends_closed(&self) -> bool {
        let last = self.hmm.emissions.last().and_then(Emission::gripper_command);
        last.is_some_and(|command| matches!(command, Gripper::Close(_)))
    }

    /// The mean keyframes as they are laid into others.
    pub(super) fn laid(&self) -> Vec<Laid> {
        laid(self.mean_keyframes().into_iter().map(|keyframe| (keyframe.pose, keyframe.gripper)))
    }

    /// The poses of the mean keyframes.
    pub(super) fn means(&self) -> Vec<nalgebra::Isometry3<f64>> {
        self.hmm.emissions.iter().map(|emission| emission.mean).collect()
    }
}

/// A draw from the scatter of the data about the mean. The scatter is shrunk to the greatest deviations, and a draw
/// beyond the 95th percentile is drawn again.
pub(crate) fn draw(scatter: &Matrix6<f64>, rng: &mut impl Rng) -> Tangent {
    let factor = semidefinite_cholesky(scatter);
    let deviation = |from: usize| libm::sqrt((from..from + 3).map(|axis| scatter[(axis, axis)]).fold(0.0, f64::max));
    let shrink = |deviation: f64, greatest: f64| if deviation > greatest { greatest / deviation } else { 1.0 };
    let (position, rotation) = (shrink(deviation(0), SAMPLED_POSITION), shrink(deviation(3), SAMPLED_ROTATION));
    loop {
        let normal = Tangent::from_fn(|_, _| standard_normal(rng));
        if normal.norm_squared() <= CHI_SQUARED_6_95 {
            let drawn = factor * normal;
            return Tangent::from_fn(|axis, _| drawn[axis] * if axis < 3 { position } else { rotation });
        }
    }
}

/// L with L Lᵀ = m for a positive *semi*definite m. A pivot that is only rounding error gives a column of zeros.
fn semidefinite_cholesky(matrix: &Matrix6<f64>) -> Matrix6<f64> {
    let smallest = f64::EPSILON * matrix.trace().max(f64::MIN_POSITIVE);
    let mut factor = Matrix6::zeros();
    for column in 0..6 {
        let pivot =
            matrix[(column, column)] - (0..column).map(|k| factor[(column, k)] * factor[(column, k)]).sum::<f64>();
        if pivot <= smallest {
            continue;
        }
        let root = libm::sqrt(pivot);
        factor[(column, column)] = root;
        for row in column + 1..6 {
            let rest = matrix[(row, column)] - (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum::<f64>();
            factor[(row, column)] = rest / root;
        }
    }
    factor
}
