//! Poses as points of R³ × S³: logarithm, exponential and mean.
//!
//! A Gaussian over poses has its mean on the manifold, and its covariance in the tangent space at that mean (decision
//! D13; Zeestraten et al., RA-L 2017; Calinon 2019). The position part of a tangent vector is the plain difference in
//! metres. The rotation part is the rotation vector that turns the base into the pose, in the frame of the base.

use nalgebra::{Matrix4, Quaternion, SVector, Translation3, UnitQuaternion, Vector3};
use pulp::Scalar256b;

use crate::demonstration::Pose;
use crate::vector::{Four, Wide, polynomial};

/// A tangent vector: position in metres (3), then rotation vector in radians (3).
pub type Tangent = SVector<f64, 6>;

/// The length that a radian counts where metres and radians are added (decision D5), metres: about the reach of a held
/// object from the gripper.
pub(crate) const METRES_PER_RADIAN: f64 = 0.1;
/// Below this angle, radians, sine and cosine are the first terms of their series: the next terms are below the
/// rounding error.
const SMALL_ANGLE: f64 = 1e-8;
/// 2 acos(c)/√(1 − c²) for c from 0 to 1, as a polynomial in 2c − 1. Times this factor, the imaginary part of a unit
/// quaternion with the real part c is the rotation vector. By Chebyshev interpolation (mpmath 1.4.1, `chebyfit` with 24
/// terms); the error is at most 5·10⁻¹⁹.
const LOGARITHM: [[f64; 4]; 6] = [
    [2.418_399_152_312_290_3, -0.527_200_282_562_569_8, 0.139_466_384_104_096_92, -0.039_674_293_844_961_76],
    [
        0.011_723_257_949_791_874,
        -0.003_545_856_922_110_354_2,
        0.001_089_547_978_183_938_5,
        -0.000_338_619_896_095_276_2,
    ],
    [0.000_106_147_391_072_555_86, -3.349_827_773_501_2e-5, 1.062_864_618_938_326_8e-5, -3.387_313_914_556_849e-6],
    [1.083_507_486_390_609_4e-6, -3.476_776_873_066_045_7e-7, 1.119_050_490_829_676_5e-7, -3.608_950_085_076_399_5e-8],
    [1.159_799_400_643_536_1e-8, -3.754_596_344_989_972e-9, 1.285_150_735_241_561_3e-9, -4.174_738_332_040_863e-10],
    [9.087_757_326_338_875e-11, -2.952_744_983_101_419_5e-11, 2.671_369_168_991_588e-11, -8.724_027_607_819_922e-12],
];

/// The search for the mean ends with a step shorter than this, radians.
pub(crate) const MEAN_TOLERANCE: f64 = 1e-9;
/// Greatest number of steps towards the mean. Two or three are enough if the rotations are within a right angle.
pub(crate) const MEAN_STEPS: usize = 10;
/// The mean starts at the dominant axis of a matrix, which is squared so many times. The 2¹⁶th power separates axes
/// whose eigenvalues differ by 10⁻⁴ in proportion.
const SQUARINGS: usize = 16;

/// Whether a pose has finite numbers and a rotation of length 1, but for rounding.
pub(crate) fn is_unit(pose: &Pose) -> bool {
    let length = pose.rotation.quaternion().norm_squared();
    pose.translation.vector.iter().all(|value| value.is_finite()) && (length - 1.0).abs() < 1e-9
}

/// The rotation vector of a unit quaternion, radians, at most π long. It is the same for q and −q.
pub fn rotation_log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let quaternion = rotation.quaternion();
    let imaginary = Vector3::new(quaternion.i, quaternion.j, quaternion.k);
    // At half a turn w is 0 and both signs are equally near. The first component that is not 0 decides.
    let flip = if quaternion.w == 0.0 {
        imaginary.iter().find(|value| **value != 0.0).is_some_and(|value| *value < 0.0)
    } else {
        quaternion.w < 0.0
    };
    let (w, v) = if flip { (-quaternion.w, -imaginary) } else { (quaternion.w, imaginary) };
    v * log_scales(Four::splat(Scalar256b, w)).numbers()[0]
}

/// The factors that turn the imaginary parts of unit quaternions into rotation vectors, from the real parts, which are
/// 0 to 1. No angle loses digits.
#[inline(always)]
pub(crate) fn log_scales<S: Wide>(cosines: Four<S>) -> Four<S> {
    polynomial(cosines * 2.0 - 1.0, &LOGARITHM)
}

/// The length of a tangent vector, metres: its metres plus `metres_per_radian` × its radians.
pub(crate) fn arc_length(tangent: &Tangent, metres_per_radian: f64) -> f64 {
    let (metres, radians) = (tangent.fixed_rows::<3>(0).into_owned(), tangent.fixed_rows::<3>(3).into_owned());
    length(&metres) + metres_per_radian * length(&radians)
}

/// The unit quaternion that turns by `vector`, radians. It is the inverse of [`rotation_log`] up to a length of π.
pub fn rotation_exp(vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = length(vector);
    let (w, scale) = if angle < SMALL_ANGLE {
        (1.0 - angle * angle / 8.0, 0.5)
    } else {
        (libm::cos(0.5 * angle), libm::sin(0.5 * angle) / angle)
    };
    unit(Quaternion::new(w, vector.x * scale, vector.y * scale, vector.z * scale))
}

/// The logarithm of `pose` at `base`: metres, radians.
pub fn log(base: &Pose, pose: &Pose) -> Tangent {
    let position = pose.translation.vector - base.translation.vector;
    let rotation = rotation_log(&(base.rotation.conjugate() * pose.rotation));
    Tangent::new(position.x, position.y, position.z, rotation.x, rotation.y, rotation.z)
}

/// The exponential of `tangent` at `base`. It is the inverse of [`log`] up to a rotation of π.
pub fn exp(base: &Pose, tangent: &Tangent) -> Pose {
    let position = base.translation.vector + Vector3::new(tangent[0], tangent[1], tangent[2]);
    let turned = turn(&base.rotation, &Vector3::new(tangent[3], tangent[4], tangent[5]));
    Pose::from_parts(Translation3::from(position), turned)
}

/// The weighted mean of poses on the manifold: there the weighted logarithms sum to 0 (Karcher mean).
///
/// `weights` has one number per pose, none negative. The mean is the identity if all weights are 0.
pub fn karcher_mean(poses: &[Pose], weights: &[f64]) -> Pose {
    karcher_mean_from(&dominant_rotation(poses, weights), poses, weights)
}

/// The dominant axis of Σ w q qᵀ (Markley et al. 2007). It is a start for the mean that depends neither on the order of
/// the poses nor on the signs of their quaternions. It is the identity if all weights are 0.
pub(crate) fn dominant_rotation(poses: &[Pose], weights: &[f64]) -> UnitQuaternion<f64> {
    let mut axes = Matrix4::zeros();
    for (pose, weight) in poses.iter().zip(weights) {
        let quaternion = pose.rotation.coords;
        axes += quaternion * quaternion.transpose() * *weight;
    }
    // Repeated squaring leaves the dominant axis.
    for _ in 0..SQUARINGS {
        let trace = axes.trace();
        if trace <= 0.0 {
            return UnitQuaternion::identity();
        }
        axes /= trace;
        axes *= axes;
    }
    let mut longest = 0;
    for column in 1..4 {
        if axes[(column, column)] > axes[(longest, longest)] {
            longest = column;
        }
    }
    unit(Quaternion::from(axes.column(longest).into_owned()))
}

/// [`karcher_mean`], from a first guess of the rotation.
fn karcher_mean_from(start: &UnitQuaternion<f64>, poses: &[Pose], weights: &[f64]) -> Pose {
    let mut total = 0.0;
    let mut position = Vector3::zeros();
    for (pose, weight) in poses.iter().zip(weights) {
        total += weight;
        position += pose.translation.vector * *weight;
    }
    if total <= 0.0 {
        return Pose::identity();
    }
    let mut mean = *start;
    for _ in 0..MEAN_STEPS {
        let mut step = Vector3::zeros();
        for (pose, weight) in poses.iter().zip(weights) {
            step += rotation_log(&(mean.conjugate() * pose.rotation)) * *weight;
        }
        step /= total;
        mean = turn(&mean, &step);
        if length(&step) < MEAN_TOLERANCE {
            break;
        }
    }
    Pose::from_parts(Translation3::from(position / total), mean)
}

/// A rotation, turned further by a rotation vector in its own frame.
pub(crate) fn turn(base: &UnitQuaternion<f64>, vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    unit((base * rotation_exp(vector)).into_inner())
}

/// The length of a vector. Its root is exact to the last bit on every platform.
fn length(vector: &Vector3<f64>) -> f64 {
    libm::sqrt(vector.x * vector.x + vector.y * vector.y + vector.z * vector.z)
}

fn unit(quaternion: Quaternion<f64>) -> UnitQuaternion<f64> {
    let norm = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
    UnitQuaternion::new_unchecked(quaternion / norm)
}
