//! Interpolation, uniform in arc length.

use proptest::prelude::*;
use situ::demonstration::Pose;
use situ::keyframe::interpolate::resample;
use situ::keyframe::pose::log;

use crate::kernels::sample::{pose, pose_of};

const METRES_PER_RADIAN: f64 = 0.1;

fn length(from: &Pose, to: &Pose) -> f64 {
    let step = log(from, to);
    step.fixed_rows::<3>(0).norm() + METRES_PER_RADIAN * step.fixed_rows::<3>(3).norm()
}

proptest! {
    /// On one leg the points are evenly spaced. Around corners, no two neighbours are further apart than the arc
    /// between them.
    #[test]
    fn points_are_even_along_the_path(poses in prop::collection::vec(pose(), 2..6), n in 2_usize..40) {
        let total: f64 = poses.windows(2).map(|pair| length(&pair[0], &pair[1])).sum();
        let points = resample(&poses, n, METRES_PER_RADIAN);
        prop_assert_eq!(points.len(), n);
        prop_assert_eq!(points[0], poses[0]);
        prop_assert_eq!(points[n - 1], poses[poses.len() - 1]);
        let step = total / (n - 1) as f64;
        for pair in points.windows(2) {
            prop_assert!(length(&pair[0], &pair[1]) < step + 1e-9);
        }
        let leg = resample(&poses[..2], n, METRES_PER_RADIAN);
        let step = length(&poses[0], &poses[1]) / (n - 1) as f64;
        for pair in leg.windows(2) {
            prop_assert!((length(&pair[0], &pair[1]) - step).abs() < 1e-9);
        }
    }
}

#[test]
fn a_path_of_known_length_is_cut_where_it_should() {
    // One metre, then a turn of 1 rad in place, which counts 0.1 m: the eleventh of twelve points is the corner.
    let corner = pose_of([1.0, 0.0, 0.0], [0.0; 3]);
    let path = [Pose::identity(), corner, pose_of([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])];
    let points = resample(&path, 12, METRES_PER_RADIAN);
    assert!(length(&points[10], &corner) < 1e-12);
    assert!(length(&points[3], &pose_of([0.3, 0.0, 0.0], [0.0; 3])) < 1e-12);
    let points = resample(&path, 23, METRES_PER_RADIAN);
    assert!(length(&points[21], &pose_of([1.0, 0.0, 0.0], [0.0, 0.0, 0.5])) < 1e-12);
}

#[test]
fn a_path_of_no_length_is_copied() {
    let one = pose_of([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]);
    assert_eq!(resample(&[one], 20, METRES_PER_RADIAN), vec![one; 20]);
    assert_eq!(resample(&[one, one, one], 5, METRES_PER_RADIAN), vec![one; 5]);
    assert_eq!(resample(&[], 5, METRES_PER_RADIAN), vec![]);
    assert_eq!(resample(&[one, Pose::identity()], 1, METRES_PER_RADIAN), vec![one]);
}
