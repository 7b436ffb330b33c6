//! What a hidden state must offer.

use rand::Rng;

/// A density over frames, as a hidden state emits them.
pub trait EmissionDensity {
    /// What is emitted at one step.
    type Frame;

    /// Log density of a frame.
    fn log_density(&self, frame: &Self::Frame) -> f64;

    /// Log density of many frames under each of several emissions, a column an emission: that of frame t under emission
    /// k at `k * length + t`, where `length`, the length of `columns` over the number of emissions, is at least the
    /// number of frames. The rest of a column is left to the implementation.
    fn log_densities(emissions: &[Self], frames: &[&Self::Frame], columns: &mut [f64])
    where
        Self: Sized,
    {
        let length = columns.len() / emissions.len().max(1);
        for (emission, column) in emissions.iter().zip(columns.chunks_exact_mut(length.max(1))) {
            for (log_density, frame) in column.iter_mut().zip(frames) {
                *log_density = emission.log_density(frame);
            }
        }
    }

    /// Kullback–Leibler divergence KL(self ‖ other), nats.
    fn kl(&self, other: &Self) -> f64;

    /// A frame drawn from the density.
    fn sample(&self, rng: &mut impl Rng) -> Self::Frame;
}
