//! The labels of all recordings at once. Several chains run, and the state of theirs that is most probable given its
//! own hyperparameters is kept.

use nalgebra::{SMatrix, SVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::parameters::BpArHmmParameters;
use super::recording::Frame;
use super::sampler::{Chain, ChainState, DynamicsPrior, GammaPrior, LaggedSequence, Prior};
use crate::demonstration::Pose;
use crate::error::SituError;
use crate::keyframe::pose::{karcher_mean, log};
use crate::random::stream;

/// What the sampler found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(super) struct Labelling {
    /// log p(X, z, F | α, κ, γ, c) of the state. The state with the greatest is kept.
    pub(super) log_joint: f64,
    /// The state.
    pub(super) state: ChainState<SIZE>,
}

impl Labelling {
    /// The labels of the frames of a recording. The first frame follows no other, so it has the label of the second.
    pub(super) fn labels(&self, recording: usize) -> Vec<usize> {
        let states = &self.state.rows[recording].states;
        states.first().into_iter().chain(states).copied().collect()
    }
}

/// Labels the recordings, of which there is at least one.
///
/// # Errors
/// [`SituError::Policy`] if the numbers are too extreme for a posterior.
pub(super) fn label(
    recordings: &[Vec<Frame>],
    parameters: &BpArHmmParameters,
    seed: u64,
) -> Result<Labelling, SituError> {
    let (sequences, prior) = observe(recordings);
    let mut best: Option<Labelling> = None;
    for number in 0..parameters.chains {
        let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, &format!("bp_ar_hmm chain {number}")));
        let mut run = || -> Option<()> {
            let unique = parameters.unique_features;
            let mut chain = Chain::new(prior.clone(), parameters.moves, sequences.clone(), unique, &mut rng)?;
            for _ in 0..parameters.sweeps {
                chain.sweep(&mut rng)?;
                let log_joint = chain.log_joint()?;
                if log_joint.is_finite() && best.as_ref().is_none_or(|best| log_joint > best.log_joint) {
                    best = Some(Labelling { log_joint, state: chain.state().clone() });
                }
            }
            Some(())
        };
        // If a chain breaks off, what it found before still counts.
        let _ = run();
    }
    best.ok_or_else(|| SituError::Policy {
        reference: String::new(),
        problem: "the frames are too far apart for a posterior of their dynamics".to_owned(),
    })
}

/// The numbers of an observation.
const SIZE: usize = 7;
/// The least deviation of a first difference, per frame: 1 mm (3), 0.01 rad (3) and a 100th of the stroke. Otherwise a
/// number that hardly ever moves would count by its rounding errors.
const LEAST_DEVIATION: [f64; SIZE] = [1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2, 1e-2];
/// S₀ is this share of the covariance of first differences (Fox et al. 2014).
const SCALE_SHARE: f64 = 0.5;
/// This is added to the diagonal of S₀, in scaled units. Without it, differences that depend on each other would make
/// S₀ singular.
const SCALE_RIDGE: f64 = 0.01;
/// K⁻¹ = 0.5 I (Fox et al. 2014).
const PRECISION: f64 = 0.5;
/// Gamma(0.01, 0.01) for every hyperparameter (Fox et al. 2014).
const VAGUE: GammaPrior = GammaPrior { shape: 0.01, rate: 0.01 };

/// The frames as the sampler takes them, each with the frame before, and the priors for their scale.
fn observe(recordings: &[Vec<Frame>]) -> (Vec<LaggedSequence<SIZE>>, Prior<SIZE>) {
    let relative: Vec<Pose> = recordings.iter().flatten().map(|frame| frame.frozen.inv_mul(&frame.pose)).collect();
    let mean = karcher_mean(&relative, &vec![1.0; relative.len()]);
    let base = Pose::from_parts(nalgebra::Translation3::identity(), mean.rotation);
    let seen = |frame: &Frame, from: &Pose| {
        let tangent = log(&base, &from.inv_mul(&frame.pose));
        SVector::<f64, SIZE>::from_fn(|axis, _| if axis < 6 { tangent[axis] } else { frame.opening })
    };
    let mut sequences: Vec<LaggedSequence<SIZE>> = Vec::with_capacity(recordings.len());
    for frames in recordings {
        let current: Vec<_> = frames[1..].iter().map(|frame| seen(frame, &frame.frozen)).collect();
        let pairs = frames.windows(2).zip(&current);
        let lagged = pairs.map(|(pair, current)| near(seen(&pair[0], &pair[1].frozen), current)).collect();
        sequences.push(LaggedSequence { current, lagged });
    }
    let deviations = covariance(&sequences).diagonal();
    let scales = SVector::<f64, SIZE>::from_fn(|axis, _| libm::sqrt(deviations[axis]).max(LEAST_DEVIATION[axis]));
    for value in sequences.iter_mut().flat_map(|sequence| sequence.current.iter_mut().chain(&mut sequence.lagged)) {
        value.component_div_assign(&scales);
    }
    let dynamics = DynamicsPrior {
        precision: SMatrix::identity() * PRECISION,
        scale: covariance(&sequences) * SCALE_SHARE + SMatrix::identity() * SCALE_RIDGE,
        // max(1, D + 2), as published.
        freedom: (SIZE + 2) as f64,
    };
    (sequences, Prior { dynamics, alpha: VAGUE, kappa: VAGUE, gamma: VAGUE, c: VAGUE })
}

/// The same rotation, with its vector on the side of the other's vector.
fn near(mut value: SVector<f64, SIZE>, other: &SVector<f64, SIZE>) -> SVector<f64, SIZE> {
    let (own, other) = (value.fixed_rows::<3>(3).into_owned(), other.fixed_rows::<3>(3).into_owned());
    let angle = libm::sqrt(own.dot(&own));
    if angle > 0.0 {
        let around = own * (1.0 - 2.0 * core::f64::consts::PI / angle);
        if (around - other).norm_squared() < (own - other).norm_squared() {
            value.fixed_rows_mut::<3>(3).copy_from(&around);
        }
    }
    value
}

/// The covariance of first differences, over all sequences.
fn covariance(sequences: &[LaggedSequence<SIZE>]) -> SMatrix<f64, SIZE, SIZE> {
    let pairs = sequences.iter().flat_map(|sequence| sequence.current.iter().zip(&sequence.lagged));
    let (mut count, mut sum, mut squares) = (0.0, SVector::<f64, SIZE>::zeros(), SMatrix::zeros());
    for (current, lagged) in pairs {
        let step = current - lagged;
        count += 1.0;
        sum += step;
        squares += step * step.transpose();
    }
    let mean = sum / count;
    squares / count - mean * mean.transpose()
}
