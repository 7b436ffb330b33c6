//! Poses as points of R³ × S³: logarithm, exponential and mean.
//!
//! A Gaussian over poses has its mean on the manifold and its covariance in the tangent space at that mean (decision D13;
//! Zeestraten et al., RA-L 2017; Calinon 2019). The position part is the plain difference in metres; the rotation part is the
//! rotation vector, in the frame of the base, that turns the base into the pose.

use nalgebra::{Matrix4, Quaternion, SVector, Translation3, UnitQuaternion, Vector3};

use crate::demonstration::Pose;

/// A tangent vector: position in metres (3), then rotation vector in radians (3).
pub type Tangent = SVector<f64, 6>;

/// Below this angle, radians, sine and cosine are taken from the first terms of their series, for the next are under the rounding error.
const SMALL_ANGLE: f64 = 1e-8;
/// Up to this squared sine of the half-angle (29°) the logarithm is a polynomial.
pub(crate) const SERIES_SINE_SQUARED: f64 = 0.0625;
/// Coefficients of the series of asin(s)/s in s²: up to [`SERIES_SINE_SQUARED`] the next term is under the rounding error.
pub(crate) const ARC_SINE: [f64; 12] = arc_sine();

/// The mean is found when a step is shorter than this, radians.
pub(crate) const MEAN_TOLERANCE: f64 = 1e-9;
/// Steps of the mean at most. It converges in two or three where the rotations are within a right angle.
pub(crate) const MEAN_STEPS: usize = 10;
/// Squarings of the matrix whose dominant axis starts the mean: its 2¹⁶th power tells axes apart that differ by 10⁻⁴.
const SQUARINGS: usize = 16;

/// c₀ = 1, c_n = c_{n−1} (2n − 1)² / (2n (2n + 1)).
const fn arc_sine() -> [f64; 12] {
    let mut coefficients = [1.0; 12];
    let mut n = 1;
    while n < coefficients.len() {
        let odd = (2 * n - 1) as f64;
        coefficients[n] = coefficients[n - 1] * odd * odd / (2 * n * (2 * n + 1)) as f64;
        n += 1;
    }
    coefficients
}

/// The rotation vector of a unit quaternion, radians, at most π long. The same for q and −q.
pub fn rotation_log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let quaternion = rotation.quaternion();
    let imaginary = Vector3::new(quaternion.i, quaternion.j, quaternion.k);
    // At half a turn w is 0 and both signs are as near: the first component that is not 0 decides.
    let flip = if quaternion.w == 0.0 {
        imaginary.iter().find(|value| **value != 0.0).is_some_and(|value| *value < 0.0)
    } else {
        quaternion.w < 0.0
    };
    let (w, v) = if flip { (-quaternion.w, -imaginary) } else { (quaternion.w, imaginary) };
    let sine_squared = v.x * v.x + v.y * v.y + v.z * v.z;
    if sine_squared <= SERIES_SINE_SQUARED {
        let [.., last] = ARC_SINE;
        let rest = &ARC_SINE[..ARC_SINE.len() - 1];
        v * (2.0 * rest.iter().rev().fold(last, |sum, coefficient| sum * sine_squared + coefficient))
    } else {
        let sine = libm::sqrt(sine_squared);
        v * (2.0 * libm::atan2(sine, w) / sine)
    }
}

/// The unit quaternion that turns by `vector`, radians. Inverse of [`rotation_log`] up to a length of π.
pub fn rotation_exp(vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = length(vector);
    let (w, scale) = if angle < SMALL_ANGLE {
        (1.0 - angle * angle / 8.0, 0.5)
    } else {
        (libm::cos(0.5 * angle), libm::sin(0.5 * angle) / angle)
    };
    unit(Quaternion::new(w, vector.x * scale, vector.y * scale, vector.z * scale))
}

/// Log at `base` of `pose`: metres, radians.
pub fn log(base: &Pose, pose: &Pose) -> Tangent {
    let position = pose.translation.vector - base.translation.vector;
    let rotation = rotation_log(&(base.rotation.conjugate() * pose.rotation));
    Tangent::new(position.x, position.y, position.z, rotation.x, rotation.y, rotation.z)
}

/// Exp at `base` of `tangent`: inverse of [`log`] up to a rotation of π.
pub fn exp(base: &Pose, tangent: &Tangent) -> Pose {
    let position = base.translation.vector + Vector3::new(tangent[0], tangent[1], tangent[2]);
    let turned = turn(&base.rotation, &Vector3::new(tangent[3], tangent[4], tangent[5]));
    Pose::from_parts(Translation3::from(position), turned)
}

/// The weighted mean of poses on the manifold: where the weighted logarithms sum to 0 (Karcher mean).
///
/// `weights` are not negative, one a pose. The identity where there is no weight at all.
pub fn karcher_mean(poses: &[Pose], weights: &[f64]) -> Pose {
    // The dominant axis of Σ w q qᵀ (Markley et al. 2007) is a start that depends neither on the order of the poses nor on
    // the signs of their quaternions. Squaring the matrix brings it out.
    let mut axes = Matrix4::zeros();
    for (pose, weight) in poses.iter().zip(weights) {
        let quaternion = pose.rotation.coords;
        axes += quaternion * quaternion.transpose() * *weight;
    }
    for _ in 0..SQUARINGS {
        let trace = axes.trace();
        if trace <= 0.0 {
            return Pose::identity();
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
    let start = unit(Quaternion::from(axes.column(longest).into_owned()));
    karcher_mean_from(&start, poses, weights)
}

/// [`karcher_mean`] from a first guess of the rotation.
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

/// A rotation turned on by a rotation vector in its own frame.
pub(crate) fn turn(base: &UnitQuaternion<f64>, vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    unit((base * rotation_exp(vector)).into_inner())
}

/// The length of a vector; its root is exact to the last bit on every platform.
fn length(vector: &Vector3<f64>) -> f64 {
    libm::sqrt(vector.x * vector.x + vector.y * vector.y + vector.z * vector.z)
}

fn unit(quaternion: Quaternion<f64>) -> UnitQuaternion<f64> {
    let norm = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
    UnitQuaternion::new_unchecked(quaternion / norm)
}
