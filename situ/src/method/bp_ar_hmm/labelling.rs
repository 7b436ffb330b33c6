//! The labels of all recordings at once. Several chains run, and the state of theirs that is most probable given its
//! own hyperparameters is kept.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::observation::{SIZE, observe};
use super::parameters::BpArHmmParameters;
use super::recording::Frame;
use super::sampler::{Chain, ChainState};
use crate::error::SituError;
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
