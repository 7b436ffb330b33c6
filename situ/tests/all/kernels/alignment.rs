//! The displacement of keyframes, against every way to lay one list into the other.

use nalgebra::{Translation3, UnitQuaternion};
use proptest::prelude::*;
use situ::demonstration::Pose;
use situ::keyframe::alignment::displacement;

fn poses(points: &[(f64, f64)]) -> Vec<Pose> {
    points.iter().map(|(x, y)| Pose::from_parts(Translation3::new(*x, *y, 0.0), UnitQuaternion::identity())).collect()
}

/// The least greatest distance over all subsets of `long` that are as large as `short`. A subset is a number whose bits
/// are its members.
fn by_subsets(short: &[(f64, f64)], long: &[(f64, f64)]) -> f64 {
    let subsets = (0_u32..1 << long.len()).filter(|subset| subset.count_ones() as usize == short.len());
    let farthest = subsets.map(|subset| {
        let chosen = (0..long.len()).filter(|index| subset >> index & 1 == 1);
        chosen
            .zip(short)
            .map(|(index, here)| (long[index].0 - here.0).hypot(long[index].1 - here.1))
            .fold(0.0, f64::max)
    });
    farthest.fold(f64::INFINITY, f64::min)
}

fn points(most: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 0..=most)
}

proptest! {
    #[test]
    fn it_is_the_best_of_all_ways(left in points(4), right in points(9)) {
        let (short, long) = if left.len() <= right.len() { (&left, &right) } else { (&right, &left) };
        let expected = by_subsets(short, long);
        for (one, other) in [(&left, &right), (&right, &left)] {
            let found = displacement(&poses(one), &poses(other));
            prop_assert!((found - expected).abs() < 1e-12, "{} instead of {}", found, expected);
        }
    }

    /// A needless keyframe displaces nothing, wherever it is. A keyframe that is moved is displaced by as much as it
    /// was moved.
    #[test]
    fn a_needless_keyframe_displaces_nothing(mut points in points(9), at in 0..9_usize, x in -1.0..1.0_f64) {
        prop_assume!(!points.is_empty());
        let shown = poses(&points);
        points.insert(at.min(points.len()), (x, 0.3));
        prop_assert_eq!(displacement(&shown, &poses(&points)), 0.0);
        let moved: Vec<_> = points.iter().map(|(x, y)| (*x, y + 5.0)).collect();
        prop_assert!((displacement(&poses(&points), &poses(&moved)) - 5.0).abs() < 1e-12);
    }
}
