//! A path of poses as a polyline: the fewest of its points that a simple rule finds, so that no pose of the path is
//! farther from the polyline than a tolerance.
//!
//! The rule is the one of Ramer (1972) and of Douglas and Peucker (1973): the pose that is farthest from the straight
//! way between two points is a point itself, until none is too far.

use nalgebra::{UnitQuaternion, Vector3};
use situ::demonstration::Pose;

/// How far a pose may be from the polyline: both count at once, as the two sides of a right angle.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Metres.
    pub metres: f64,
    /// Radians.
    pub radians: f64,
}

impl Tolerance {
    /// The distance of two poses in tolerances: at most 1 where they are as good as one.
    pub fn apart(&self, one: &Pose, other: &Pose) -> f64 {
        let metres = (one.translation.vector - other.translation.vector).norm() / self.metres;
        let radians = one.rotation.angle_to(&other.rotation) / self.radians;
        libm::hypot(metres, radians)
    }

    /// How far `pose` is from the straight way between two others, in tolerances. The way moves and turns evenly, and
    /// is left where the pose's projection in metres and radians, each in its tolerance, meets it.
    pub fn off(&self, pose: &Pose, from: &Pose, to: &Pose) -> f64 {
        let turn = (from.rotation.inverse() * to.rotation).scaled_axis();
        let own = (from.rotation.inverse() * pose.rotation).scaled_axis();
        let way = to.translation.vector - from.translation.vector;
        let gone = pose.translation.vector - from.translation.vector;
        let (metres, radians) = (self.metres * self.metres, self.radians * self.radians);
        let dot = |moved: &Vector3<f64>, turned: &Vector3<f64>| way.dot(moved) / metres + turn.dot(turned) / radians;
        let length = dot(&way, &turn);
        let share = if length > 0.0 { (dot(&gone, &own) / length).clamp(0.0, 1.0) } else { 0.0 };
        let at = from.translation.vector + way * share;
        let rotation = from.rotation * UnitQuaternion::from_scaled_axis(turn * share);
        self.apart(pose, &Pose::from_parts(at.into(), rotation))
    }
}

/// The indices of the polyline's points, the first and the last pose among them; empty where there is no pose.
pub fn polyline(poses: &[Pose], tolerance: Tolerance) -> Vec<usize> {
    let Some(last) = poses.len().checked_sub(1) else { return Vec::new() };
    let mut points = vec![0];
    // Ways that are still to be looked at, the next one on top.
    let mut ways = if last > 0 { vec![(0, last)] } else { Vec::new() };
    while let Some((from, to)) = ways.pop() {
        let off = |index: usize| (index, tolerance.off(&poses[index], &poses[from], &poses[to]));
        let farthest = (from + 1..to).map(off).fold(None, |best: Option<(usize, f64)>, each| match best {
            Some(best) if best.1 >= each.1 => Some(best),
            _ => Some(each),
        });
        match farthest {
            Some((index, off)) if off > 1.0 => ways.extend([(index, to), (from, index)]),
            _ => points.push(to),
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;
    use proptest::prelude::*;

    use super::*;

    const TOLERANCE: Tolerance = Tolerance { metres: 0.05, radians: 0.5 };

    fn pose(at: [f64; 3], turn: [f64; 3]) -> Pose {
        Pose::from_parts(Translation3::from(at), UnitQuaternion::from_scaled_axis(Vector3::from(turn)))
    }

    proptest! {
        #[test]
        fn no_pose_is_farther_from_the_polyline_than_the_tolerance(
            poses in prop::collection::vec((prop::array::uniform3(-0.5..0.5), prop::array::uniform3(-3.0..3.0)), 0..40)
        ) {
            let poses: Vec<Pose> = poses.into_iter().map(|(at, turn)| pose(at, turn)).collect();
            let points = polyline(&poses, TOLERANCE);
            prop_assert_eq!(points.first().copied(), (!poses.is_empty()).then_some(0));
            prop_assert_eq!(points.last().copied(), poses.len().checked_sub(1));
            for pair in points.windows(2) {
                prop_assert!(pair[0] < pair[1]);
                for index in pair[0]..=pair[1] {
                    let off = TOLERANCE.off(&poses[index], &poses[pair[0]], &poses[pair[1]]);
                    prop_assert!(off <= 1.0 + 1e-9, "pose {index} is {off} off");
                }
            }
        }
    }

    #[test]
    fn a_straight_way_has_two_points_and_a_corner_three() {
        let way = |corner: bool| -> Vec<Pose> {
            let height = |step: usize| if corner { 0.02 * step.min(20) as f64 } else { 0.0 };
            (0..40).map(|step| pose([0.01 * step.max(20) as f64, 0.0, height(step)], [0.0; 3])).collect()
        };
        assert_eq!(polyline(&way(false), TOLERANCE), [0, 39]);
        assert_eq!(polyline(&way(true), TOLERANCE), [0, 20, 39]);
        // A turn in one place is a way, too.
        let turns: Vec<Pose> =
            (0..40).map(|step: i32| pose([0.0; 3], [0.1 * f64::from(20 - (step - 20).abs()), 0.0, 0.0])).collect();
        assert_eq!(polyline(&turns, TOLERANCE), [0, 20, 39]);
    }
}
