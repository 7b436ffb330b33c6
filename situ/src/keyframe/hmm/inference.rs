//! Likelihood, posteriors and best path, all in logarithms: two skills can be hundreds of standard deviations apart, and
//! a scaled recursion would lose the paths that matter.

use super::{EmissionDensity, Hmm};

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

/// Log probabilities of a chain, the impossible transitions left out.
#[derive(Default)]
pub(super) struct LogChain {
    initial: Vec<f64>,
    end: Vec<f64>,
    /// Predecessors of state j, in order, at `into_start[j]..into_start[j + 1]`.
    into: Vec<(usize, f64)>,
    into_start: Vec<usize>,
    /// Successors of state i, in order, at `out_start[i]..out_start[i + 1]`.
    out: Vec<(usize, f64)>,
    out_start: Vec<usize>,
}

impl LogChain {
    pub(super) fn set<E>(&mut self, hmm: &Hmm<E>) {
        let k = hmm.states();
        self.initial.clear();
        self.initial.extend(hmm.initial.iter().map(|probability| libm::log(*probability)));
        self.end.clear();
        self.end.extend(hmm.end.iter().map(|probability| libm::log(*probability)));
        self.into.clear();
        self.into_start.clear();
        self.out.clear();
        self.out_start.clear();
        for state in 0..k {
            self.into_start.push(self.into.len());
            self.out_start.push(self.out.len());
            for other in 0..k {
                let (to_here, from_here) = (hmm.transition[other * k + state], hmm.transition[state * k + other]);
                if to_here > 0.0 {
                    self.into.push((other, libm::log(to_here)));
                }
                if from_here > 0.0 {
                    self.out.push((other, libm::log(from_here)));
                }
            }
        }
        self.into_start.push(self.into.len());
        self.out_start.push(self.out.len());
    }

    fn predecessors(&self, state: usize) -> &[(usize, f64)] {
        &self.into[self.into_start[state]..self.into_start[state + 1]]
    }

    fn successors(&self, state: usize) -> &[(usize, f64)] {
        &self.out[self.out_start[state]..self.out_start[state + 1]]
    }

    fn states(&self) -> usize {
        self.initial.len()
    }

    /// One step of the forward recursion: `next[j]` = log Σ_i exp(`now[i]` + log a_ij) + log b_j.
    fn advance(&self, now: &[f64], log_densities: &[f64], next: &mut [f64]) {
        for (state, value) in next.iter_mut().enumerate() {
            let terms = self.predecessors(state).iter().map(|(from, weight)| now[*from] + weight);
            *value = log_sum_exp(terms) + log_densities[state];
        }
    }

    /// Fills `forward`, `occupancy` (T × K both) and adds to `transitions` (K × K); returns the log likelihood. Where that
    /// is −∞ there is no posterior, and `occupancy` and `transitions` are not touched.
    pub(super) fn expectations(
        &self,
        log_densities: &[f64],
        forward: &mut [f64],
        backward: &mut Vec<f64>,
        occupancy: &mut [f64],
        transitions: &mut [f64],
    ) -> f64 {
        let k = self.states();
        let frames = log_densities.len() / k;
        for state in 0..k {
            forward[state] = self.initial[state] + log_densities[state];
        }
        for frame in 1..frames {
            let (past, next) = forward.split_at_mut(frame * k);
            self.advance(&past[(frame - 1) * k..], &log_densities[frame * k..], &mut next[..k]);
        }
        let last = &forward[(frames - 1) * k..frames * k];
        let log_likelihood = log_sum_exp(last.iter().zip(&self.end).map(|(forward, end)| forward + end));
        if log_likelihood == f64::NEG_INFINITY {
            return log_likelihood;
        }
        // `backward` holds, for the frame after, log (b_j β_j), and then this frame's log β.
        backward.clear();
        backward.resize(2 * k, 0.0);
        let (after, now) = backward.split_at_mut(k);
        now.copy_from_slice(&self.end);
        for frame in (0..frames).rev() {
            if frame + 1 < frames {
                for state in 0..k {
                    let terms = self.successors(state).iter().map(|(to, weight)| weight + after[*to]);
                    now[state] = log_sum_exp(terms);
                    let reached = forward[frame * k + state] - log_likelihood;
                    for (to, weight) in self.successors(state) {
                        transitions[state * k + to] += exp(reached + weight + after[*to]);
                    }
                }
            }
            for state in 0..k {
                occupancy[frame * k + state] = exp(forward[frame * k + state] + now[state] - log_likelihood);
                after[state] = now[state] + log_densities[frame * k + state];
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
    pub(super) fn log_densities(&self, frames: &[E::Frame], densities: &mut Vec<f64>) {
        densities.clear();
        for frame in frames {
            densities.extend(self.emissions.iter().map(|emission| emission.log_density(frame)));
        }
    }

    /// Log probability of a sequence, its end included. −∞ for no frame: every sequence has one.
    pub fn log_likelihood(&self, frames: &[E::Frame]) -> f64 {
        let mut chain = LogChain::default();
        chain.set(self);
        self.log_likelihood_by(&chain, frames)
    }

    /// [`Hmm::log_likelihood`] of several sequences, summed in their order.
    pub fn total_log_likelihood<S: AsRef<[E::Frame]>>(&self, sequences: &[S]) -> f64 {
        let mut chain = LogChain::default();
        chain.set(self);
        sequences.iter().map(|sequence| self.log_likelihood_by(&chain, sequence.as_ref())).sum()
    }

    pub(super) fn log_likelihood_by(&self, chain: &LogChain, frames: &[E::Frame]) -> f64 {
        let Some(first) = frames.first() else { return f64::NEG_INFINITY };
        let densities = |frame| self.emissions.iter().map(move |emission| emission.log_density(frame));
        let mut now: Vec<f64> =
            chain.initial.iter().zip(densities(first)).map(|(start, density)| start + density).collect();
        let mut next = vec![0.0; now.len()];
        let mut here = vec![0.0; now.len()];
        for frame in &frames[1..] {
            for (value, density) in here.iter_mut().zip(densities(frame)) {
                *value = density;
            }
            chain.advance(&now, &here, &mut next);
            core::mem::swap(&mut now, &mut next);
        }
        log_sum_exp(now.iter().zip(&chain.end).map(|(forward, end)| forward + end))
    }

    /// Posterior counts of a sequence (the E step). None where the sequence has probability 0 or no frame.
    pub fn expectations(&self, frames: &[E::Frame]) -> Option<Expectations> {
        if frames.is_empty() {
            return None;
        }
        let k = self.states();
        let mut chain = LogChain::default();
        chain.set(self);
        let mut densities = Vec::new();
        self.log_densities(frames, &mut densities);
        let (mut forward, mut occupancy) = (vec![0.0; densities.len()], vec![0.0; densities.len()]);
        let mut transitions = vec![0.0; k * k];
        let log_likelihood =
            chain.expectations(&densities, &mut forward, &mut Vec::new(), &mut occupancy, &mut transitions);
        (log_likelihood > f64::NEG_INFINITY).then_some(Expectations { log_likelihood, occupancy, transitions })
    }

    /// The most probable path, shape (T), and its log probability with the frames and the end (Viterbi). Of paths that tie,
    /// the one through the lowest states at its last differing frame. No frame: no path, −∞.
    pub fn viterbi(&self, frames: &[E::Frame]) -> (Vec<usize>, f64) {
        if frames.is_empty() {
            return (Vec::new(), f64::NEG_INFINITY);
        }
        let k = self.states();
        let mut chain = LogChain::default();
        chain.set(self);
        let mut densities = Vec::new();
        self.log_densities(frames, &mut densities);
        let mut now: Vec<f64> = chain.initial.iter().zip(&densities).map(|(start, density)| start + density).collect();
        let mut next = vec![0.0; k];
        let mut from = vec![0; frames.len() * k];
        for frame in 1..frames.len() {
            for state in 0..k {
                let terms = chain.predecessors(state).iter().map(|(before, weight)| (*before, now[*before] + weight));
                let (before, value) = greatest(terms);
                from[frame * k + state] = before;
                next[state] = value + densities[frame * k + state];
            }
            core::mem::swap(&mut now, &mut next);
        }
        let (mut state, value) = greatest(now.iter().zip(&chain.end).map(|(now, end)| now + end).enumerate());
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
