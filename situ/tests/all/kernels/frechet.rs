//! The distance of two paths.

use proptest::prelude::*;
use situ::demonstration::Pose;
use situ::keyframe::frechet::frechet;
use situ::keyframe::pose::{exp, log};

use crate::kernels::sample::{pose_of, vector};

/// A path of up to six poses: legs of up to 30 cm and up to half a radian about each axis.
fn path() -> impl Strategy<Value = Vec<Pose>> {
    let legs = prop::collection::vec((vector(0.15), vector(0.5)), 1..6);
    legs.prop_map(|legs| {
        let mut path = vec![Pose::identity()];
        path.extend(legs.into_iter().scan(Pose::identity(), |pose, (step, turn)| {
            *pose *= pose_of(step, turn);
            Some(*pose)
        }));
        path
    })
}

/// The middle of a leg, as the legs of a path are straight: positions and rotations turn evenly.
fn middle(from: &Pose, to: &Pose) -> Pose {
    let middle = exp(from, &(log(from, to) * 0.5));
    Pose::from_parts(((from.translation.vector + to.translation.vector) * 0.5).into(), middle.rotation)
}

proptest! {
    /// To stop halfway on a leg changes no path. The points of the two differ by at most an eighth of a leg, and what
    /// the mean of two rotations is off.
    #[test]
    fn a_pose_more_on_a_leg_is_no_distance(path in path()) {
        let mut dense = vec![path[0]];
        let mut longest: f64 = 0.0;
        for leg in path.windows(2) {
            dense.extend([middle(&leg[0], &leg[1]), leg[1]]);
            let step = log(&leg[0], &leg[1]);
            longest = longest.max(step.fixed_rows::<3>(0).norm() + 0.1 * step.fixed_rows::<3>(3).norm());
        }
        let found = frechet(&path, &dense);
        prop_assert!(found <= longest / 8.0 + 0.001, "{} over legs of {}", found, longest);
        prop_assert!((found - frechet(&dense, &path)).abs() < 1e-15);
        prop_assert!(frechet(&path, &path) < 1e-7);
    }

    /// A path that is moved as a whole is as far away as it was moved; and a radian counts a tenth of a metre.
    #[test]
    fn a_moved_path_is_as_far_as_it_was_moved(path in path(), step in vector(0.2), turn in vector(0.2)) {
        let moved = |by: &Pose| -> Vec<Pose> {
            let turned = |pose: &Pose| Pose::from_parts(pose.translation, pose.rotation * by.rotation);
            path.iter().map(|pose| Pose::from_parts(by.translation, Default::default()) * turned(pose)).collect()
        };
        let by = pose_of(step, turn);
        let (angle, length) = (by.rotation.angle(), by.translation.vector.norm());
        let turned = frechet(&path, &moved(&Pose::from_parts(Default::default(), by.rotation)));
        prop_assert!((turned - 0.1 * angle).abs() < 0.01 * 0.1 * angle + 1e-8, "{} for {} rad", turned, angle);
        let straight = frechet(&path[..1], &moved(&Pose::from_parts(by.translation, Default::default()))[..1]);
        prop_assert!((straight - length).abs() < 1e-12);
    }
}

#[test]
fn a_path_without_a_pose_is_infinitely_far() {
    assert_eq!(frechet(&[], &[Pose::identity()]), f64::INFINITY);
    assert_eq!(frechet(&[Pose::identity()], &[]), f64::INFINITY);
}
