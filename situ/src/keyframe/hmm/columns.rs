//! Frames and their residuals as structures of arrays: what the fit goes through again and again, many frames at once.
//!
//! Sums are [`dot`]s, so that they have the same bits on every machine.

use core::ops::Range;

use nalgebra::{Matrix6, UnitQuaternion, Vector3};

use crate::demonstration::Pose;
use crate::keyframe::logistic::dot;
use crate::keyframe::pose::{ARC_SINE, SERIES_SINE_SQUARED, rotation_log};

/// The poses of all frames.
pub(super) struct Frames {
    poses: Vec<Pose>,
    position: [Vec<f64>; 3],
    /// i, j, k, w.
    rotation: [Vec<f64>; 4],
}

impl Frames {
    pub(super) fn new(poses: Vec<Pose>) -> Self {
        let position = [0, 1, 2].map(|axis| poses.iter().map(|pose| pose.translation.vector[axis]).collect());
        let rotation = [0, 1, 2, 3].map(|axis| poses.iter().map(|pose| pose.rotation.coords[axis]).collect());
        Self { poses, position, rotation }
    }

    pub(super) fn len(&self) -> usize {
        self.poses.len()
    }

    pub(super) fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Σ weight · position, metres.
    pub(super) fn weighted_position(&self, weights: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| dot(weights, &self.position[axis]))
    }

    /// The rotations' part of every frame's residual at a mean: [`rotation_log`] of all.
    pub(super) fn turns(&self, mean: &UnitQuaternion<f64>, turns: [&mut [f64]; 3]) {
        let n = self.len();
        let [mi, mj, mk, mw]: [f64; 4] = mean.coords.into();
        let [qi, qj, qk, qw] = self.rotation.each_ref().map(|column| &column[..n]);
        let [ri, rj, rk] = turns.map(|column| &mut column[..n]);
        let mut far = false;
        for frame in 0..n {
            let (i, j, k, w) = (qi[frame], qj[frame], qk[frame], qw[frame]);
            // Of the mean's conjugate times the rotation.
            let real = mw * w + mi * i + mj * j + mk * k;
            let (i, j, k) = (
                mw * i - mi * w - mj * k + mk * j,
                mw * j + mi * k - mj * w - mk * i,
                mw * k - mi * j + mj * i - mk * w,
            );
            let sine_squared = i * i + j * j + k * k;
            far |= sine_squared > SERIES_SINE_SQUARED;
            let mut series = ARC_SINE[ARC_SINE.len() - 1];
            for coefficient in ARC_SINE[..ARC_SINE.len() - 1].iter().rev() {
                series = series * sine_squared + coefficient;
            }
            let scale = (2.0 * series).copysign(real);
            (ri[frame], rj[frame], rk[frame]) = (i * scale, j * scale, k * scale);
        }
        if far {
            let back = mean.conjugate();
            for (frame, pose) in self.poses.iter().enumerate() {
                let turn = back * pose.rotation;
                if turn.coords.xyz().norm_squared() > 0.5 * SERIES_SINE_SQUARED {
                    let residual = rotation_log(&turn);
                    (ri[frame], rj[frame], rk[frame]) = (residual.x, residual.y, residual.z);
                }
            }
        }
    }
}

/// Tangent vectors, metres and radians, position first.
pub(super) struct Residuals {
    axes: [Vec<f64>; 6],
}

impl Residuals {
    pub(super) fn new(count: usize) -> Self {
        Self { axes: [(); 6].map(|()| vec![0.0; count]) }
    }

    /// The residuals of all frames at a mean, into these cells.
    pub(super) fn measure(&mut self, cells: Range<usize>, frames: &Frames, mean: &Pose) {
        self.measure_positions(cells.clone(), frames, &mean.translation.vector);
        self.measure_turns(cells, frames, &mean.rotation);
    }

    /// The positions' part of [`Residuals::measure`].
    pub(super) fn measure_positions(&mut self, cells: Range<usize>, frames: &Frames, mean: &Vector3<f64>) {
        for (axis, (residuals, positions)) in self.axes.iter_mut().zip(&frames.position).enumerate() {
            for (residual, position) in residuals[cells.clone()].iter_mut().zip(positions) {
                *residual = position - mean[axis];
            }
        }
    }

    /// The rotations' part of [`Residuals::measure`].
    pub(super) fn measure_turns(&mut self, cells: Range<usize>, frames: &Frames, mean: &UnitQuaternion<f64>) {
        let [_, _, _, i, j, k] = &mut self.axes;
        frames.turns(mean, [&mut i[cells.clone()], &mut j[cells.clone()], &mut k[cells]]);
    }

    /// Copies the cells' rotations from others.
    pub(super) fn copy_turns(&mut self, other: &Self, cells: Range<usize>) {
        for (own, other) in self.axes[3..].iter_mut().zip(&other.axes[3..]) {
            own.copy_from_slice(&other[cells.clone()]);
        }
    }

    /// Copies all of other residuals into these cells.
    pub(super) fn copy_into(&mut self, cells: Range<usize>, other: &Self) {
        for (own, other) in self.axes.iter_mut().zip(&other.axes) {
            own[cells.clone()].copy_from_slice(other);
        }
    }

    /// Σ weight · rotation of these cells, radians.
    pub(super) fn weighted_turn(&self, cells: Range<usize>, weights: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| dot(weights, &self.axes[3 + axis][cells.clone()]))
    }

    /// Σ weight · r rᵀ of these cells.
    pub(super) fn scatter(&self, cells: Range<usize>, weights: &[f64]) -> Matrix6<f64> {
        let [x, y, z, i, j, k] = self.axes.each_ref().map(|axis| &axis[cells.clone()][..weights.len()]);
        let mut scatter = Matrix6::zeros();
        for (frame, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let r = [x[frame], y[frame], z[frame], i[frame], j[frame], k[frame]];
            for column in 0..6 {
                let weighted = weight * r[column];
                for row in column..6 {
                    scatter[(row, column)] += weighted * r[row];
                }
            }
        }
        scatter.fill_upper_triangle_with_lower_triangle();
        scatter
    }

    /// Squared lengths |W r|² of these cells, W lower triangular.
    pub(super) fn squared_lengths(&self, cells: Range<usize>, whitening: &Matrix6<f64>, lengths: &mut [f64]) {
        let n = lengths.len();
        let [x, y, z, i, j, k] = self.axes.each_ref().map(|axis| &axis[cells.clone()][..n]);
        let w = whitening;
        for (frame, length) in lengths.iter_mut().enumerate() {
            let r = [x[frame], y[frame], z[frame], i[frame], j[frame], k[frame]];
            let mut sum = 0.0;
            for row in 0..6 {
                let mut whitened = 0.0;
                for column in 0..=row {
                    whitened += w[(row, column)] * r[column];
                }
                sum += whitened * whitened;
            }
            *length = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::keyframe::pose::{Tangent, exp, log};

    /// Near and far frames alike: past 29° a rotation's logarithm is no polynomial.
    #[test]
    fn many_frames_at_once_are_what_one_is() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for spread in [0.0, 1e-9, 0.1, 0.5, 1.5, 3.0] {
            let mut draw = |size: f64| size * (2.0 * rng.random::<f64>() - 1.0);
            let mean = Pose::from_parts(
                Translation3::new(draw(1.0), draw(1.0), draw(1.0)),
                UnitQuaternion::from_scaled_axis(Vector3::new(draw(2.0), draw(2.0), draw(2.0))),
            );
            let poses: Vec<Pose> = (0..41).map(|_| exp(&mean, &Tangent::from_fn(|_, _| draw(spread)))).collect();
            let weights: Vec<f64> = (0..41).map(|frame| if frame % 3 == 0 { 0.0 } else { draw(0.5) + 0.5 }).collect();
            let frames = Frames::new(poses.clone());
            let mut residuals = Residuals::new(2 * frames.len());
            let cells = frames.len()..2 * frames.len();
            residuals.measure(cells.clone(), &frames, &mean);
            let whitening = Matrix6::from_fn(|row, column| if column <= row { draw(3.0) } else { 0.0 });
            let mut lengths = vec![0.0; frames.len()];
            residuals.squared_lengths(cells.clone(), &whitening, &mut lengths);
            let (mut turn, mut scatter) = (Vector3::zeros(), Matrix6::zeros());
            for ((pose, weight), length) in poses.iter().zip(&weights).zip(&lengths) {
                let residual = log(&mean, pose);
                let expected = (whitening * residual).norm_squared();
                assert!((length - expected).abs() <= 1e-12 * (1.0 + expected), "{spread}: {length} for {expected}");
                turn += residual.fixed_rows::<3>(3) * *weight;
                scatter += residual * residual.transpose() * *weight;
            }
            assert!((residuals.weighted_turn(cells.clone(), &weights) - turn).norm() <= 1e-13 * (1.0 + spread));
            assert!((residuals.scatter(cells, &weights) - scatter).norm() <= 1e-12 * (1.0 + scatter.norm()));
        }
    }
}
