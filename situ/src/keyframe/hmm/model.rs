//! A hidden Markov model with an explicit end.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::density::EmissionDensity;
use super::emission::Emission;

/// A hidden Markov model of K states, with an explicit end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hmm<E = Emission> {
    /// The probability of starting in each state, shape (K).
    pub initial: Vec<f64>,
    /// The probability of state j after state i at `i * K + j`, shape (K, K).
    pub transition: Vec<f64>,
    /// The probability that the sequence ends after state i, shape (K).
    pub end: Vec<f64>,
    /// The emission of each state, shape (K).
    pub emissions: Vec<E>,
}

impl<E> Hmm<E> {
    /// The number of states K.
    pub fn states(&self) -> usize {
        self.emissions.len()
    }

    /// The expected number of frames in each state, n = πᵀ (I − A)⁻¹, shape (K). All are infinite if some sequence
    /// never ends.
    pub fn expected_visits(&self) -> Vec<f64> {
        let k = self.states();
        // (I − A)ᵀ n = π by elimination. No rows are exchanged. The rows of A sum to at most 1, so in every column the
        // diagonal outweighs the rest, and elimination preserves that.
        let mut matrix: Vec<f64> = (0..k * k)
            .map(|at| f64::from(u8::from(at / k == at % k)) - self.transition[(at % k) * k + at / k])
            .collect();
        let mut visits = self.initial.clone();
        for column in 0..k {
            if matrix[column * k + column] < f64::EPSILON {
                return vec![f64::INFINITY; k];
            }
            for row in column + 1..k {
                let factor = matrix[row * k + column] / matrix[column * k + column];
                for at in column..k {
                    matrix[row * k + at] -= factor * matrix[column * k + at];
                }
                visits[row] -= factor * visits[column];
            }
        }
        for row in (0..k).rev() {
            for at in row + 1..k {
                visits[row] -= matrix[row * k + at] * visits[at];
            }
            visits[row] /= matrix[row * k + row];
        }
        visits
    }

    /// The expected number of frames of a sequence.
    pub fn expected_length(&self) -> f64 {
        self.expected_visits().iter().sum()
    }
}

impl<E: EmissionDensity> Hmm<E> {
    /// One sequence from the start to the end, each frame drawn from the likelihood. It is for Monte Carlo, not for
    /// execution, as the likelihood includes the prior of decision D12. The sequence is cut off at `max_len` frames.
    pub fn sample(&self, rng: &mut impl Rng, max_len: usize) -> Vec<E::Frame> {
        let k = self.states();
        let mut frames = Vec::new();
        let mut next = draw(&self.initial, rng);
        while let Some(state) = next {
            if frames.len() == max_len {
                break;
            }
            frames.push(self.emissions[state].sample(rng));
            // What is missing to 1 in the row is the probability of the end.
            next = draw(&self.transition[state * k..(state + 1) * k], rng);
        }
        frames
    }
}

impl Hmm {
    /// The same model without its gripper commands. That can be compared with a signature.
    pub fn poses_only(&self) -> Self {
        let emissions = self.emissions.iter().map(Emission::pose_only);
        Self { emissions: emissions.collect(), ..self.clone() }
    }
}

/// An index, drawn by its probability. `None` has the probability that is missing to 1.
fn draw(probabilities: &[f64], rng: &mut impl Rng) -> Option<usize> {
    let uniform = rng.random::<f64>();
    let mut below = 0.0;
    probabilities.iter().position(|probability| {
        below += probability;
        uniform < below
    })
}
