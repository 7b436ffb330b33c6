//! Likelihood, posteriors and best path.
//!
//! Two skills can be hundreds of standard deviations apart, and a recursion that scales each frame by one number would lose
//! the paths that matter. So a sequence of a left-to-right model is first gone through in plain numbers, each frame scaled by
//! its greatest density. Scaled so, what underflows is below e^−708 of the product of the greatest densities; where the
//! likelihood is far above that, nothing of it was lost. Where it is not, or the model is of another topology, the sequence
//! is gone through in numbers that have an exponent of their own.

mod general;
mod left_to_right;
mod wide;

use super::{EmissionDensity, Hmm};

use general::GeneralChain;
use left_to_right::LeftToRightChain;

/// Expected counts of one sequence of T frames under a model of K states.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectations {
    /// Log probability of the sequence, its end included.
    pub log_likelihood: f64,
    /// Probability of state k at frame t at `t * K + k`, shape (T, K). The first row counts starts, the last one ends.
    pub occupancy: Vec<f64>,
    /// Expected number of transitions from i to j at `i * K + j`, shape (K, K).
    pub transitions: Vec<f64>,
}

/// The chain of a model, and room for the recursions over sequences up to some length: nothing is allocated from one sequence
/// or re-estimation to the next.
pub(super) struct Recursion {
    left_to_right: LeftToRightChain,
    general: GeneralChain,
}

/// Which of the two holds the variables of the last sequence.
#[derive(Clone, Copy)]
enum Gone {
    LeftToRight,
    General,
}

impl Recursion {
    /// For sequences of at most so many frames.
    pub(super) fn new(frames: usize, states: usize) -> Self {
        Self { left_to_right: LeftToRightChain::new(frames, states), general: GeneralChain::new(frames, states) }
    }

    /// Takes over the chain of a model of as many states.
    pub(super) fn set<E>(&mut self, hmm: &Hmm<E>) {
        self.left_to_right.set(hmm);
        self.general.set(hmm);
    }

    /// The log likelihood of a sequence by the log densities of its frames, T × K.
    fn forward(&mut self, log_densities: &[f64]) -> (f64, Gone) {
        match self.left_to_right.forward(log_densities) {
            Some(log_likelihood) => (log_likelihood, Gone::LeftToRight),
            None => (self.general.forward(log_densities), Gone::General),
        }
    }

    /// Fills `occupancy` (T × K) and adds to `transitions` (K × K); returns the log likelihood. Where that is −∞ there is no
    /// posterior, and neither is touched.
    pub(super) fn expectations(
        &mut self,
        log_densities: &[f64],
        occupancy: &mut [f64],
        transitions: &mut [f64],
    ) -> f64 {
        let (log_likelihood, gone) = self.forward(log_densities);
        if log_likelihood > f64::NEG_INFINITY {
            match gone {
                Gone::LeftToRight => self.left_to_right.backward(occupancy, transitions),
                Gone::General => self.general.backward(occupancy, transitions),
            }
        }
        log_likelihood
    }
}

/// e to the x, and 0 where x is so low that `libm` would return 0 after more work.
fn exp(x: f64) -> f64 {
    /// The logarithm of the least number above 0 is −745.13.
    const UNDERFLOW: f64 = -746.0;
    if x < UNDERFLOW { 0.0 } else { libm::exp(x) }
}

/// log Σ exp of the terms; −∞ of none.
pub(crate) fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + libm::log(terms.map(|term| exp(term - greatest)).sum::<f64>())
}

impl<E: EmissionDensity> Hmm<E> {
    /// Log density of every frame in every state, shape (T, K), over what `densities` held.
    fn log_densities(&self, frames: &[E::Frame], densities: &mut Vec<f64>) {
        densities.clear();
        for frame in frames {
            densities.extend(self.emissions.iter().map(|emission| emission.log_density(frame)));
        }
    }

    /// Log probability of a sequence, its end included. −∞ for no frame: every sequence has one.
    pub fn log_likelihood(&self, frames: &[E::Frame]) -> f64 {
        if frames.is_empty() { f64::NEG_INFINITY } else { self.total_log_likelihood(&[frames]) }
    }

    /// [`Hmm::log_likelihood`] of several sequences, summed in their order; those without a frame do not count.
    pub fn total_log_likelihood<S: AsRef<[E::Frame]>>(&self, sequences: &[S]) -> f64 {
        let longest = sequences.iter().map(|sequence| sequence.as_ref().len()).max().unwrap_or_default();
        let mut recursion = Recursion::new(longest, self.states());
        recursion.set(self);
        let mut densities = Vec::with_capacity(longest * self.states());
        let mut total = 0.0;
        for sequence in sequences {
            if !sequence.as_ref().is_empty() {
                self.log_densities(sequence.as_ref(), &mut densities);
                total += recursion.forward(&densities).0;
            }
        }
        total
    }

    /// Posterior counts of a sequence (the E step). None where the sequence has probability 0 or no frame.
    pub fn expectations(&self, frames: &[E::Frame]) -> Option<Expectations> {
        if frames.is_empty() {
            return None;
        }
        let k = self.states();
        let mut densities = Vec::new();
        self.log_densities(frames, &mut densities);
        let mut recursion = Recursion::new(frames.len(), k);
        recursion.set(self);
        let (mut occupancy, mut transitions) = (vec![0.0; densities.len()], vec![0.0; k * k]);
        let log_likelihood = recursion.expectations(&densities, &mut occupancy, &mut transitions);
        (log_likelihood > f64::NEG_INFINITY).then_some(Expectations { log_likelihood, occupancy, transitions })
    }

    /// The most probable path, shape (T), and its log probability with the frames and the end (Viterbi). Of paths that tie,
    /// the one through the lowest states at its last differing frame. No frame: no path, −∞.
    pub fn viterbi(&self, frames: &[E::Frame]) -> (Vec<usize>, f64) {
        if frames.is_empty() {
            return (Vec::new(), f64::NEG_INFINITY);
        }
        let k = self.states();
        let logs = |probabilities: &[f64]| probabilities.iter().copied().map(libm::log).collect::<Vec<f64>>();
        let (initial, transition, end) = (logs(&self.initial), logs(&self.transition), logs(&self.end));
        let densities = |frame| self.emissions.iter().map(move |emission| emission.log_density(frame));
        let mut now: Vec<f64> =
            initial.iter().zip(densities(&frames[0])).map(|(start, density)| start + density).collect();
        let mut next = vec![0.0; k];
        let mut from = vec![0; frames.len() * k];
        for (frame, observation) in frames.iter().enumerate().skip(1) {
            for (state, density) in densities(observation).enumerate() {
                let (before, value) =
                    greatest((0..k).map(|before| (before, now[before] + transition[before * k + state])));
                from[frame * k + state] = before;
                next[state] = value + density;
            }
            core::mem::swap(&mut now, &mut next);
        }
        let (mut state, value) = greatest(now.iter().zip(&end).map(|(now, end)| now + end).enumerate());
        let mut path = vec![0; frames.len()];
        for frame in (0..frames.len()).rev() {
            path[frame] = state;
            state = from[frame * k + state];
        }
        (path, value)
    }
}

/// The first of the greatest; (0, −∞) of none.
fn greatest(terms: impl Iterator<Item = (usize, f64)>) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, value) in terms {
        if value > best.1 {
            best = (index, value);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Where plain numbers are enough, they find what numbers of any magnitude find; and they are not enough where states are far apart.
    #[test]
    fn both_ways_to_go_through_a_sequence_agree() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut plain, mut wide) = (0, 0);
        for case in 0..600 {
            let (k, frames) = (1 + case % 7, 1 + case / 7 % 23);
            let mut draw = || rng.random::<f64>();
            let mut transition = vec![0.0; k * k];
            let mut end = vec![0.0; k];
            for state in 0..k {
                let row = &mut transition[state * k + state..state * k + k.min(state + 3)];
                row.iter_mut().for_each(|way| *way = 1e-3 + draw());
                end[state] = 1e-3 + draw();
                let total = row.iter().sum::<f64>() + end[state];
                row.iter_mut().for_each(|way| *way /= total);
                end[state] /= total;
            }
            let hmm = Hmm { initial: vec![1.0 / k as f64; k], transition, end, emissions: vec![(); k] };
            let spread = [1.0, 30.0, 1000.0][case % 3];
            let densities: Vec<f64> = (0..frames * k).map(|_| -spread * draw()).collect();
            let mut recursion = Recursion::new(frames, k);
            recursion.set(&hmm);
            let expected = recursion.general.forward(&densities);
            let Some(found) = recursion.left_to_right.forward(&densities) else {
                wide += 1;
                continue;
            };
            plain += 1;
            assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{case}: {found} for {expected}");
            let posterior = || (vec![0.0; frames * k], vec![0.0; k * k]);
            let (mut one, mut other) = (posterior(), posterior());
            recursion.left_to_right.backward(&mut one.0, &mut one.1);
            recursion.general.backward(&mut other.0, &mut other.1);
            for (one, other) in one.0.iter().chain(&one.1).zip(other.0.iter().chain(&other.1)) {
                assert!((one - other).abs() <= 1e-11 * (1e-30 + other), "{case}: {one} for {other}");
            }
        }
        assert!(plain > 300 && wide > 20, "{plain} in plain numbers, {wide} not");
    }
}
