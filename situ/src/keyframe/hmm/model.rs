//! A hidden Markov model with an explicit end.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::density::EmissionDensity;
use super::emission::Emission;

/// A hidden Markov model with an explicit end. K states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hmm<E = Emission> {
    /// Probability of starting in each state, shape (K).
    pub initial: Vec<f64>,
    /// Probability of state j after state i at `i * K + j`, shape (K, K).
    pub transition: Vec<f64>,
    /// Probability that the sequence ends after state i, shape (K).
    pub end: Vec<f64>,
    /// What each state emits, shape (K).
    pub emissions: Vec<E>,
}

impl<E> Hmm<E> {
    /// The number of states K.
    pub fn states(&self) -> usize {
        self.emissions.len()
    }
}

impl<E: EmissionDensity> Hmm<E> {
    /// One sequence from the start to the end, each frame drawn from the likelihood (so with the prior of decision D12
    /// in it: for Monte Carlo, not for execution). Cut off at `max_len` frames where the end is not reached by then.
    pub fn sample(&self, rng: &mut impl Rng, max_len: usize) -> Vec<E::Frame> {
        let k = self.states();
        let mut frames = Vec::new();
        let mut next = draw(&self.initial, rng);
        while let Some(state) = next {
            if frames.len() == max_len {
                break;
            }
            frames.push(self.emissions[state].sample(rng));
            // What the row leaves to 1 is the end.
            next = draw(&self.transition[state * k..(state + 1) * k], rng);
        }
        frames
    }
}

impl Hmm {
    /// The same model without its gripper commands: what can be compared with a signature.
    pub fn poses_only(&self) -> Self {
        let emissions = self.emissions.iter().map(Emission::pose_only);
        Self { emissions: emissions.collect(), ..self.clone() }
    }
}

/// An index drawn by its probability; none with what they leave to 1.
fn draw(probabilities: &[f64], rng: &mut impl Rng) -> Option<usize> {
    let uniform = rng.random::<f64>();
    let mut below = 0.0;
    probabilities.iter().position(|probability| {
        below += probability;
        uniform < below
    })
}
