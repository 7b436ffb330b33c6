//! How different two models are, in nats per frame (decision D7).
//!
//! There is no closed form for hidden Markov models, and the *rate* of an absorbing chain depends only on its last
//! state. So the divergence here compares whole sequences with their ends, and divides by the expected length.
//! Everything is generic over the emission.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::hmm::{Emission, EmissionDensity, Hmm, Scoring};

/// Greatest length of a sampled sequence, frames. No policy is expected to be a hundredth as long.
const MAX_SAMPLED_FRAMES: usize = 10_000;

/// Samples that are drawn in each direction before the estimate is tested, and before each further test. With fewer
/// samples the standard error itself is unreliable.
const BATCH: usize = 50;
/// If an estimate is this many standard errors away from a cut, its side of the cut is certain. It is tested twenty
/// times at most.
pub const CERTAIN: f64 = 5.0;

/// A Monte Carlo estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// The estimate, nats per frame.
    pub mean: f64,
    /// Its standard error, nats per frame. Infinite with fewer than two samples.
    pub standard_error: f64,
}

/// A model with the sequences that it was fitted to.
#[derive(Clone, Copy, Debug)]
pub struct FittedModel<'a, E: EmissionDensity> {
    hmm: &'a Hmm<E>,
    sequences: &'a [Vec<E::Frame>],
    log_likelihood: f64,
}

impl<'a, E: EmissionDensity> FittedModel<'a, E> {
    /// The model and its sequences, of at least one frame each. `log_likelihood` is theirs under the model, as
    /// [`Hmm::fit`] found it, so it is not computed again.
    pub fn new(hmm: &'a Hmm<E>, sequences: &'a [Vec<E::Frame>], log_likelihood: f64) -> Self {
        Self { hmm, sequences, log_likelihood }
    }

    /// (log own(X) − log other(X)) / |X|.
    fn excess(&self, other: &Self) -> f64 {
        let frames: usize = self.sequences.iter().map(Vec::len).sum();
        if frames == 0 {
            return 0.0;
        }
        (self.log_likelihood - other.hmm.total_log_likelihood(self.sequences)) / frames as f64
    }

    /// See [`cross_likelihood`].
    pub fn divergence(&self, other: &Self) -> f64 {
        0.5 * (self.excess(other) + other.excess(self))
    }
}

/// Models whose sequences are asked about at once: their tables stay in the fast memory of a core.
const ASKED: usize = 32;

/// The [`cross_likelihood`] of all pairs, bit for bit: (0,1), (0,2), …, (1,2), …
///
/// Each model is asked about the sequences of many others at once, which costs a sixth of one pair after the other.
pub(super) fn among(models: &[FittedModel<'_, Emission>]) -> Vec<f64> {
    let n = models.len();
    // How far a model is behind the model of a set on that set, at `model * n + set`.
    let mut excess = vec![0.0; n * n];
    let of_one_size = models.windows(2).all(|pair| pair[0].hmm.states() == pair[1].hmm.states());
    for (chunk, asked) in models.chunks(ASKED).enumerate().filter(|_| of_one_size) {
        let sets: Vec<_> = asked.iter().map(|asked| asked.sequences).collect();
        let frames: Vec<usize> = sets.iter().map(|set| set.iter().map(Vec::len).sum()).collect();
        let mut scoring = Scoring::new(&sets, models[0].hmm.states());
        for (model, row) in models.iter().zip(excess.chunks_exact_mut(n)) {
            let found = asked.iter().zip(&frames).zip(scoring.log_likelihoods(model.hmm));
            for (excess, ((asked, frames), other)) in row[chunk * ASKED..].iter_mut().zip(found) {
                *excess = if *frames == 0 { 0.0 } else { (asked.log_likelihood - other) / *frames as f64 };
            }
        }
    }
    let pair = |left: usize, right: usize| match of_one_size {
        true => 0.5 * (excess[right * n + left] + excess[left * n + right]),
        false => models[left].divergence(&models[right]),
    };
    (0..n)
        .flat_map(|left| (left + 1..n).map(move |right| (left, right)))
        .map(|(left, right)| pair(left, right))
        .collect()
}

/// The likelihood of each other's training sequences, symmetrised, nats per frame:
/// `½ [(log p(X_p) − log q(X_p)) / |X_p| + (log q(X_q) − log p(X_q)) / |X_q|]`, where `|X|` is the number of frames.
///
/// Nothing is sampled: the same input gives the same bits. The value is negative if the models explain each other's
/// data better than their own. Sequences without frames are ignored. A side without any frame counts 0.
pub fn cross_likelihood<'a, E: EmissionDensity>(
    p: &'a Hmm<E>,
    xp: &'a [Vec<E::Frame>],
    q: &'a Hmm<E>,
    xq: &'a [Vec<E::Frame>],
) -> f64 {
    let explained = |hmm: &'a Hmm<E>, sequences: &'a [Vec<E::Frame>]| {
        FittedModel::new(hmm, sequences, hmm.total_log_likelihood(sequences))
    };
    explained(p, xp).divergence(&explained(q, xq))
}

/// KL(p ‖ q) of whole sequences by sampling from p, divided by the expected length of p: nats per frame.
///
/// The same seed gives the same bits. It is not symmetric: average it with the other direction.
pub fn monte_carlo<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, samples: usize, seed: u64) -> MonteCarlo {
    let mut sampling = Sampling::new(p, q, seed);
    sampling.draw(samples);
    sampling.estimate()
}

/// The mean of [`monte_carlo`] in both directions, and the number of samples that were drawn in each direction.
///
/// At most `samples` are drawn in each direction. The sampling stops as soon as the side of `cut` is certain, by
/// [`CERTAIN`] standard errors.
pub fn monte_carlo_against<E: EmissionDensity>(
    p: &Hmm<E>,
    q: &Hmm<E>,
    samples: usize,
    seed: u64,
    cut: f64,
) -> (MonteCarlo, usize) {
    let (mut there, mut back) = (Sampling::new(p, q, seed), Sampling::new(q, p, seed));
    loop {
        let batch = BATCH.min(samples - there.drawn);
        there.draw(batch);
        back.draw(batch);
        let (one, other) = (there.estimate(), back.estimate());
        let estimate = MonteCarlo {
            mean: 0.5 * (one.mean + other.mean),
            standard_error: 0.5 * libm::hypot(one.standard_error, other.standard_error),
        };
        // An infinite mean is above any cut, and no further sample changes that.
        let certain = estimate.mean == f64::INFINITY
            || (estimate.mean - cut).abs() > CERTAIN * estimate.standard_error && there.drawn >= BATCH;
        if certain || there.drawn == samples {
            return (estimate, there.drawn);
        }
    }
}

/// A running estimate of KL(p ‖ q).
struct Sampling<'a, E> {
    p: &'a Hmm<E>,
    q: &'a Hmm<E>,
    rng: ChaCha8Rng,
    drawn: usize,
    mean: f64,
    /// The sum of the squared errors.
    squares: f64,
}

impl<'a, E: EmissionDensity> Sampling<'a, E> {
    fn new(p: &'a Hmm<E>, q: &'a Hmm<E>, seed: u64) -> Self {
        Self { p, q, rng: ChaCha8Rng::seed_from_u64(seed), drawn: 0, mean: 0.0, squares: 0.0 }
    }

    fn draw(&mut self, samples: usize) {
        for _ in 0..samples {
            let sequence = self.p.sample(&mut self.rng, MAX_SAMPLED_FRAMES);
            let ratio = self.p.log_likelihood(&sequence) - self.q.log_likelihood(&sequence);
            self.drawn += 1;
            // Welford's update: it has no cancellation.
            let error = ratio - self.mean;
            self.mean += error / self.drawn as f64;
            self.squares += error * (ratio - self.mean);
        }
    }

    fn estimate(&self) -> MonteCarlo {
        let length = self.p.expected_length();
        let samples = self.drawn as f64;
        let error = if self.drawn < 2 { f64::INFINITY } else { libm::sqrt(self.squares / (samples - 1.0) / samples) };
        // An impossible sequence makes the running mean infinite; the next sample turns that into NaN.
        let mean = if self.mean.is_finite() { self.mean / length } else { f64::INFINITY };
        MonteCarlo { mean, standard_error: if mean.is_finite() { error / length } else { f64::INFINITY } }
    }
}

/// An upper bound on KL(p ‖ q) of whole sequences by the chain rule, divided by the expected length of p: nats per
/// frame.
///
/// If both have as many states, state i of one corresponds to state i of the other: Σ π log(π/π′) + Σ n_i [KL(b_i ‖
/// b′_i) + Σ_j a_ij log(a_ij/a′_ij)], where j also runs over the end and n_i are the expected visits.
///
/// If the numbers of states differ, there is no such bound. Then each state of p is assigned a state of q, in order and
/// never back, so that Σ n_i [KL(b_i ‖ b′) + KL of staying or leaving] is least, by dynamic programming. A state of q
/// without a state of p costs nothing here: the other direction counts it.
///
/// Infinite if q cannot do what p can. It is not symmetric: average it with the other direction.
pub fn transient_bound<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>) -> f64 {
    let visits = p.expected_visits();
    let length: f64 = visits.iter().sum();
    if !length.is_finite() || length <= 0.0 {
        return f64::INFINITY;
    }
    let total = if p.states() == q.states() { same_states(p, q, &visits) } else { aligned(p, q, &visits) };
    total / length
}

fn same_states<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, visits: &[f64]) -> f64 {
    let k = p.states();
    let mut total: f64 = p.initial.iter().zip(&q.initial).map(|(own, other)| relative_entropy(*own, *other)).sum();
    for (state, visit) in visits.iter().enumerate() {
        // A state that is never visited adds nothing, even if its counterpart differs without bound.
        if *visit > 0.0 {
            let row = state * k..(state + 1) * k;
            let ways = p.transition[row.clone()].iter().zip(&q.transition[row]);
            let chain: f64 = ways.map(|(own, other)| relative_entropy(*own, *other)).sum::<f64>()
                + relative_entropy(p.end[state], q.end[state]);
            total += visit * (p.emissions[state].kl(&q.emissions[state]) + chain);
        }
    }
    total
}

fn aligned<E: EmissionDensity>(p: &Hmm<E>, q: &Hmm<E>, visits: &[f64]) -> f64 {
    // best[j]: the least cost of the states of p so far, if the last of them is assigned to state j of q.
    let mut best = vec![0.0; q.states()];
    for (state, visit) in visits.iter().enumerate() {
        let mut least = f64::INFINITY;
        for (other, cost) in best.iter_mut().enumerate() {
            least = least.min(*cost);
            let (own, others) = (stay(p, state), stay(q, other));
            let dwell = relative_entropy(own, others) + relative_entropy(1.0 - own, 1.0 - others);
            let step = if *visit > 0.0 { visit * (p.emissions[state].kl(&q.emissions[other]) + dwell) } else { 0.0 };
            *cost = least + step;
        }
    }
    best.into_iter().fold(f64::INFINITY, f64::min)
}

fn stay<E>(hmm: &Hmm<E>, state: usize) -> f64 {
    hmm.transition[state * hmm.states() + state]
}

/// p log(p/q), and 0 if p is 0.
fn relative_entropy(p: f64, q: f64) -> f64 {
    if p > 0.0 { p * libm::log(p / q) } else { 0.0 }
}
