//! Likelihood, posteriors and best path.
//!
//! Two skills can be hundreds of standard deviations apart. A recursion that only scales each frame by one number would
//! lose the paths that matter. So there are two recursions. The first is for left-to-right models, in plain floats,
//! where each frame is scaled by its greatest density. What underflows there is below e^−708 of the product of the
//! greatest densities. If the likelihood is far above that, nothing of it was lost. Otherwise, and for a model of
//! another topology, the second recursion runs: its numbers have an exponent of their own.

mod general;
mod left_to_right;
mod recursion;
mod wide;

pub(super) use recursion::Recursion;

use super::density::EmissionDensity;
use super::model::Hmm;
use general::Cells;

/// The expected counts of one sequence of T frames under a model of K states.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectations {
    /// The log probability of the sequence, its end included.
    pub log_likelihood: f64,
    /// The probability of state k at frame t at `t * K + k`, shape (T, K). The first row counts starts, the last row
    /// counts ends.
    pub occupancy: Vec<f64>,
    /// The expected number of transitions from i to j at `i * K + j`, shape (K, K).
    pub transitions: Vec<f64>,
}

impl<E: EmissionDensity> Hmm<E> {
    /// The recursions over those of the sequences that have frames, with the log densities filled in.
    fn recursion<S: AsRef<[E::Frame]>>(&self, sequences: &[S]) -> Recursion {
        let mut starts = Vec::with_capacity(sequences.len() + 1);
        starts.push(0);
        let mut frames = 0;
        for length in sequences.iter().map(|sequence| sequence.as_ref().len()).filter(|length| *length > 0) {
            frames += length;
            starts.push(frames);
        }
        let mut recursion = Recursion::new(starts, self.states());
        let all: Vec<&E::Frame> = sequences.iter().flat_map(AsRef::as_ref).collect();
        E::log_densities(&self.emissions, &all, &mut recursion.log_densities_mut().columns);
        recursion
    }

    /// The log probability of a sequence, its end included. −∞ without a frame: every sequence has at least one.
    pub fn log_likelihood(&self, frames: &[E::Frame]) -> f64 {
        if frames.is_empty() { f64::NEG_INFINITY } else { self.total_log_likelihood(&[frames]) }
    }

    /// [`Hmm::log_likelihood`] of several sequences, summed in their order. A sequence without a frame does not count.
    pub fn total_log_likelihood<S: AsRef<[E::Frame]>>(&self, sequences: &[S]) -> f64 {
        self.recursion(sequences).forward(self).iter().sum()
    }

    /// The posterior counts of a sequence (the E step). `None` if the sequence has probability 0 or no frame.
    pub fn expectations(&self, frames: &[E::Frame]) -> Option<Expectations> {
        if frames.is_empty() {
            return None;
        }
        let k = self.states();
        let mut recursion = self.recursion(&[frames]);
        let log_likelihood = recursion.expect(self)[0];
        let occupancy = (0..frames.len() * k).map(|cell| recursion.occupancy(cell / k, cell % k)).collect();
        let transitions = recursion.transitions().to_vec();
        (log_likelihood > f64::NEG_INFINITY).then_some(Expectations { log_likelihood, occupancy, transitions })
    }

    /// The most probable path, shape (T), and its log probability with the frames and the end (Viterbi). If paths tie,
    /// it is the one through the lowest state at the last frame in which they differ. Without a frame there is no path,
    /// and −∞.
    pub fn viterbi(&self, frames: &[E::Frame]) -> (Vec<usize>, f64) {
        if frames.is_empty() {
            return (Vec::new(), f64::NEG_INFINITY);
        }
        let (k, all) = (self.states(), frames.iter().collect::<Vec<_>>());
        let mut densities = Cells::new(frames.len(), k);
        E::log_densities(&self.emissions, &all, &mut densities.columns);
        let logs = |probabilities: &[f64]| probabilities.iter().copied().map(libm::log).collect::<Vec<f64>>();
        let (initial, end) = (logs(&self.initial), logs(&self.end));
        let ways = self.ways_into();
        let mut now: Vec<f64> = (0..k).map(|state| initial[state] + densities.at(state, 0)).collect();
        let mut next = vec![0.0; k];
        let mut from = vec![0; frames.len() * k];
        for frame in 1..frames.len() {
            let row = &mut from[frame * k..(frame + 1) * k];
            for (state, ((next, from), (first, ways))) in next.iter_mut().zip(row).zip(&ways).enumerate() {
                let (before, value) = greatest((*first..).zip(ways).map(|(before, way)| (before, now[before] + way)));
                (*from, *next) = (before, value + densities.at(state, frame));
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

impl<E> Hmm<E> {
    /// For each state: the first state that leads into it, and the log probabilities of the ways from there on, up to
    /// the last that is open. A chain that is left-to-right has three at most, so a path costs frames × states.
    fn ways_into(&self) -> Vec<(usize, Vec<f64>)> {
        let k = self.states();
        let mut open = vec![k..0; k];
        for (at, _) in self.transition.iter().enumerate().filter(|(_, probability)| **probability > 0.0) {
            let range = &mut open[at % k];
            *range = range.start.min(at / k)..at / k + 1;
        }
        let ways = open.into_iter().enumerate().map(|(state, range)| {
            let ways = range.clone().map(|before| libm::log(self.transition[before * k + state]));
            (range.start, ways.collect())
        });
        ways.collect()
    }
}

/// The first of the greatest terms; (0, −∞) if there is none.
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
    use super::*;

    /// When the best path tried all states before each state, a segment of 1000 keyframes took four seconds.
    #[test]
    fn a_left_to_right_chain_has_three_ways_into_a_state_at_most() {
        let k = 400;
        let open = |at: usize| (at / k..=at / k + 2).contains(&(at % k));
        let transition: Vec<f64> = (0..k * k).map(|at| if open(at) { 0.25 } else { 0.0 }).collect();
        let hmm = Hmm { initial: vec![0.0; k], transition, end: vec![0.25; k], emissions: vec![(); k] };
        let ways = hmm.ways_into();
        assert_eq!(ways.iter().map(|(_, ways)| ways.len()).sum::<usize>(), 3 * k - 3);
        assert!(ways.iter().enumerate().all(|(state, (first, ways))| first + ways.len() == state + 1));
    }
}
