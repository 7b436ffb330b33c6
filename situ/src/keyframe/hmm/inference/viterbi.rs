//! The most probable path.

use crate::keyframe::hmm::density::EmissionDensity;
use crate::keyframe::hmm::model::Hmm;

impl<E: EmissionDensity> Hmm<E> {
    /// The most probable path, shape (T), and its log probability with the frames and the end (Viterbi). If paths tie,
    /// it is the one through the lowest state at the last frame in which they differ. Without a frame there is no path,
    /// and −∞.
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
