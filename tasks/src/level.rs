//! Level frames: poses with their z axis made vertical.

use nalgebra::Vector3;
use situ_sim::{Pose, Symmetry, pose_at, rotation_about};

/// A pose with its z axis made vertical: the position, and the heading of the x axis. Where x points up or down, the
/// heading of the y axis.
///
/// Keyframes are relative to it. So a block that lies on another face is picked like any other. Poses of an object with
/// a symmetry that look alike have the same level: that of the canonical one, or, where the axis of the symmetry lies,
/// the heading of that axis.
pub(crate) fn level(pose: &Pose, symmetry: Option<&Symmetry>) -> Pose {
    /// An axis that is shorter than this in the plane has no clear heading: it is steeper than 60°.
    const LEAST: f64 = 0.5;
    /// An axis of symmetry that is longer than this in the plane lies: it is less steep than 45°.
    const LIES: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let lying = symmetry.map(|symmetry| (pose.rotation * symmetry.direction()).xy()).filter(|axis| axis.norm() > LIES);
    let rotation = symmetry.map_or(pose.rotation, |symmetry| symmetry.canonical(pose).rotation);
    let x = lying.unwrap_or_else(|| (rotation * Vector3::x()).xy());
    let y = (rotation * Vector3::y()).xy();
    let yaw = if x.norm() >= LEAST { libm::atan2(x.y, x.x) } else { libm::atan2(-y.x, y.y) };
    let mut level = pose_at([0.0; 3], rotation_about([0.0, 0.0, 1.0], yaw));
    level.translation = pose.translation;
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_frame_keeps_position_and_heading() {
        let upright = pose_at([0.1, 0.2, 0.3], rotation_about([0.0, 0.0, 1.0], 0.4));
        assert!((level(&upright, None).to_homogeneous() - upright.to_homogeneous()).norm() < 1e-12);
        let leaning = upright * rotation_about([0.0, 1.0, 0.0], 0.2);
        assert!((level(&leaning, None).to_homogeneous() - upright.to_homogeneous()).norm() < 1e-12);
        let on_its_side = upright * rotation_about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2);
        assert!((level(&on_its_side, None).to_homogeneous() - upright.to_homogeneous()).norm() < 1e-12);
    }

    #[test]
    fn a_round_thing_has_one_level_frame_however_it_is_turned() {
        let about_z = |angle| rotation_about([0.0, 0.0, 1.0], angle);
        for (axis, down) in [([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])] {
            let round = Symmetry { axis, fold: None };
            // Standing, leaning, lying and upside down, with the axis in all directions.
            for tilt in [0.0, 0.3, 1.2, std::f64::consts::FRAC_PI_2, 3.0, std::f64::consts::PI] {
                for heading in [0.0, 0.7, 2.0, -2.5] {
                    let stands = about_z(heading) * rotation_about(down, tilt);
                    let first = level(&pose_at([0.1, 0.0, 0.2], stands), Some(&round));
                    for turn in [0.5, 1.9, -3.0] {
                        let turned =
                            level(&pose_at([0.1, 0.0, 0.2], stands * rotation_about(axis, turn)), Some(&round));
                        let apart = (first.to_homogeneous() - turned.to_homogeneous()).norm();
                        assert!(
                            apart < 1e-6,
                            "{axis:?}, tilted by {tilt}, heading {heading}, turned by {turn}: {apart}"
                        );
                    }
                }
            }
        }
    }
}
