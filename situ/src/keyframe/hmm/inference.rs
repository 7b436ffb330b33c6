//! Likelihood, posteriors and best path.
//!
//! Two skills can be hundreds of standard deviations apart. A recursion that only scales each frame by one number would
//! lose the paths that matter. So there are two recursions. The first is for left-to-right models, in plain floats,
//! where each frame is scaled by its greatest density. What underflows there is below e^−708 of the product of the
//! greatest densities. If the likelihood is far above that, nothing of it was lost. Otherwise, and for a model of
//! another topology, the second recursion runs: its numbers have an exponent of their own.

mod cells;
mod general;
mod left_to_right;
mod recursion;
mod viterbi;
mod wide;

pub(super) use recursion::Recursion;

use super::density::EmissionDensity;
use super::model::Hmm;

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
}
