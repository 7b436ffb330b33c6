//! Frames and their residuals as columns: what the fit goes through again and again, many frames at once.
//!
//! A column has one number a frame, and is padded to whole fours ([`LANES`]); what is computed of the padding counts nowhere.

use core::ops::Range;

use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};

use super::Emission;
use crate::demonstration::Pose;
use crate::keyframe::pose::{Tangent, rotation_log, scales};
use crate::vector::{Four, Kernel, LANES, Wide, all_fours, fours, padded, widest};

/// Dimensions of a tangent vector.
const AXES: usize = 6;

/// The poses of all frames.
pub(super) struct Frames {
    count: usize,
    /// x, y, z, then i, j, k, w.
    columns: [Vec<f64>; 7],
}

impl Frames {
    pub(super) fn new<'a>(poses: impl ExactSizeIterator<Item = &'a Pose>) -> Self {
        let count = poses.len();
        let mut columns = [(); 7].map(|()| Vec::with_capacity(padded(count)));
        for pose in poses {
            let numbers = pose.translation.vector.iter().chain(pose.rotation.coords.iter());
            columns.iter_mut().zip(numbers).for_each(|(column, number)| column.push(*number));
        }
        for column in &mut columns {
            let last = column.last().copied().unwrap_or_default();
            column.resize(padded(count), last);
        }
        Self { count, columns }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The length of a column.
    pub(super) fn padded(&self) -> usize {
        padded(self.count)
    }

    fn positions(&self) -> [&[f64]; 3] {
        [0, 1, 2].map(|axis| &self.columns[axis][..])
    }

    fn rotations(&self) -> [&[f64]; 4] {
        [3, 4, 5, 6].map(|axis| &self.columns[axis][..])
    }
}

/// Tangent vectors at one mean, metres and radians, position first.
pub(super) struct Residuals {
    axes: [Vec<f64>; AXES],
}

impl Residuals {
    /// Room for those of so many frames, padded.
    pub(super) fn new(length: usize) -> Self {
        Self { axes: [(); AXES].map(|()| vec![0.0; length]) }
    }

    /// The residuals of all frames at a mean.
    pub(super) fn measure(&mut self, frames: &Frames, mean: &Pose) {
        self.measure_positions(frames, &mean.translation.vector);
        self.measure_turns(frames, &mean.rotation);
    }

    /// The positions' part of [`Residuals::measure`].
    pub(super) fn measure_positions(&mut self, frames: &Frames, mean: &Vector3<f64>) {
        for ((residuals, positions), mean) in self.axes.iter_mut().zip(frames.positions()).zip(mean.iter()) {
            widest(Subtract { positions, mean: *mean, residuals });
        }
    }

    /// The rotations' part of [`Residuals::measure`].
    pub(super) fn measure_turns(&mut self, frames: &Frames, mean: &UnitQuaternion<f64>) {
        let [_, _, _, i, j, k] = &mut self.axes;
        widest(Turns { rotations: frames.rotations(), mean: mean.coords.into(), turns: [i, j, k] });
    }

    /// Σ weight · r.
    pub(super) fn weighted(&self, weights: &[f64]) -> Tangent {
        widest(Weighted { residuals: self.columns(), weights }).into()
    }

    /// Σ weight · r rᵀ.
    pub(super) fn scatter(&self, weights: &[f64]) -> Matrix6<f64> {
        let entries = widest(Scatter { residuals: self.columns(), weights });
        let mut scatter = Matrix6::zeros();
        let mut at = 0;
        for row in 0..AXES {
            for column in 0..=row {
                (scatter[(row, column)], scatter[(column, row)]) = (entries[at], entries[at]);
                at += 1;
            }
        }
        scatter
    }

    /// The log density of every frame under an emission with this mean, its command left out.
    pub(super) fn log_densities(&self, emission: &Emission, log_densities: &mut [f64]) {
        let gaussian = Gaussian::of(emission);
        widest(OfResiduals { residuals: self.columns(), gaussian, log_densities });
    }

    fn columns(&self) -> [&[f64]; AXES] {
        self.axes.each_ref().map(Vec::as_slice)
    }
}

impl Frames {
    /// The log density of every frame under an emission, its command left out.
    pub(super) fn log_densities(&self, emission: &Emission, log_densities: &mut [f64]) {
        let position = emission.mean.translation.vector.into();
        let rotation = emission.mean.rotation.coords.into();
        let (positions, rotations) = (self.positions(), self.rotations());
        widest(OfFrames { positions, rotations, position, rotation, gaussian: Gaussian::of(emission), log_densities });
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

struct Subtract<'a> {
    positions: &'a [f64],
    mean: f64,
    residuals: &'a mut [f64],
}

impl Kernel for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        for (residuals, positions) in self.residuals.as_chunks_mut().0.iter_mut().zip(fours(self.positions)) {
            *residuals = (Four::new(simd, *positions) - self.mean).numbers();
        }
    }
}

/// [`rotation_log`] of four rotations at a mean.
#[inline(always)]
fn turns_of<S: Wide>(simd: S, rotations: [&[f64; LANES]; 4], mean: [f64; 4]) -> [Four<S>; 3] {
    let [i, j, k, w] = Four::all(simd, rotations);
    let [mi, mj, mk, mw] = mean;
    // The mean's conjugate times the rotation.
    let real = w * mw + i * mi + j * mj + k * mk;
    let x = i * mw - w * mi - k * mj + j * mk;
    let y = j * mw + k * mi - w * mj - i * mk;
    let z = k * mw - j * mi + i * mj - w * mk;
    let scale = scales(real.abs(), x * x + y * y + z * z);
    if real.numbers().contains(&0.0) {
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

struct Turns<'a> {
    rotations: [&'a [f64]; 4],
    mean: [f64; 4],
    turns: [&'a mut [f64]; 3],
}

impl Kernel for Turns<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let [i, j, k, w] = all_fours(self.rotations);
        let [x, y, z] = self.turns.map(|column| column.as_chunks_mut().0);
        let turns = x.iter_mut().zip(y).zip(z);
        for (((i, j), (k, w)), ((x, y), z)) in i.iter().zip(j).zip(k.iter().zip(w)).zip(turns) {
            let [a, b, c] = turns_of(simd, [i, j, k, w], self.mean);
            (*x, *y, *z) = (a.numbers(), b.numbers(), c.numbers());
        }
    }
}

struct OfResiduals<'a> {
    residuals: [&'a [f64]; AXES],
    gaussian: Gaussian,
    log_densities: &'a mut [f64],
}

impl Kernel for OfResiduals<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let [x, y, z, i, j, k] = all_fours(self.residuals);
        let residuals = x.iter().zip(y).zip(z).zip(i.iter().zip(j).zip(k));
        for ((((x, y), z), ((i, j), k)), log_densities) in residuals.zip(self.log_densities.as_chunks_mut().0) {
            let residuals = Four::all(simd, [x, y, z, i, j, k]);
            *log_densities = self.gaussian.log_densities(simd, residuals).numbers();
        }
    }
}

struct OfFrames<'a> {
    positions: [&'a [f64]; 3],
    rotations: [&'a [f64]; 4],
    position: [f64; 3],
    rotation: [f64; 4],
    gaussian: Gaussian,
    log_densities: &'a mut [f64],
}

impl Kernel for OfFrames<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let ([x, y, z], [i, j, k, w]) = (all_fours(self.positions), all_fours(self.rotations));
        let frames = x.iter().zip(y).zip(z).zip(i.iter().zip(j).zip(k.iter().zip(w)));
        for ((((x, y), z), ((i, j), (k, w))), log_densities) in frames.zip(self.log_densities.as_chunks_mut().0) {
            let [mx, my, mz] = self.position;
            let (x, y, z) = (Four::new(simd, *x) - mx, Four::new(simd, *y) - my, Four::new(simd, *z) - mz);
            let [i, j, k] = turns_of(simd, [i, j, k, w], self.rotation);
            *log_densities = self.gaussian.log_densities(simd, [x, y, z, i, j, k]).numbers();
        }
    }
}

struct Weighted<'a> {
    residuals: [&'a [f64]; AXES],
    weights: &'a [f64],
}

impl Kernel for Weighted<'_> {
    type Output = [f64; AXES];

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) -> [f64; AXES] {
        let mut sums = [Four::splat(simd, 0.0); AXES];
        let [x, y, z, i, j, k] = all_fours(self.residuals);
        let residuals = x.iter().zip(y).zip(z).zip(i.iter().zip(j).zip(k));
        for (weights, (((x, y), z), ((i, j), k))) in fours(self.weights).iter().zip(residuals) {
            let weights = Four::new(simd, *weights);
            for (sum, column) in sums.iter_mut().zip([x, y, z, i, j, k]) {
                *sum += weights * Four::new(simd, *column);
            }
        }
        Four::all_joined(sums)
    }
}

struct Scatter<'a> {
    residuals: [&'a [f64]; AXES],
    weights: &'a [f64],
}

impl Kernel for Scatter<'_> {
    type Output = [f64; TRIANGLE];

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) -> [f64; TRIANGLE] {
        // Half of the entries at a time: more running sums than that are not held in registers.
        let mut entries = [0.0; TRIANGLE];
        let (upper, lower) = entries.split_at_mut(10);
        upper.copy_from_slice(&self.rows::<S, 10>(simd, 0..4));
        lower.copy_from_slice(&self.rows::<S, 11>(simd, 4..6));
        entries
    }
}

impl Scatter<'_> {
    /// The entries of these rows of the lower triangle. Fours of frames without weight are left out.
    #[inline(always)]
    fn rows<S: Wide, const ENTRIES: usize>(&self, simd: S, rows: Range<usize>) -> [f64; ENTRIES] {
        let mut sums = [Four::splat(simd, 0.0); ENTRIES];
        let [x, y, z, i, j, k] = all_fours(self.residuals);
        let residuals = x.iter().zip(y).zip(z).zip(i.iter().zip(j).zip(k));
        for (weights, (((x, y), z), ((i, j), k))) in fours(self.weights).iter().zip(residuals) {
            if *weights == [0.0; LANES] {
                continue;
            }
            let weights = Four::new(simd, *weights);
            let residuals = [x, y, z, i, j, k];
            let mut at = 0;
            for row in rows.clone() {
                let share = weights * Four::new(simd, *residuals[row]);
                for column in &residuals[..=row] {
                    sums[at] += share * Four::new(simd, **column);
                    at += 1;
                }
            }
        }
        Four::all_joined(sums)
    }
}

/// The mean's next step, from the weighted sum of the turns and their scatter about the mean, both over the weights' sum.
///
/// The logarithm's slope at a turn r is 1 + ([r]×)²/12 and higher terms; with it the steps converge at once where the turns are small.
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
    fn columns_are_what_one_frame_after_the_other_is() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draw = |spread: f64| spread * (rng.random::<f64>() - 0.5);
        let mean = exp(&Pose::identity(), &Tangent::from_fn(|_, _| draw(2.0)));
        for (spread, count) in [(0.1, 41), (1.0, 40), (3.0, 7), (6.0, 64), (0.2, 1)] {
            let poses: Vec<Pose> = (0..count).map(|_| exp(&mean, &Tangent::from_fn(|_, _| draw(spread)))).collect();
            let frames = Frames::new(poses.iter());
            let mut weights = vec![0.0; frames.padded()];
            let share = |frame: usize| if frame.is_multiple_of(3) || frame / 4 == 2 { 0.0 } else { draw(0.5) + 0.5 };
            weights[..count].iter_mut().zip((0..count).map(share)).for_each(|(weight, share)| *weight = share);
            let mut residuals = Residuals::new(frames.padded());
            residuals.measure(&frames, &mean);
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
            assert!((residuals.weighted(&weights) - sum).norm() <= 1e-13 * (1.0 + spread));
            assert!((residuals.scatter(&weights) - scatter).norm() <= 1e-12 * (1.0 + scatter.norm()));
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
        let mut residuals = Residuals::new(frames.padded());
        residuals.measure(&frames, &Pose::identity());
        for (frame, pose) in poses.iter().enumerate() {
            let found = Vector3::from_fn(|axis, _| residuals.axes[3 + axis][frame]);
            assert_eq!(found, rotation_log(&pose.rotation));
        }
    }
}
