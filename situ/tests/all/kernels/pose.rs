//! Logarithm, exponential and mean of poses.

use core::f64::consts::PI;

use nalgebra::{Quaternion, UnitQuaternion};
use proptest::prelude::*;
use situ::demonstration::Pose;
use situ::keyframe::pose::{Tangent, exp, karcher_mean, log, rotation_log};

use crate::kernels::sample::{pose, pose_of, vector};

/// The largest difference of two poses: metres, and the length of the difference of the quaternions up to sign.
fn apart(left: &Pose, right: &Pose) -> f64 {
    let (l, r) = (left.rotation.coords, right.rotation.coords);
    let turn = (l - r).norm().min((l + r).norm());
    (left.translation.vector - right.translation.vector).norm().max(turn)
}

fn negated(pose: &Pose) -> Pose {
    let q = pose.rotation.quaternion();
    Pose::from_parts(pose.translation, UnitQuaternion::new_unchecked(Quaternion::new(-q.w, -q.i, -q.j, -q.k)))
}

proptest! {
    #[test]
    fn exponential_undoes_logarithm(base in pose(), other in pose()) {
        prop_assert!(apart(&exp(&base, &log(&base, &other)), &other) < 1e-14);
    }

    /// Up to half a turn, and small vectors, where the series is used.
    #[test]
    fn logarithm_undoes_exponential(base in pose(), step in (vector(1.0), vector(1.8)), scale in 0..12_i32) {
        let scale = 10.0_f64.powi(-scale);
        let tangent = Tangent::from_fn(|axis, _| if axis < 3 { step.0[axis] } else { scale * step.1[axis - 3] });
        let rotation = tangent.fixed_rows::<3>(3).norm();
        prop_assume!(rotation < 3.1);
        let back = log(&base, &exp(&base, &tangent)) - tangent;
        prop_assert!(back.fixed_rows::<3>(0).norm() < 1e-14);
        prop_assert!(back.fixed_rows::<3>(3).norm() < 2e-14 * rotation.max(0.1) / (3.2 - rotation));
    }

    #[test]
    fn both_signs_of_a_quaternion_are_one_rotation(base in pose(), other in pose()) {
        prop_assert_eq!(log(&base, &negated(&other)), log(&base, &other));
        prop_assert_eq!(log(&negated(&base), &other), log(&base, &other));
    }

    /// At the mean the weighted logarithms sum to 0. Within a quarter turn that determines the mean.
    #[test]
    fn the_mean_is_stationary(
        base in pose(),
        steps in prop::collection::vec((vector(0.5), vector(0.6), 0.01..1.0, any::<bool>()), 1..8),
    ) {
        let (mut poses, mut weights) = (Vec::new(), Vec::new());
        for (position, turn, weight, sign) in steps {
            let near = base * pose_of(position, turn);
            poses.push(if sign { near } else { negated(&near) });
            weights.push(weight);
        }
        let mean = karcher_mean(&poses, &weights);
        let sum: Tangent = poses.iter().zip(&weights).map(|(pose, weight)| log(&mean, pose) * *weight).sum();
        prop_assert!(sum.norm() < 1e-9 * weights.iter().sum::<f64>(), "{sum}");
        poses.reverse();
        weights.reverse();
        prop_assert!(apart(&karcher_mean(&poses, &weights), &mean) < 1e-9);
    }
}

/// At half a turn both signs are equally near. The choice must not depend on the sign of the input.
#[test]
fn half_a_turn_has_one_logarithm() {
    for (i, j, k) in [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, -0.8), (-0.6, 0.8, 0.0)] {
        let one = rotation_log(&UnitQuaternion::new_unchecked(Quaternion::new(0.0, i, j, k)));
        let other = rotation_log(&UnitQuaternion::new_unchecked(Quaternion::new(0.0, -i, -j, -k)));
        assert_eq!(one, other);
        assert!((one.norm() - std::f64::consts::PI).abs() < 1e-15);
    }
}

#[test]
fn a_mean_of_nothing_is_the_identity_and_of_one_pose_itself() {
    assert_eq!(karcher_mean(&[], &[]), Pose::identity());
    let one = pose_of([0.1, 0.2, 0.3], [1.0, -2.0, 0.5]);
    assert_eq!(karcher_mean(&[one], &[0.0]), Pose::identity());
    assert!(apart(&karcher_mean(&[one, one], &[0.3, 1e-9]), &one) < 1e-15);
    // Opposite ends of a half turn have no chordal mean, but they have a mean: one of the two poses in the middle.
    let mean = karcher_mean(&[Pose::identity(), pose_of([0.0; 3], [0.0, 0.0, 3.1])], &[1.0, 1.0]);
    assert!((log(&Pose::identity(), &mean).norm() - 1.55).abs() < 1e-9);
}

/// The length of the logarithm is the angle, by the arc tangent of the standard library, for all angles and to the last
/// digits.
#[test]
fn the_logarithm_loses_no_digit_at_any_angle() {
    let angles = (0..=1000).map(|step| f64::from(step) / 1000.0 * PI).chain((1..300).map(|step| 10_f64.powi(-step)));
    for angle in angles {
        for axis in [[1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0]] {
            let [i, j, k] = axis.map(|part| part * (0.5 * angle).sin());
            let quaternion = Quaternion::new((0.5 * angle).cos(), i, j, k);
            let expected = 2.0 * (i * i + j * j + k * k).sqrt().atan2(quaternion.w);
            let found = rotation_log(&UnitQuaternion::new_unchecked(quaternion)).norm();
            // The squares of the smallest angles underflow.
            if angle > 1e-150 {
                assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected, "{angle}: {found}");
            }
            assert!((found - angle).abs() <= 4.0 * f64::EPSILON * angle || angle <= 1e-150, "{angle}: {found}");
        }
    }
}
