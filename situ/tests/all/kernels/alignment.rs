//! Keyframes laid into one another, against every way to lay one list into the other.

use proptest::prelude::*;
use situ::keyframe::alignment::{Laid, displacement, partners};

use crate::kernels::sample::pose_of;

/// x, y, and whether it is a contact.
type Point = (f64, f64, bool);

fn laid(points: &[Point]) -> Vec<Laid> {
    let lay = |(x, y, is_contact): &Point| Laid { pose: pose_of([*x, *y, 0.0], [0.0; 3]), is_contact: *is_contact };
    points.iter().map(lay).collect()
}

fn apart(one: &Point, other: &Point) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

/// Every subset of `long` that is as large as `short`, as indices. A subset is a number whose bits are its members.
fn subsets(short: usize, long: usize) -> impl Iterator<Item = Vec<usize>> {
    let subsets = (0_u32..1 << long).filter(move |subset| subset.count_ones() as usize == short);
    subsets.map(move |subset| (0..long).filter(|index| subset >> index & 1 == 1).collect())
}

/// The unit of two contacts, and of any other two.
const UNITS: (f64, f64) = (0.25, 0.5);

/// The least greatest distance.
fn by_subsets(short: &[Point], long: &[Point]) -> f64 {
    let unit = |here: &Point, there: &Point| if here.2 && there.2 { UNITS.0 } else { UNITS.1 };
    let farthest = subsets(short.len(), long.len()).map(|chosen| {
        let pairs = short.iter().zip(chosen.iter().map(|index| &long[*index]));
        pairs.map(|(here, there)| apart(here, there) / unit(here, there)).fold(0.0, f64::max)
    });
    farthest.fold(f64::INFINITY, f64::min)
}

fn points(most: usize) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, any::<bool>()), 0..=most)
}

fn unit(is_contact: bool) -> f64 {
    if is_contact { UNITS.0 } else { UNITS.1 }
}

proptest! {
    #[test]
    fn it_is_the_best_of_all_ways(left in points(4), right in points(9)) {
        let (short, long) = if left.len() <= right.len() { (&left, &right) } else { (&right, &left) };
        let expected = by_subsets(short, long);
        for (one, other) in [(&left, &right), (&right, &left)] {
            let found = displacement(&laid(one), &laid(other), 0, unit);
            prop_assert!((found - expected).abs() < 1e-12, "{} instead of {}", found, expected);
        }
    }

    /// Where some keyframes of the shorter list may be left out, the best choice of them counts. A contact never is,
    /// and the last pair is always laid.
    #[test]
    fn what_may_be_left_out_is_left_out_for_the_best(left in points(4), right in points(7), most in 0..3_usize) {
        let (short, long) = if left.len() <= right.len() { (&left, &right) } else { (&right, &left) };
        let most = most.min(short.len().saturating_sub(1));
        let kept = (0..=most).flat_map(|out| subsets(short.len() - out, short.len()));
        let allowed = kept.filter(|kept| (0..short.len()).all(|index| kept.contains(&index) || !short[index].2));
        let expected = allowed
            .map(|kept| by_subsets(&kept.iter().map(|index| short[*index]).collect::<Vec<_>>(), long))
            .fold(f64::INFINITY, f64::min);
        let found = displacement(&laid(&left), &laid(&right), most, unit);
        prop_assert!((found - expected).abs() < 1e-12, "{} instead of {}", found, expected);
    }

    /// A needless keyframe displaces nothing, wherever it is. A keyframe that is moved is displaced by as much as it
    /// was moved.
    #[test]
    fn a_needless_keyframe_displaces_nothing(mut points in points(9), at in 0..9_usize, x in -1.0..1.0_f64) {
        prop_assume!(!points.is_empty());
        let shown = laid(&points);
        points.insert(at.min(points.len()), (x, 0.3, false));
        prop_assert_eq!(displacement(&shown, &laid(&points), 0, unit), 0.0);
        let moved: Vec<_> = points.iter().map(|(x, y, is_contact)| (*x, y + 5.0, *is_contact)).collect();
        prop_assert!((displacement(&laid(&points), &laid(&moved), 0, |_| 1.0) - 5.0).abs() < 1e-12);
    }

    /// Each keyframe of the shorter list has one partner, in order, and no other choice has a lesser sum of squares.
    #[test]
    fn partners_have_the_least_sum(left in points(5), right in points(9)) {
        let found = partners(&laid(&left), &laid(&right));
        let turned = partners(&laid(&right), &laid(&left)).into_iter();
        let turned: Vec<_> = turned.map(|(one, other)| (other, one)).collect();
        prop_assert_eq!(&found, &turned, "whichever comes first");
        prop_assert!(found.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1), "{:?}", found);
        prop_assert_eq!(found.len(), left.len().min(right.len()));
        let sum: f64 = found.iter().map(|(one, other)| apart(&left[*one], &right[*other]).powi(2)).sum();
        let (short, long) = if left.len() <= right.len() { (&left, &right) } else { (&right, &left) };
        let least = subsets(short.len(), long.len())
            .map(|chosen| short.iter().zip(chosen).map(|(here, there)| apart(here, &long[there]).powi(2)).sum::<f64>())
            .fold(f64::INFINITY, f64::min);
        prop_assert!((sum - least).abs() < 1e-12, "{} instead of {}", sum, least);
    }
}
