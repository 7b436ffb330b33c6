//! The Fréchet distance of two paths: how far one way of doing a thing is from another.
//!
//! Two people walk along the two paths from end to end. They never go back, and each may walk as fast or slowly as they
//! like. The distance is the shortest leash that lets them do so (Fréchet 1906; over points of the paths as in Eiter
//! and Mannila 1994). The distance of the poses at the same share of the arc length would grow if one path only dwells,
//! wavers or has more keyframes; this distance does not.

use super::pose::METRES_PER_RADIAN;
use crate::demonstration::Pose;

/// Each leg of a path is cut into so many pieces, so that the way between the poses counts too.
const POINTS_A_LEG: usize = 4;

/// The Fréchet distance of two paths, each joined by straight legs: metres, where a radian counts a tenth of a metre.
/// Infinite if a path has no pose.
pub fn frechet(left: &[Pose], right: &[Pose]) -> f64 {
    let (left, right) = (points(left), points(right));
    if left.is_empty() || right.is_empty() {
        return f64::INFINITY;
    }
    // `reached[j]`: the shortest leash for the left path up to here and the right path up to point j.
    let mut reached = vec![f64::INFINITY; right.len()];
    for (index, here) in left.iter().enumerate() {
        let mut diagonal = if index == 0 { 0.0 } else { f64::INFINITY };
        let mut before = f64::INFINITY;
        for (leash, there) in reached.iter_mut().zip(&right) {
            let shortest = diagonal.min(before).min(*leash);
            diagonal = *leash;
            before = shortest.max(apart(here, there));
            *leash = before;
        }
    }
    reached[right.len() - 1]
}

/// A place on a path: the position, and the rotation as a unit quaternion of either sign.
type Point = ([f64; 3], [f64; 4]);

/// The poses, and points on the legs between them. A rotation on a leg is the normalised mean of the leg's ends, which
/// is good enough as legs turn only a little.
fn points(path: &[Pose]) -> Vec<Point> {
    let point = |pose: &Pose| -> Point {
        let [i, j, k, w]: [f64; 4] = pose.rotation.coords.into();
        (pose.translation.vector.into(), [i, j, k, w])
    };
    let Some(first) = path.first() else { return Vec::new() };
    let mut points = vec![point(first)];
    for pair in path.windows(2) {
        let (from, to) = (point(&pair[0]), point(&pair[1]));
        let sign = if dot(&from.1, &to.1) < 0.0 { -1.0 } else { 1.0 };
        points.extend((1..=POINTS_A_LEG).map(|step| {
            let share = step as f64 / POINTS_A_LEG as f64;
            let mut position = [0.0; 3];
            for (axis, value) in position.iter_mut().enumerate() {
                *value = from.0[axis] + share * (to.0[axis] - from.0[axis]);
            }
            let mut rotation = [0.0; 4];
            for (axis, value) in rotation.iter_mut().enumerate() {
                *value = from.1[axis] + share * (sign * to.1[axis] - from.1[axis]);
            }
            let norm = libm::sqrt(dot(&rotation, &rotation));
            (position, rotation.map(|value| value / norm))
        }));
    }
    points
}

fn dot(left: &[f64; 4], right: &[f64; 4]) -> f64 {
    left.iter().zip(right).map(|(left, right)| left * right).sum()
}

/// The distance of two points plus that of their rotations, metres. An angle is measured by twice the chord of its
/// half, which is 1 % short at a radian.
fn apart((here, turned): &Point, (there, other): &Point) -> f64 {
    let squared: f64 = here.iter().zip(there).map(|(here, there)| (here - there) * (here - there)).sum();
    let chord = 2.0 * libm::sqrt((2.0 - 2.0 * dot(turned, other).abs()).max(0.0));
    libm::sqrt(squared) + METRES_PER_RADIAN * chord
}
