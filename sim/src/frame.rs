//! Poses: between our f64 world and the engine's f32 one, and rotations that are the same bits everywhere.

use nalgebra::{Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use rapier3d::math::{Pose as EnginePose, Rotation, Vector};

/// A pose: metres, world frame (z up) unless said otherwise.
pub type Pose = nalgebra::Isometry3<f64>;

/// Below this sine of the half angle between two rotations, spherical and straight interpolation agree to the last
/// bits.
const SMALL_HALF_ANGLE_SINE: f64 = 1e-9;

/// A rotation by `angle` radians about `axis` (any length but zero; a zero or non-finite axis gives no rotation).
///
/// The sine and cosine come from `libm`, so the result is the same bits on every machine.
pub fn rotation_about(axis: [f64; 3], angle: f64) -> UnitQuaternion<f64> {
    let axis = Vector3::from(axis);
    let length = axis.norm();
    if !length.is_normal() || !angle.is_finite() {
        return UnitQuaternion::identity();
    }
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let imaginary = axis * (sine / length);
    Unit::new_normalize(Quaternion::from_parts(cosine, imaginary))
}

/// A pose from a position (metres) and a rotation.
pub fn pose_at(position: [f64; 3], rotation: UnitQuaternion<f64>) -> Pose {
    Pose::from_parts(Translation3::from(Vector3::from(position)), rotation)
}

/// The angle of a rotation, in radians within `[0, π]`.
pub(crate) fn angle_of(rotation: &UnitQuaternion<f64>) -> f64 {
    2.0 * libm::atan2(rotation.imag().norm(), rotation.scalar().abs())
}

/// The pose a fraction `s` of the way: straight in position, spherical (the shorter way round) in rotation.
pub(crate) fn between(from: &Pose, to: &Pose, s: f64) -> Pose {
    let position = from.translation.vector + (to.translation.vector - from.translation.vector) * s;
    let a = from.rotation.into_inner();
    let mut b = to.rotation.into_inner();
    let mut cosine = a.coords.dot(&b.coords);
    if cosine < 0.0 {
        b = -b;
        cosine = -cosine;
    }
    let cosine = cosine.min(1.0);
    let sine = libm::sqrt(1.0 - cosine * cosine);
    let (weight_a, weight_b) = if sine < SMALL_HALF_ANGLE_SINE {
        (1.0 - s, s)
    } else {
        let half = libm::atan2(sine, cosine);
        (libm::sin((1.0 - s) * half) / sine, libm::sin(s * half) / sine)
    };
    let rotation = Unit::new_normalize(a * weight_a + b * weight_b);
    Pose::from_parts(Translation3::from(position), rotation)
}

/// Whether every number of the pose is finite.
pub(crate) fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
}

/// Our pose in the engine's numbers.
pub(crate) fn to_engine(pose: &Pose) -> EnginePose {
    EnginePose::from_parts(
        to_engine_vector(&pose.translation.vector),
        Rotation::from_xyzw(
            pose.rotation.i as f32,
            pose.rotation.j as f32,
            pose.rotation.k as f32,
            pose.rotation.w as f32,
        )
        .normalize(),
    )
}

/// Our pose in the engine's numbers, for a kinematic body that is at `now`.
///
/// Two quaternions stand for one rotation. The engine takes a body's velocity from the quaternions as they stand. Given
/// the wrong one of the two, it makes a whole turn in a single step (1500 rad/s), and whatever the hand held was shot
/// out of it. So the engine gets the one that is near.
pub(crate) fn to_engine_near(pose: &Pose, now: &EnginePose) -> EnginePose {
    let mut near = to_engine(pose);
    if near.rotation.dot(now.rotation) < 0.0 {
        near.rotation = -near.rotation;
    }
    near
}

/// The engine's pose in our numbers.
pub(crate) fn from_engine(pose: &EnginePose) -> Pose {
    let r = pose.rotation;
    Pose::from_parts(
        Translation3::from(from_engine_vector(pose.translation)),
        Unit::new_normalize(Quaternion::new(f64::from(r.w), f64::from(r.x), f64::from(r.y), f64::from(r.z))),
    )
}

/// Our vector in the engine's numbers.
pub(crate) fn to_engine_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

/// The engine's vector in our numbers.
pub(crate) fn from_engine_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn interpolation_agrees_with_nalgebra_and_meets_its_ends() {
        let a = pose_at([0.1, -0.2, 0.3], rotation_about([1.0, 2.0, -0.5], 0.7));
        let b = pose_at([-0.4, 0.2, 0.1], rotation_about([0.0, -1.0, 0.3], 2.1));
        for k in 0..=10 {
            let s = f64::from(k) / 10.0;
            let ours = between(&a, &b, s);
            let theirs = a.lerp_slerp(&b, s);
            assert!((ours.inverse() * theirs).translation.vector.norm() < 1e-12);
            assert!(ours.rotation.angle_to(&theirs.rotation) < 1e-7);
        }
        assert!(between(&a, &b, 0.0).rotation.angle_to(&a.rotation) < 1e-7);
        assert!(between(&a, &b, 1.0).rotation.angle_to(&b.rotation) < 1e-7);
    }

    #[test]
    fn rotations_turn_as_the_right_hand_does() {
        let turned = rotation_about([0.0, 3.0, 0.0], core::f64::consts::FRAC_PI_2) * Vector3::z();
        assert!((turned - Vector3::x()).norm() < 1e-15);
        assert!((angle_of(&rotation_about([1.0, 1.0, 0.0], -2.0)) - 2.0).abs() < 1e-12);
        assert_eq!(rotation_about([0.0, 0.0, 0.0], 1.0), UnitQuaternion::identity());
    }
}
