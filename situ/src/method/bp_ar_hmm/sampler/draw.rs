//! Draws and densities of the few distributions that the sampler needs.

use rand::{Rng, RngExt};

use crate::random::standard_normal;

/// The least gamma draw. A weight of 0 would shut a transition for good, and its logarithm is not finite. One draw of
/// shape 0.01 in 100 is below this.
pub(super) const LEAST: f64 = 1e-200;

/// A draw of Gamma(`shape`, rate 1), for a shape above 0 (Marsaglia and Tsang 2000; below shape 1 by their power of a
/// uniform).
pub(super) fn gamma(shape: f64, rng: &mut impl Rng) -> f64 {
    if shape < 1.0 {
        let uniform = 1.0 - rng.random::<f64>();
        return (gamma(shape + 1.0, rng) * libm::exp(libm::log(uniform) / shape)).max(LEAST);
    }
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / libm::sqrt(9.0 * d);
    loop {
        let normal = standard_normal(rng);
        let root = 1.0 + c * normal;
        let uniform = 1.0 - rng.random::<f64>();
        if root > 0.0 {
            let cube = root * root * root;
            if libm::log(uniform) < 0.5 * normal * normal + d * (1.0 - cube + libm::log(cube)) {
                return (d * cube).max(LEAST);
            }
        }
    }
}

/// log density of Gamma(`shape`, `rate`) at `x` > 0.
pub(super) fn log_gamma_density(x: f64, shape: f64, rate: f64) -> f64 {
    shape * libm::log(rate) - libm::lgamma(shape) + (shape - 1.0) * libm::log(x) - rate * x
}

/// An index drawn in proportion to the weights, which are not negative and not all 0.
pub(super) fn categorical(weights: &[f64], rng: &mut impl Rng) -> usize {
    let total: f64 = weights.iter().sum();
    let mut left = rng.random::<f64>() * total;
    let mut last = 0;
    for (index, weight) in weights.iter().enumerate() {
        if *weight > 0.0 {
            last = index;
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
    }
    last
}

/// Whether a move with this log acceptance ratio is made. It never is if the ratio is NaN.
pub(super) fn accepts(log_ratio: f64, rng: &mut impl Rng) -> bool {
    libm::log(1.0 - rng.random::<f64>()) < log_ratio
}
