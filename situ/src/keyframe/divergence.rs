//! How different two models are, nats a frame (decision D7).
//!
//! There is no closed form for hidden Markov models, and the *rate* of an absorbing chain sees only its last state. So the
//! divergence here is of whole sequences with their ends, over the expected length. All are generic over the emission.

mod transient;

pub use transient::transient_bound;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::hmm::{EmissionDensity, Hmm};

/// A sampled sequence is cut off here: no policy is expected to be a hundredth as long.
const MAX_SAMPLED_FRAMES: usize = 10_000;

/// A Monte Carlo estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// The estimate, nats a frame.
    pub mean: f64,
    /// Its standard error, nats a frame; infinite with fewer than two samples.
    pub standard_error: f64,
}

/// A model with sequences that it was fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Explained<'a, E: EmissionDensity> {
    hmm: &'a Hmm<E>,
    sequences: &'a [Vec<E::Frame>],
    log_likelihood: f64,
}

impl<'a, E: EmissionDensity> Explained<'a, E> {
    /// The model and its sequences, of at least one frame each; `log_likelihood` is theirs under it, as [`Hmm::fit`] found it: nothing is to be
    /// computed again.
    pub fn new(hmm: &'a Hmm<E>, sequences: &'a [Vec<E::Frame>], log_likelihood: f64) -> Self {
        Self { hmm, sequences, log_likelihood }
    }

    /// The model.
    pub fn hmm(&self) -> &'a Hmm<E> {
        self.hmm
    }

    /// (log own(X) − log other(X)) / |X|.
    fn excess(&self, other: &Self) -> f64 {
        let frames: usize = self.sequences.iter().map(Vec::len).sum();
        if frames == 0 {
            return 0.0;
        }
        (self.log_likelihood - other.hmm.total_log_likelihood(self.sequences)) / frames as f64
    }

    /// [`cross_likelihood`].
    pub fn divergence(&self, other: &Self) -> f64 {
        0.5 * (self.excess(other) + other.excess(self))
    }
}

/// The likelihood of each other's training sequences, symmetrised, nats a frame:
/// ½ [(log p(X_p) − log q(X_p)) / |X_p| + (log q(X_q) − log p(X_q)) / |X_q|], |X| the number of frames.
///
/// No sampling: the same input gives the same bits. It can be negative, where a model explains the other's data better than
/// the other does. Sequences without frames are ignored; a side without any frame counts 0.
pub fn cross_likelihood<'a, E: EmissionDensity>(
    p: &'a Hmm<E>,
    xp: &'a [Vec<E::Frame>],
    q: &'a Hmm<E>,
    xq: &'a [Vec<E::Frame>],
) -> f64 {
    let explained = |hmm: &'a Hmm<E>, sequences: &'a [Vec<E::Frame>]| {
        Explained::new(hmm, sequences, hmm.total_log_likelihood(sequences))
    };
    explained(p, xp).divergence(&explained(q, xq))
}

/// KL(p ‖ q) of whole sequences by sampling from p, over the expected length of p: nats a frame.
///
/// The same seed gives the same bits. Not symmetric: average it with the other direction.
pub fn monte_carlo<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, samples: usize, seed: u64) -> MonteCarlo {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut mean, mut squares) = (0.0, 0.0);
    for drawn in 1..=samples {
        let sequence = p.sample(&mut rng, MAX_SAMPLED_FRAMES);
        let ratio = p.log_likelihood(&sequence) - q.log_likelihood(&sequence);
        // Welford's update: no cancellation.
        let error = ratio - mean;
        mean += error / drawn as f64;
        squares += error * (ratio - mean);
    }
    let length = p.expected_length();
    let error = if samples < 2 { f64::INFINITY } else { libm::sqrt(squares / (samples - 1) as f64 / samples as f64) };
    // An impossible sequence makes the running mean infinite, and the next one makes it no number.
    let mean = if mean.is_finite() { mean / length } else { f64::INFINITY };
    MonteCarlo { mean, standard_error: if mean.is_finite() { error / length } else { f64::INFINITY } }
}
