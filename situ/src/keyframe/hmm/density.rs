//! What a hidden state must offer.

use rand::Rng;

/// A density over frames, as a hidden state emits them.
pub trait EmissionDensity {
    /// What is emitted at one step.
    type Frame;

    /// Log density of a frame.
    fn log_density(&self, frame: &Self::Frame) -> f64;

    /// Kullback–Leibler divergence KL(self ‖ other), nats.
    fn kl(&self, other: &Self) -> f64;

    /// A frame drawn from the density.
    fn sample(&self, rng: &mut impl Rng) -> Self::Frame;
}
