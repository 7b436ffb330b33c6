//! The displacement of keyframes, against every way to lay one list into the other.

use nalgebra::{Translation3, UnitQuaternion};
use proptest::prelude::*;
use situ::demonstration::Pose;
use situ::keyframe::alignment::{Laid, displacement, partners};

/// Every second keyframe is a contact.
fn laid(points: &[(f64, f64)]) -> Vec<Laid> {
    let pose = |(x, y): (f64, f64)| Pose::from_parts(Translation3::new(x, y, 0.0), UnitQuaternion::identity());
    let laid = |(index, point): (usize, &(f64, f64))| Laid { pose: pose(*point), is_contact: index % 2 == 1 };
    points.iter().enumerate().map(laid).collect()
}

/// Half a metre counts for one at a contact.
fn unit(is_contact: bool) -> f64 {
    if is_contact { 0.5 } else { 1.0 }
}

/// The distances of partners, over all subsets of `long` that are as large as `short`. A subset is a number whose bits
/// are its members.
fn by_subsets(short: &[(f64, f64)], long: &[(f64, f64)], unit: fn(bool) -> f64) -> Vec<Vec<f64>> {
    let subsets = (0_u32..1 << long.len()).filter(|subset| subset.count_ones() as usize == short.len());
    let distances = |subset: u32| {
        let chosen = (0..long.len()).filter(move |index| subset >> index & 1 == 1);
        let apart = |(place, (index, here)): (usize, (usize, &(f64, f64)))| {
            (long[index].0 - here.0).hypot(long[index].1 - here.1) / unit(place % 2 == 1 && index % 2 == 1)
        };
        chosen.zip(short).enumerate().map(apart).collect()
    };
    subsets.map(distances).collect()
}

fn points(most: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 0..=most)
}

proptest! {
    #[test]
    fn it_is_the_best_of_all_ways(left in points(4), right in points(9)) {
        let (short, long) = if left.len() <= right.len() { (&left, &right) } else { (&right, &left) };
        for unit in [unit, |_| 1.0] {
            let farthest = by_subsets(short, long, unit).into_iter().map(|apart| apart.into_iter().fold(0.0, f64::max));
            let expected = farthest.fold(f64::INFINITY, f64::min);
            for (one, other) in [(&left, &right), (&right, &left)] {
                let found = displacement(&laid(one), &laid(other), unit);
                prop_assert!((found - expected).abs() < 1e-12, "{} instead of {}", found, expected);
            }
        }
        let sums = by_subsets(short, long, |_| 1.0).into_iter().map(|apart| apart.iter().map(|apart| apart * apart).sum());
        let expected: f64 = sums.fold(f64::INFINITY, f64::min);
        let pairs = partners(&laid(&left), &laid(&right));
        prop_assert!(pairs.len() == short.len() && pairs.is_sorted_by(|one, next| one.0 < next.0 && one.1 < next.1));
        let squares = pairs.iter().map(|(one, other)| (left[*one].0 - right[*other].0).powi(2) + (left[*one].1 - right[*other].1).powi(2));
        prop_assert!((squares.sum::<f64>() - expected).abs() < 1e-12);
    }

    /// A needless keyframe displaces nothing, wherever it is. A keyframe that is moved is displaced by as much as it
    /// was moved.
    #[test]
    fn a_needless_keyframe_displaces_nothing(mut points in points(9), at in 0..9_usize, x in -1.0..1.0_f64) {
        prop_assume!(!points.is_empty());
        let shown = laid(&points);
        points.insert(at.min(points.len()), (x, 0.3));
        prop_assert_eq!(displacement(&shown, &laid(&points), |_| 1.0), 0.0);
        let moved: Vec<_> = points.iter().map(|(x, y)| (*x, y + 5.0)).collect();
        prop_assert!((displacement(&laid(&points), &laid(&moved), |_| 1.0) - 5.0).abs() < 1e-12);
    }
}
