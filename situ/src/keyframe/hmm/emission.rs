//! The emission of a hidden state: a Gaussian over poses and a gripper command.

use nalgebra::{Matrix3, Matrix6, Vector3};
use rand::Rng;
use serde::{Deserialize, Serialize};

use super::density::EmissionDensity;
use super::frames::{Frames, Gaussian};
use super::gripper::GripperEmission;
use super::parameters::{HmmError, HmmParameters};
use crate::demonstration::{Gripper, Pose};
use crate::keyframe::pose::{Tangent, exp, is_unit, log, rotation_exp};
use crate::random::standard_normal;

/// The number of dimensions of a pose's tangent space.
const DIMENSIONS: f64 = 6.0;
/// log 2π.
const LOG_TWO_PI: f64 = 1.837_877_066_409_345_5;

/// A positive definite matrix.
pub(super) struct Covariance {
    matrix: Matrix6<f64>,
    /// Its lower Cholesky factor.
    factor: Matrix6<f64>,
    pub(super) log_determinant: f64,
}

impl Covariance {
    /// # Errors
    /// [`HmmError::NotPositiveDefinite`] if it is not.
    pub(super) fn new(matrix: Matrix6<f64>) -> Result<Self, HmmError> {
        let mut covariance = Self { matrix, factor: Matrix6::zeros(), log_determinant: f64::NAN };
        covariance.factorise()?;
        Ok(covariance)
    }

    /// Turns this into (scatter + prior)/total.
    ///
    /// # Errors
    /// As [`Covariance::new`].
    pub(super) fn set(&mut self, scatter: &Matrix6<f64>, prior: &Matrix6<f64>, total: f64) -> Result<(), HmmError> {
        let entries = self.matrix.as_mut_slice().iter_mut();
        for ((entry, scatter), prior) in entries.zip(scatter.as_slice()).zip(prior.as_slice()) {
            *entry = (scatter + prior) / total;
        }
        self.factorise()
    }

    fn factorise(&mut self) -> Result<(), HmmError> {
        let (matrix, factor) = (&self.matrix, &mut self.factor);
        let mut pivots = [0.0; 6];
        for column in 0..6 {
            for row in column..6 {
                let mut value = matrix[(row, column)];
                for k in 0..column {
                    value -= factor[(row, k)] * factor[(column, k)];
                }
                if row > column {
                    factor[(row, column)] = value / factor[(column, column)];
                } else if value.is_finite() && value > 0.0 {
                    factor[(row, column)] = libm::sqrt(value);
                    pivots[column] = value;
                } else {
                    return Err(HmmError::NotPositiveDefinite);
                }
            }
        }
        // One logarithm of the product of the pivots, unless a float cannot hold the product.
        let times = |product: f64, pivot: &f64| Some(product * pivot).filter(|next| next.is_normal());
        let product = pivots.iter().try_fold(1.0, times);
        self.log_determinant = product.map_or_else(|| pivots.iter().map(|pivot| libm::log(*pivot)).sum(), libm::log);
        Ok(())
    }

    /// Computes the inverse of the factor: W with Wᵀ W = Σ⁻¹, lower triangular.
    fn invert_factor(&self, inverse: &mut Matrix6<f64>) {
        let factor = &self.factor;
        for row in 0..6 {
            let pivot = 1.0 / factor[(row, row)];
            for column in 0..row {
                let mut value = 0.0;
                for k in column..row {
                    value -= factor[(row, k)] * inverse[(k, column)];
                }
                inverse[(row, column)] = value * pivot;
            }
            inverse[(row, row)] = pivot;
        }
    }
}

/// What a hidden state emits at one step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Observation {
    /// The pose, in the frame of the reference object.
    pub pose: Pose,
    /// The gripper command. `None` if it is not part of the model, as in signatures.
    pub gripper: Option<Gripper>,
}

/// A Gaussian in the tangent space at its mean pose (decision D13), times the distribution of the gripper command.
///
/// The density is with respect to metres and radians of that tangent space. To change a mean or a covariance, make a
/// new emission by [`Emission::new`], because the factor of the covariance is stored too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WrittenEmission")]
pub struct Emission {
    /// The mean pose.
    pub mean: Pose,
    /// The covariance of the likelihood, the prior included (decision D12): metres and radians, position first, shape
    /// (6, 6).
    pub covariance: Matrix6<f64>,
    /// The scatter of the data about the mean, without a prior (decision D15): shape (6, 6), often singular.
    pub scatter: Matrix6<f64>,
    /// The gripper command. `None` if the data had none.
    pub gripper: Option<GripperEmission>,
    /// W with Wᵀ W = Σ⁻¹, lower triangular: the inverse of the Cholesky factor.
    #[serde(skip)]
    whitening: Matrix6<f64>,
    /// −½ (6 log 2π + log |Σ|).
    #[serde(skip)]
    log_normaliser: f64,
}

/// An emission as it is written: what follows from the covariance is left out.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEmission {
    mean: Pose,
    covariance: Matrix6<f64>,
    scatter: Matrix6<f64>,
    gripper: Option<GripperEmission>,
}

impl TryFrom<WrittenEmission> for Emission {
    type Error = HmmError;

    fn try_from(written: WrittenEmission) -> Result<Self, HmmError> {
        let WrittenEmission { mean, covariance, scatter, gripper } = written;
        let numbers = scatter.iter().chain(&mean.translation.vector);
        if !numbers.copied().all(f64::is_finite) || !is_unit(&mean) || !gripper.is_none_or(|each| each.is_sound()) {
            return Err(HmmError::Written);
        }
        Self::new(mean, covariance, scatter, gripper)
    }
}

impl Emission {
    /// An emission of this mean and covariance.
    ///
    /// # Errors
    /// [`HmmError::NotPositiveDefinite`] if `covariance` is not.
    pub fn new(
        mean: Pose,
        covariance: Matrix6<f64>,
        scatter: Matrix6<f64>,
        gripper: Option<GripperEmission>,
    ) -> Result<Self, HmmError> {
        let zero = Matrix6::zeros();
        let mut emission =
            Self { mean, covariance: zero, scatter: zero, gripper, whitening: zero, log_normaliser: f64::NAN };
        emission.set(mean, &Covariance::new(covariance)?, (&scatter, 1.0), gripper);
        Ok(emission)
    }

    /// Turns this into the emission of this mean and covariance. The scatter is given with what it is to be divided by.
    pub(super) fn set(
        &mut self,
        mean: Pose,
        covariance: &Covariance,
        (scatter, total): (&Matrix6<f64>, f64),
        gripper: Option<GripperEmission>,
    ) {
        (self.mean, self.gripper) = (mean, gripper);
        self.covariance = covariance.matrix;
        let entries = self.scatter.as_mut_slice().iter_mut().zip(scatter.as_slice());
        entries.for_each(|(entry, scatter)| *entry = scatter / total);
        covariance.invert_factor(&mut self.whitening);
        self.log_normaliser = -0.5 * (DIMENSIONS * LOG_TWO_PI + covariance.log_determinant);
    }

    /// The most probable kind of command, with its mean value. `None` if the data had no command.
    pub fn gripper_command(&self) -> Option<Gripper> {
        self.gripper.map(|gripper| gripper.most_probable())
    }

    /// The same emission without its gripper command.
    #[must_use]
    pub fn pose_only(&self) -> Self {
        Self { gripper: None, ..self.clone() }
    }

    /// The squared Mahalanobis length of a tangent vector at the mean.
    pub fn mahalanobis_squared(&self, tangent: &Tangent) -> f64 {
        let mut sum = 0.0;
        for row in 0..6 {
            let mut whitened = 0.0;
            for column in 0..=row {
                whitened += self.whitening[(row, column)] * tangent[column];
            }
            sum += whitened * whitened;
        }
        sum
    }

    /// The log density of the pose alone.
    pub fn pose_log_density(&self, pose: &Pose) -> f64 {
        self.log_normaliser - 0.5 * self.mahalanobis_squared(&log(&self.mean, pose))
    }

    /// The Gaussian over the pose, as the kernels take it.
    pub(super) fn gaussian(&self) -> Gaussian {
        Gaussian::new(&self.whitening, self.log_normaliser)
    }

    /// Adds the log densities of the commands. A frame without a command adds 0, and so does an emission without
    /// commands.
    pub(super) fn add_log_densities_of_commands(
        &self,
        commands: impl Iterator<Item = Option<Gripper>>,
        log_densities: &mut [f64],
    ) {
        let Some(scores) = self.gripper.as_ref().map(GripperEmission::scores) else { return };
        for (log_density, command) in log_densities.iter_mut().zip(commands) {
            *log_density += command.map_or(0.0, |command| scores.log_density(command));
        }
    }

    /// What the prior of decision D12 adds to the objective of the fit: −½ ν₀ (log |Σ| + tr Σ⁻¹ S₀).
    pub(super) fn log_prior(&self, parameters: &HmmParameters) -> f64 {
        let mut trace = 0.0;
        for column in 0..6 {
            let floor = parameters.floor(column);
            for row in column..6 {
                trace += self.whitening[(row, column)] * self.whitening[(row, column)] * floor * floor;
            }
        }
        let gripper = self.gripper.map_or(0.0, |gripper| gripper.log_prior(parameters));
        gripper - 0.5 * parameters.prior_weight * (self.log_determinant() + trace)
    }

    /// log |Σ|.
    pub(super) fn log_determinant(&self) -> f64 {
        -2.0 * self.log_normaliser - DIMENSIONS * LOG_TWO_PI
    }
}

impl EmissionDensity for Emission {
    type Frame = Observation;

    /// If the frame or the emission has no command, only the pose counts.
    fn log_density(&self, frame: &Observation) -> f64 {
        let gripper = match (self.gripper, frame.gripper) {
            (Some(emission), Some(command)) => emission.log_density(command),
            _ => 0.0,
        };
        self.pose_log_density(&frame.pose) + gripper
    }

    fn log_densities(emissions: &[Self], frames: &[&Observation], columns: &mut [f64]) {
        let poses = Frames::new(frames.iter().map(|frame| &frame.pose));
        for (emission, column) in emissions.iter().zip(columns.chunks_exact_mut(poses.padded().max(1))) {
            poses.log_densities(&emission.mean, emission.gaussian(), column);
            emission.add_log_densities_of_commands(frames.iter().map(|frame| frame.gripper), column);
        }
    }

    /// The other's mean is expressed in the tangent space at this mean, and its covariance is transported there along
    /// the geodesic (Zeestraten et al. 2017). The commands count if both emissions have one.
    fn kl(&self, other: &Self) -> f64 {
        let apart = log(&self.mean, &other.mean);
        // In body coordinates, transport along Exp(ω) turns a tangent vector by −ω/2, and transport back by P = +ω/2.
        // The other's covariance is P Σ Pᵀ here, so its whitening is W Pᵀ.
        let back = rotation(&(-0.5 * Vector3::new(apart[3], apart[4], apart[5])));
        let mut transport = Matrix6::identity();
        transport.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
        let whitening = other.whitening * transport;
        let spread = whitening * self.covariance * whitening.transpose();
        let distance = whitening * apart;
        let mut sum = -DIMENSIONS;
        for axis in 0..6 {
            sum += spread[(axis, axis)] + distance[axis] * distance[axis];
        }
        let poses = 0.5 * sum + self.log_normaliser - other.log_normaliser;
        match (&self.gripper, &other.gripper) {
            (Some(own), Some(others)) => poses + own.kl(others),
            _ => poses,
        }
    }

    fn sample(&self, rng: &mut impl Rng) -> Observation {
        // x = L z is the solution of W x = z.
        let mut tangent = Tangent::zeros();
        for row in 0..6 {
            let mut value = standard_normal(rng);
            for column in 0..row {
                value -= self.whitening[(row, column)] * tangent[column];
            }
            tangent[row] = value / self.whitening[(row, row)];
        }
        Observation { pose: exp(&self.mean, &tangent), gripper: self.gripper.map(|gripper| gripper.sample(rng)) }
    }
}

fn rotation(vector: &Vector3<f64>) -> Matrix3<f64> {
    rotation_exp(vector).to_rotation_matrix().into_inner()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::keyframe::hmm::residuals::Residuals;
    use crate::vector::LANES;

    /// Blocks of frames give what single frames give, near the mean and as far as a rotation can be.
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
            residuals.log_densities(emission.gaussian(), &mut found);
            frames.log_densities(&mean, emission.gaussian(), &mut of_frames);
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
}
