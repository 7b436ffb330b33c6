//! Poses as points of R³ × S³: logarithm, exponential and mean.
//!
//! A Gaussian over poses has its mean on the manifold and its covariance in the tangent space at that mean (decision D13;
//! Zeestraten et al., RA-L 2017; Calinon 2019). The position part is the plain difference in metres; the rotation part is the
//! rotation vector, in the frame of the base, that turns the base into the pose.

use nalgebra::{Matrix4, Quaternion, SVector, Translation3, UnitQuaternion, Vector3};
use pulp::Scalar256b;

use crate::demonstration::Pose;
use crate::vector::{Four, Wide, polynomial};

/// A tangent vector: position in metres (3), then rotation vector in radians (3).
pub type Tangent = SVector<f64, 6>;

/// Below this angle, radians, sine and cosine are taken from the first terms of their series, for the next are under the rounding error.
const SMALL_ANGLE: f64 = 1e-8;
/// Up to this squared sine of the half-angle (29°) the logarithm is a polynomial.
const NEAR_SINE_SQUARED: f64 = 0.0625;
/// Coefficients of the series of 2 asin(s)/s in s²: up to [`NEAR_SINE_SQUARED`] the next term is under the rounding error.
const TWICE_ARC_SINE: [[f64; 4]; 3] = twice_arc_sine();

/// The mean is found when a step is shorter than this, radians.
pub(crate) const MEAN_TOLERANCE: f64 = 1e-9;
/// Steps of the mean at most. It converges in two or three where the rotations are within a right angle.
pub(crate) const MEAN_STEPS: usize = 10;
/// Squarings of the matrix whose dominant axis starts the mean: its 2¹⁶th power tells axes apart that differ by 10⁻⁴.
const SQUARINGS: usize = 16;

/// c₀ = 2, c_n = c_{n−1} (2n − 1)² / (2n (2n + 1)).
const fn twice_arc_sine() -> [[f64; 4]; 3] {
    let mut coefficients = [[2.0; 4]; 3];
    let mut n = 1;
    while n < 12 {
        let odd = (2 * n - 1) as f64;
        coefficients[n / 4][n % 4] = coefficients[(n - 1) / 4][(n - 1) % 4] * odd * odd / (2 * n * (2 * n + 1)) as f64;
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
    v * scale(w, sine_squared)
}

/// What the imaginary part of a unit quaternion is to be multiplied by to be the rotation vector: by its real part, not below 0, and the
/// squared sine of the half-angle.
fn scale(cosine: f64, sine_squared: f64) -> f64 {
    let simd = Scalar256b;
    let [cosine, sine_squared] = [cosine, sine_squared].map(|number| Four::splat(simd, number));
    scales(cosine, sine_squared).numbers()[0]
}

/// [`scale`] of four at once.
#[inline(always)]
pub(crate) fn scales<S: Wide>(cosines: Four<S>, sines_squared: Four<S>) -> Four<S> {
    if sines_squared.all_at_most(NEAR_SINE_SQUARED) {
        return polynomial(sines_squared, &TWICE_ARC_SINE);
    }
    // The angle is halved three times, and so is near. Half the angle has the cosine c' = √((1 + c)/2) and the sine s/(2c'). A square root is
    // rounded correctly on every machine.
    let first = (cosines * 0.5 + 0.5).sqrt();
    let second = (first * 0.5 + 0.5).sqrt();
    let third = (second * 0.5 + 0.5).sqrt();
    let halved = first * second * third;
    let near = sines_squared.at_most(NEAR_SINE_SQUARED, sines_squared, sines_squared / (halved * halved * 64.0));
    let one = halved * 0.0 + 1.0;
    polynomial(near, &TWICE_ARC_SINE) / sines_squared.at_most(NEAR_SINE_SQUARED, one, halved)
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
