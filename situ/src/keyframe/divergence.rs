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

/// The likelihood of each other's training sequences, symmetrised, nats a frame:
/// ½ [(log p(X_p) − log q(X_p)) / |X_p| + (log q(X_q) − log p(X_q)) / |X_q|], |X| the number of frames.
///
/// No sampling: the same input gives the same bits. It can be negative, where a model explains the other's data better than
/// the other does. Sequences without frames are ignored; a side without any frame counts 0.
pub fn cross_likelihood<E: EmissionDensity>(p: &Hmm<E>, xp: &[Vec<E::Frame>], q: &Hmm<E>, xq: &[Vec<E::Frame>]) -> f64 {
    0.5 * (excess(p, q, xp) + excess(q, p, xq))
}

/// (log own(X) − log other(X)) / |X|.
fn excess<E: EmissionDensity>(own: &Hmm<E>, other: &Hmm<E>, sequences: &[Vec<E::Frame>]) -> f64 {
    let used: Vec<&[E::Frame]> = sequences.iter().map(Vec::as_slice).filter(|sequence| !sequence.is_empty()).collect();
    let frames: usize = used.iter().map(|sequence| sequence.len()).sum();
    if frames == 0 {
        return 0.0;
    }
    (own.total_log_likelihood(&used) - other.total_log_likelihood(&used)) / frames as f64
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
