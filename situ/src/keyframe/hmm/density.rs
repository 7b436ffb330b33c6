//! What a hidden state must offer.

use rand::Rng;

/// The density of the frames that a hidden state emits.
pub trait EmissionDensity {
    /// What is emitted at one step.
    type Frame;

    /// Log density of a frame.
    fn log_density(&self, frame: &Self::Frame) -> f64;

    /// The log densities of many frames under each of several emissions, one column per emission.
    ///
    /// That of frame t under emission k is at `k * length + t`. `length` is the length of `columns` divided by the
    /// number of emissions; it is at least the number of frames. The implementation may write anything into the rest of
    /// a column.
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
