//! Poses as points of R³ × S³, as decision D13 defines them: logarithm, mean, and the path through several poses.

use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6};
use situ::demonstration::Pose;

/// The greatest number of steps towards a mean, and the length at which they end, radians.
const STEPS: usize = 10;
const REST: f64 = 1e-9;

/// The logarithm of `pose` at `base`: metres in the frame of the object, then the rotation vector in the frame of the
/// base.
pub(crate) fn log(base: &Pose, pose: &Pose) -> Vector6<f64> {
    let metres = pose.translation.vector - base.translation.vector;
    let radians = (base.rotation.inverse() * pose.rotation).scaled_axis();
    Vector6::new(metres.x, metres.y, metres.z, radians.x, radians.y, radians.z)
}

/// The dominant axis of Σ w q qᵀ. The search for a mean starts here if there is no better guess.
pub(crate) fn dominant(weighted: &[(f64, Pose)]) -> UnitQuaternion<f64> {
    let mut sum = Matrix4::zeros();
    for (weight, pose) in weighted {
        sum += pose.rotation.coords * pose.rotation.coords.transpose() * *weight;
    }
    let eigen = sum.symmetric_eigen();
    UnitQuaternion::new_normalize(Quaternion::from(eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()))
}

/// The pose about which the weighted logarithms sum to 0 (Karcher mean).
pub(crate) fn mean(weighted: &[(f64, Pose)], start: UnitQuaternion<f64>) -> Pose {
    let total: f64 = weighted.iter().map(|(weight, _)| weight).sum();
    let position: Vector3<f64> = weighted.iter().map(|(weight, pose)| pose.translation.vector * *weight).sum();
    let mut rotation = start;
    for _ in 0..STEPS {
        let turns = weighted.iter().map(|(weight, pose)| (rotation.inverse() * pose.rotation).scaled_axis() * *weight);
        let step = turns.sum::<Vector3<f64>>() / total;
        rotation *= UnitQuaternion::from_scaled_axis(step);
        if step.norm() < REST {
            break;
        }
    }
    Pose::from_parts(Translation3::from(position / total), rotation)
}

/// `count` poses along the path through these, even in arc length, where a radian counts `metres_per_radian` (decision
/// D5).
pub(crate) fn resampled(poses: &[Pose], count: usize, metres_per_radian: f64) -> Vec<Pose> {
    let lengths = poses.windows(2).map(|pair| {
        let leg = log(&pair[0], &pair[1]);
        leg.fixed_rows::<3>(0).norm() + metres_per_radian * leg.fixed_rows::<3>(3).norm()
    });
    let lengths: Vec<f64> = lengths.collect();
    let whole: f64 = lengths.iter().sum();
    let at = |index: usize| {
        let mut rest = whole * index as f64 / (count - 1) as f64;
        for (leg, length) in lengths.iter().enumerate() {
            if rest <= *length && *length > 0.0 {
                let step = log(&poses[leg], &poses[leg + 1]) * (rest / length);
                let turn = UnitQuaternion::from_scaled_axis(step.fixed_rows::<3>(3).into_owned());
                let there = poses[leg].translation.vector + step.fixed_rows::<3>(0);
                return Pose::from_parts(Translation3::from(there), poses[leg].rotation * turn);
            }
            rest -= length;
        }
        if whole > 0.0 { poses[poses.len() - 1] } else { poses[0] }
    };
    (0..count).map(at).collect()
}
