//! The residuals of all frames at a mean, and their sums.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::frames::{AXES, Block, Frames, Gaussian, Mean, TRIANGLE, residuals_of};
use crate::demonstration::Pose;
use crate::keyframe::pose::Tangent;
use crate::vector::{Four, Kernel, LANES, Wide, fours, fours_mut, widest};

/// Tangent vectors at one mean, metres and radians, position first.
pub(super) struct Residuals {
    blocks: Vec<Block<AXES>>,
}

impl Residuals {
    /// Allocates the residuals of these frames.
    pub(super) fn new(frames: &Frames) -> Self {
        Self { blocks: vec![Block::default(); frames.positions.len()] }
    }

    /// Computes the residuals of all frames at a mean. Returns Σ weight · turn, with the weights in a padded column.
    pub(super) fn measure(&mut self, frames: &Frames, mean: &Pose, weights: &[f64]) -> Vector3<f64> {
        let weights = fours(weights);
        widest(Measure { frames, mean: Mean::of(mean), weights, residuals: &mut self.blocks }).into()
    }

    /// [`Residuals::measure`] for the positions only.
    pub(super) fn measure_positions(&mut self, frames: &Frames, mean: &Vector3<f64>) {
        for (residuals, positions) in self.blocks.iter_mut().zip(&frames.positions) {
            for ((residuals, positions), mean) in residuals.iter_mut().zip(positions).zip(mean.iter()) {
                for lane in 0..LANES {
                    residuals[lane] = positions[lane] - mean;
                }
            }
        }
    }

    /// Σ weight · r and Σ weight · r rᵀ, with the weights in a padded column. Only these blocks have weights above 0.
    pub(super) fn moments(&self, weights: &[f64], blocks: &[usize]) -> (Tangent, Matrix6<f64>) {
        let (sums, entries) = widest(Moments { residuals: &self.blocks, weights: fours(weights), blocks });
        let mut scatter = Matrix6::zeros();
        let mut at = 0;
        for row in 0..AXES {
            for column in 0..=row {
                (scatter[(row, column)], scatter[(column, row)]) = (entries[at], entries[at]);
                at += 1;
            }
        }
        (sums.into(), scatter)
    }

    /// Writes the log density of every frame's pose under a Gaussian at the residuals' mean into a padded column.
    pub(super) fn log_densities(&self, gaussian: Gaussian, log_densities: &mut [f64]) {
        widest(OfResiduals { residuals: &self.blocks, gaussian, log_densities: fours_mut(log_densities) });
    }
}

struct Measure<'a> {
    frames: &'a Frames,
    mean: Mean,
    weights: &'a [[f64; LANES]],
    residuals: &'a mut [Block<AXES>],
}

impl Kernel for Measure<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) -> [f64; 3] {
        let mut sums = [Four::splat(simd, 0.0); 3];
        let frames = self.frames.positions.iter().zip(&self.frames.rotations);
        for (((positions, rotations), weights), block) in frames.zip(self.weights).zip(self.residuals) {
            let residuals = residuals_of(simd, positions, rotations, &self.mean);
            let weights = Four::new(simd, *weights);
            for (sum, turn) in sums.iter_mut().zip(&residuals[3..]) {
                *sum += weights * *turn;
            }
            for (numbers, residuals) in block.iter_mut().zip(residuals) {
                *numbers = residuals.numbers();
            }
        }
        Four::all_joined(sums)
    }
}

struct OfResiduals<'a> {
    residuals: &'a [Block<AXES>],
    gaussian: Gaussian,
    log_densities: &'a mut [[f64; LANES]],
}

impl Kernel for OfResiduals<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        for (residuals, log_densities) in self.residuals.iter().zip(self.log_densities) {
            *log_densities = self.gaussian.log_densities(simd, Four::all(simd, residuals)).numbers();
        }
    }
}

struct Moments<'a> {
    residuals: &'a [Block<AXES>],
    weights: &'a [[f64; LANES]],
    blocks: &'a [usize],
}

impl Kernel for Moments<'_> {
    type Output = ([f64; AXES], [f64; TRIANGLE]);

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) -> ([f64; AXES], [f64; TRIANGLE]) {
        let (mut sums, mut entries) = ([0.0; AXES], [0.0; TRIANGLE]);
        // A third of the entries at a time: the registers cannot hold more running sums.
        self.rows::<S, 3, 6>(simd, 0, &mut sums[..3], &mut entries[..6]);
        self.rows::<S, 2, 9>(simd, 3, &mut sums[3..5], &mut entries[6..15]);
        self.rows::<S, 1, 6>(simd, 5, &mut sums[5..], &mut entries[15..]);
        (sums, entries)
    }
}

impl Moments<'_> {
    /// Some rows of the lower triangle.
    #[inline(always)]
    fn rows<S: Wide, const ROWS: usize, const ENTRIES: usize>(
        &self,
        simd: S,
        first: usize,
        sums: &mut [f64],
        entries: &mut [f64],
    ) {
        let (mut shares, mut products) = ([Four::splat(simd, 0.0); ROWS], [Four::splat(simd, 0.0); ENTRIES]);
        for block in self.blocks {
            let weights = Four::new(simd, self.weights[*block]);
            let residuals = &self.residuals[*block];
            let mut at = 0;
            for (row, sum) in (first..).zip(&mut shares) {
                let share = weights * Four::new(simd, residuals[row]);
                *sum += share;
                for column in &residuals[..=row] {
                    products[at] += share * Four::new(simd, *column);
                    at += 1;
                }
            }
        }
        sums.copy_from_slice(&Four::all_joined(shares));
        entries.copy_from_slice(&Four::all_joined(products));
    }
}

/// The next step of the mean. `turn` is the weighted sum of the turns, and `scatter` their weighted scatter about the
/// mean, both divided by the sum of the weights.
///
/// The slope of the logarithm at a turn r is 1 + (r×)²/12 plus higher terms. With this slope, the steps converge at
/// once if the turns are small.
pub(super) fn mean_step(turn: &Vector3<f64>, scatter: &Matrix3<f64>) -> Vector3<f64> {
    let slope = Matrix3::identity() - (Matrix3::from_diagonal_element(scatter.trace()) - scatter) / 12.0;
    // The eigenvalues are above 0.1 for any turns, as turns are at most π long.
    slope.try_inverse().map_or(*turn, |inverse| inverse * turn)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Quaternion, UnitQuaternion};

    use super::*;
    use crate::keyframe::pose::rotation_log;

    /// Half a turn has two rotation vectors. The kernel and [`rotation_log`] choose the same.
    #[test]
    fn half_a_turn() {
        let rotations = [[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -0.6, 0.8, 0.0], [0.0, 0.6, -0.8, -0.0]];
        let pose = |[i, j, k, w]: [f64; 4]| {
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
            Pose::from_parts(Vector3::zeros().into(), rotation)
        };
        let poses = rotations.map(pose);
        let frames = Frames::new(poses.iter());
        let mut residuals = Residuals::new(&frames);
        residuals.measure(&frames, &Pose::identity(), &[0.0; LANES]);
        for (frame, pose) in poses.iter().enumerate() {
            let found = Vector3::from_fn(|axis, _| residuals.blocks[frame / LANES][3 + axis][frame % LANES]);
            assert_eq!(found, rotation_log(&pose.rotation));
        }
    }
}
