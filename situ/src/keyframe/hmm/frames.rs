//! Frames in blocks of four: the fit reads them again and again, four frames at once.
//!
//! A block has four numbers along each axis. The last block is filled up, and a column with one number per frame is
//! padded to whole fours ([`LANES`]). What is computed from the padding counts nowhere.

use nalgebra::{Matrix6, UnitQuaternion};

use crate::demonstration::Pose;
use crate::keyframe::pose::{log_scales, rotation_log};
use crate::vector::{Four, Kernel, LANES, Wide, fours_mut, widest};

/// The number of dimensions of a tangent vector.
pub(super) const AXES: usize = 6;
/// The number of entries of a lower triangle.
pub(super) const TRIANGLE: usize = AXES * (AXES + 1) / 2;

/// The log density of a Gaussian as a function of the residuals: `log_normaliser` − ½ |W r|².
pub(super) struct Gaussian {
    /// The lower triangle of W, row by row.
    whitening: [f64; TRIANGLE],
    log_normaliser: f64,
}

impl Gaussian {
    /// From W, which is lower triangular; |W r|² is the squared Mahalanobis length of r.
    pub(super) fn new(whitening: &Matrix6<f64>, log_normaliser: f64) -> Self {
        let mut triangle = [0.0; TRIANGLE];
        let mut at = 0;
        for row in 0..AXES {
            for column in 0..=row {
                triangle[at] = whitening[(row, column)];
                at += 1;
            }
        }
        Self { whitening: triangle, log_normaliser }
    }

    /// The log densities of four residuals.
    #[inline(always)]
    pub(super) fn log_densities<S: Wide>(&self, simd: S, residuals: [Four<S>; AXES]) -> Four<S> {
        let mut squared = Four::splat(simd, 0.0);
        let mut at = 0;
        for row in 0..AXES {
            let mut whitened = residuals[0] * self.whitening[at];
            at += 1;
            for residual in &residuals[1..=row] {
                whitened += *residual * self.whitening[at];
                at += 1;
            }
            squared += whitened * whitened;
        }
        Four::splat(simd, self.log_normaliser) - squared * 0.5
    }
}

/// Four frames, along each of N axes.
pub(super) type Block<const N: usize> = [[f64; LANES]; N];

/// The poses of all frames.
pub(super) struct Frames {
    count: usize,
    pub(super) positions: Vec<Block<3>>,
    /// i, j, k, w.
    pub(super) rotations: Vec<Block<4>>,
}

impl Frames {
    pub(super) fn new<'a>(poses: impl ExactSizeIterator<Item = &'a Pose>) -> Self {
        let count = poses.len();
        let blocks = count.div_ceil(LANES);
        let (mut positions, mut rotations) = (vec![Block::default(); blocks], vec![Block::default(); blocks]);
        for (frame, pose) in poses.enumerate() {
            // The last block is filled up with its first pose.
            let lanes = if frame.is_multiple_of(LANES) { 0..LANES } else { frame % LANES..frame % LANES + 1 };
            for lane in lanes {
                let (position, rotation) = (&mut positions[frame / LANES], &mut rotations[frame / LANES]);
                position.iter_mut().zip(&pose.translation.vector).for_each(|(axis, number)| axis[lane] = *number);
                rotation.iter_mut().zip(&pose.rotation.coords).for_each(|(axis, number)| axis[lane] = *number);
            }
        }
        Self { count, positions, rotations }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The length of a padded column.
    pub(super) fn padded(&self) -> usize {
        self.count.next_multiple_of(LANES)
    }

    /// Writes the log density of every frame's pose under a Gaussian at a mean into a padded column.
    pub(super) fn log_densities(&self, mean: &Pose, gaussian: Gaussian, log_densities: &mut [f64]) {
        widest(OfFrames { frames: self, mean: Mean::of(mean), gaussian, log_densities: fours_mut(log_densities) });
    }
}

/// A mean pose as plain numbers.
pub(super) struct Mean {
    pub(super) position: [f64; 3],
    /// i, j, k, w.
    rotation: [f64; 4],
}

impl Mean {
    pub(super) fn of(pose: &Pose) -> Self {
        Self { position: pose.translation.vector.into(), rotation: pose.rotation.coords.into() }
    }
}

/// [`rotation_log`] of four rotations at a mean.
#[inline(always)]
fn turns_of<S: Wide>(simd: S, rotations: &Block<4>, mean: [f64; 4]) -> [Four<S>; 3] {
    let [i, j, k, w] = Four::all(simd, rotations);
    let [mi, mj, mk, mw] = mean;
    // The conjugate of the mean times the rotation.
    let real = w * mw + i * mi + j * mj + k * mk;
    let x = i * mw - w * mi - k * mj + j * mk;
    let y = j * mw + k * mi - w * mj - i * mk;
    let z = k * mw - j * mi + i * mj - w * mk;
    let scale = log_scales(real.abs());
    if real.has_zero() {
        return half_turns(simd, real, [x, y, z], scale);
    }
    let scale = scale.with_signs_of(real);
    [x * scale, y * scale, z * scale]
}

/// The same if one of the four is half a turn. There neither sign is nearer, and [`rotation_log`] chooses.
#[cold]
fn half_turns<S: Wide>(simd: S, real: Four<S>, imaginary: [Four<S>; 3], scale: Four<S>) -> [Four<S>; 3] {
    let [mut x, mut y, mut z] = imaginary.map(|vector| (vector * scale.with_signs_of(real)).numbers());
    for lane in 0..LANES {
        if real.numbers()[lane] == 0.0 {
            let [i, j, k] = imaginary.map(|vector| vector.numbers()[lane]);
            let half_turn = UnitQuaternion::new_unchecked([i, j, k, 0.0].into());
            [x[lane], y[lane], z[lane]] = rotation_log(&half_turn).into();
        }
    }
    [x, y, z].map(|numbers| Four::new(simd, numbers))
}

/// The residuals of four frames at a mean.
#[inline(always)]
pub(super) fn residuals_of<S: Wide>(
    simd: S,
    positions: &Block<3>,
    rotations: &Block<4>,
    mean: &Mean,
) -> [Four<S>; AXES] {
    let [x, y, z] = Four::all(simd, positions);
    let [i, j, k] = turns_of(simd, rotations, mean.rotation);
    [x - mean.position[0], y - mean.position[1], z - mean.position[2], i, j, k]
}

struct OfFrames<'a> {
    frames: &'a Frames,
    mean: Mean,
    gaussian: Gaussian,
    log_densities: &'a mut [[f64; LANES]],
}

impl Kernel for OfFrames<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let frames = self.frames.positions.iter().zip(&self.frames.rotations);
        for ((positions, rotations), log_densities) in frames.zip(self.log_densities) {
            let residuals = residuals_of(simd, positions, rotations, &self.mean);
            *log_densities = self.gaussian.log_densities(simd, residuals).numbers();
        }
    }
}
