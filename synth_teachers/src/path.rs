//! Geometry of the ways of a hand: poses off by an error, half-way points, corners.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use situ::keyframe::pose;

/// A turn about the z axis, radians.
pub(crate) fn about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    UnitQuaternion::new_unchecked(Quaternion::new(cosine, 0.0, 0.0, sine))
}

/// A direction of the upper half-space, all equally likely, from two numbers between 0 and 1. By Archimedes, the height
/// is uniform.
pub(crate) fn upwards(height: f64, turn: f64) -> Vector3<f64> {
    let radius = libm::sqrt((1.0 - height * height).max(0.0));
    let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
    Vector3::new(radius * cosine, radius * sine, height)
}

/// The corners of the way from one pose to another along one axis after the other. The hand goes up before it goes
/// sideways, and sideways before it goes down, so that nothing is dragged along what it stands on. The gripper turns on
/// the first leg. Axes with next to nothing to go have no corner.
pub(crate) fn corners(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
    /// A person does not notice that the way along an axis is shorter than this, metres.
    const LEAST: f64 = 0.01;
    let way = to.translation.vector - from.translation.vector;
    let order = if way.z > 0.0 { [2, 0, 1] } else { [0, 1, 2] };
    let legs: Vec<usize> = order.into_iter().filter(|axis| way[*axis].abs() >= LEAST).collect();
    let mut at = from.translation.vector;
    // The last leg ends at the keyframe itself, which is no corner.
    let corners = legs.iter().take(legs.len().saturating_sub(1)).map(|axis| {
        at[*axis] = to.translation.vector[*axis];
        Isometry3::from_parts(Translation3::from(at), to.rotation)
    });
    corners.collect()
}

/// A pose off by an error: shifted in the world's axes, turned in the gripper's.
pub(crate) fn displaced(target: &Isometry3<f64>, error: &Isometry3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(target.translation.vector + error.translation.vector),
        target.rotation * error.rotation,
    )
}

/// Half way between two poses.
pub(crate) fn half_way(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Isometry3<f64> {
    let middle: Vector3<f64> = (from.translation.vector + to.translation.vector) * 0.5;
    let rotation: UnitQuaternion<f64> = pose::exp(from, &(pose::log(from, to) * 0.5)).rotation;
    Isometry3::from_parts(Translation3::from(middle), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_turn_at_right_angles_and_go_up_first_and_down_last() {
        let at = |x, y, z| Isometry3::translation(x, y, z);
        let way = |from, to| -> Vec<[f64; 3]> {
            corners(&from, &to).iter().map(|corner| corner.translation.vector.into()).collect()
        };
        assert_eq!(way(at(0.0, 0.0, 0.0), at(0.1, 0.2, 0.3)), [[0.0, 0.0, 0.3], [0.1, 0.0, 0.3]]);
        assert_eq!(way(at(0.1, 0.2, 0.3), at(0.0, 0.0, 0.0)), [[0.0, 0.2, 0.3], [0.0, 0.0, 0.3]]);
        assert_eq!(way(at(0.0, 0.0, 0.3), at(0.001, 0.2, 0.1)), [[0.0, 0.2, 0.3]]);
        assert!(way(at(0.0, 0.0, 0.3), at(0.0, 0.0, 0.1)).is_empty());
    }
}
