//! Frames and their residuals in blocks: what the fit goes through again and again, four frames at once.
//!
//! A block has four numbers along each axis. The last is filled up, and a column of one number a frame is padded to
//! whole fours ([`LANES`]); what is computed of the padding counts nowhere.

use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};

use super::Emission;
use crate::demonstration::Pose;
use crate::keyframe::pose::{Tangent, log_scales, rotation_log};
use crate::vector::{Four, Kernel, LANES, Wide, fours, fours_mut, widest};

/// Dimensions of a tangent vector.
const AXES: usize = 6;

/// A number of each of four frames, along each of some axes.
type Block<const N: usize> = [[f64; LANES]; N];

/// The poses of all frames.
pub(super) struct Frames {
    count: usize,
    positions: Vec<Block<3>>,
    /// i, j, k, w.
    rotations: Vec<Block<4>>,
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

    /// The log density of every frame under an emission, its command left out, into a padded column.
    pub(super) fn log_densities(&self, emission: &Emission, log_densities: &mut [f64]) {
        widest(OfFrames {
            frames: self,
            mean: Mean::of(&emission.mean),
            gaussian: Gaussian::of(emission),
            log_densities: fours_mut(log_densities),
        });
    }
}

/// A mean as numbers.
struct Mean {
    position: [f64; 3],
    /// i, j, k, w.
    rotation: [f64; 4],
}

impl Mean {
    fn of(pose: &Pose) -> Self {
        Self { position: pose.translation.vector.into(), rotation: pose.rotation.coords.into() }
    }
}

/// Tangent vectors at one mean, metres and radians, position first.
pub(super) struct Residuals {
    blocks: Vec<Block<AXES>>,
}

impl Residuals {
    /// Room for those of the frames.
    pub(super) fn new(frames: &Frames) -> Self {
        Self { blocks: vec![Block::default(); frames.positions.len()] }
    }

    /// The residuals of all frames at a mean; returns Σ weight · turn, of weights in a padded column.
    pub(super) fn measure(&mut self, frames: &Frames, mean: &Pose, weights: &[f64]) -> Vector3<f64> {
        let weights = fours(weights);
        widest(Measure { frames, mean: Mean::of(mean), weights, residuals: &mut self.blocks }).into()
    }

    /// The positions' part of [`Residuals::measure`].
    pub(super) fn measure_positions(&mut self, frames: &Frames, mean: &Vector3<f64>) {
        for (residuals, positions) in self.blocks.iter_mut().zip(&frames.positions) {
            for ((residuals, positions), mean) in residuals.iter_mut().zip(positions).zip(mean.iter()) {
                for lane in 0..LANES {
                    residuals[lane] = positions[lane] - mean;
                }
            }
        }
    }

    /// Σ weight · r and Σ weight · r rᵀ, of weights in a padded column over these blocks of it: the others have none.
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

    /// The log density of every frame under an emission with this mean, its command left out, into a padded column.
    pub(super) fn log_densities(&self, emission: &Emission, log_densities: &mut [f64]) {
        widest(OfResiduals {
            residuals: &self.blocks,
            gaussian: Gaussian::of(emission),
            log_densities: fours_mut(log_densities),
        });
    }
}

/// Entries of a lower triangle.
const TRIANGLE: usize = AXES * (AXES + 1) / 2;

/// What a log density is made of.
struct Gaussian {
    /// W with |W r|² the squared Mahalanobis length of r: a lower triangle, row by row.
    whitening: [f64; TRIANGLE],
    normaliser: f64,
}

impl Gaussian {
    fn of(emission: &Emission) -> Self {
        let mut whitening = [0.0; TRIANGLE];
        let mut at = 0;
        for row in 0..AXES {
            for column in 0..=row {
                whitening[at] = emission.whitening()[(row, column)];
                at += 1;
            }
        }
        Self { whitening, normaliser: emission.log_normaliser() }
    }

    /// Of four residuals.
    #[inline(always)]
    fn log_densities<S: Wide>(&self, simd: S, residuals: [Four<S>; AXES]) -> Four<S> {
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
        Four::splat(simd, self.normaliser) - squared * 0.5
    }
}

/// [`rotation_log`] of four rotations at a mean.
#[inline(always)]
fn turns_of<S: Wide>(simd: S, rotations: &Block<4>, mean: [f64; 4]) -> [Four<S>; 3] {
    let [i, j, k, w] = Four::all(simd, rotations);
    let [mi, mj, mk, mw] = mean;
    // The mean's conjugate times the rotation.
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

/// The same where there is half a turn among the four, of which no sign is nearer: [`rotation_log`] chooses.
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
fn residuals_of<S: Wide>(simd: S, positions: &Block<3>, rotations: &Block<4>, mean: &Mean) -> [Four<S>; AXES] {
    let [x, y, z] = Four::all(simd, positions);
    let [i, j, k] = turns_of(simd, rotations, mean.rotation);
    [x - mean.position[0], y - mean.position[1], z - mean.position[2], i, j, k]
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
        // A third of the entries at a time: more running sums than that are not held in registers.
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

/// The mean's next step, from the weighted sum of the turns and their scatter about the mean, both over the weights'
/// sum.
///
/// The logarithm's slope at a turn r is 1 + (r×)²/12 and higher terms; with it the steps converge at once where the
/// turns are small.
pub(super) fn mean_step(turn: &Vector3<f64>, scatter: &Matrix3<f64>) -> Vector3<f64> {
    let slope = Matrix3::identity() - (Matrix3::from_diagonal_element(scatter.trace()) - scatter) / 12.0;
    // Its eigenvalues are above 0.1 whatever the turns: they are at most π long.
    slope.try_inverse().map_or(*turn, |inverse| inverse * turn)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use nalgebra::Quaternion;

    use super::*;
    use crate::keyframe::pose::{exp, log};

    /// Blocks of frames and one frame after the other, near the mean and as far as a rotation can be.
    #[test]
    fn blocks_are_what_one_frame_after_the_other_is() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draw = |spread: f64| spread * (rng.random::<f64>() - 0.5);
        let mean = exp(&Pose::identity(), &Tangent::from_fn(|_, _| draw(2.0)));
        for (spread, count) in [(0.1, 41), (1.0, 40), (3.0, 7), (6.0, 64), (0.2, 1)] {
            let poses: Vec<Pose> = (0..count).map(|_| exp(&mean, &Tangent::from_fn(|_, _| draw(spread)))).collect();
            let frames = Frames::new(poses.iter());
            let mut weights = vec![0.0; frames.padded()];
            let share = |frame: usize| if frame.is_multiple_of(3) || frame / 4 == 2 { 0.0 } else { draw(0.5) + 0.5 };
            weights[..count].iter_mut().zip((0..count).map(share)).for_each(|(weight, share)| *weight = share);
            let mut residuals = Residuals::new(&frames);
            let turned = residuals.measure(&frames, &mean, &weights);
            let covariance =
                Matrix6::from_fn(|row, column| if row == column { 3.0 } else { 0.3 + 0.1 * (row + column) as f64 });
            let emission = Emission::new(mean, covariance, Matrix6::zeros(), None).unwrap();
            let (mut found, mut of_frames) = (vec![0.0; frames.padded()], vec![0.0; frames.padded()]);
            residuals.log_densities(&emission, &mut found);
            frames.log_densities(&emission, &mut of_frames);
            let (mut sum, mut scatter) = (Tangent::zeros(), Matrix6::zeros());
            for (frame, pose) in poses.iter().enumerate() {
                let residual = log(&mean, pose);
                let expected = emission.pose_log_density(pose);
                assert!((found[frame] - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{spread}: {expected}");
                assert_eq!(found[frame].to_bits(), of_frames[frame].to_bits());
                sum += residual * weights[frame];
                scatter += residual * residual.transpose() * weights[frame];
            }
            let blocks: Vec<usize> = (0..frames.padded() / LANES).filter(|block| *block != 2).collect();
            let found = residuals.moments(&weights, &blocks);
            assert!((found.0 - sum).norm() <= 1e-13 * (1.0 + sum.norm()));
            assert!((turned - sum.fixed_rows::<3>(3)).norm() <= 1e-13 * (1.0 + sum.norm()));
            assert!((found.1 - scatter).norm() <= 1e-12 * (1.0 + scatter.norm()));
        }
    }

    /// Half a turn has two rotation vectors, and both ways choose the same.
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
