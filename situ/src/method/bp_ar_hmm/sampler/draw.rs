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

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// The density sums to 1 over a fine grid, and its mean is shape / rate.
    #[test]
    fn the_gamma_density_is_a_density() {
        for (shape, rate) in [(1.0, 1.0), (2.5, 0.5), (4.0, 3.0), (9.0, 2.0)] {
            const STEP: f64 = 0.001;
            let at = |index: u32| (f64::from(index) + 0.5) * STEP;
            let density = |x: f64| STEP * f64::exp(log_gamma_density(x, shape, rate));
            let mass: f64 = (0..60_000).map(|index| density(at(index))).sum();
            let mean: f64 = (0..60_000).map(|index| at(index) * density(at(index))).sum();
            assert!((mass - 1.0).abs() < 1e-6 && (mean - shape / rate).abs() < 1e-5, "{shape} {rate}: {mass} {mean}");
        }
    }

    /// A draw has the mean and the variance of the density, below shape 1 as well.
    #[test]
    fn gamma_draws_have_the_moments_of_the_density() {
        const DRAWS: usize = 20_000;
        for shape in [0.3, 0.9, 1.0, 2.5, 40.0] {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let draws: Vec<f64> = (0..DRAWS).map(|_| gamma(shape, &mut rng)).collect();
            let mean = draws.iter().sum::<f64>() / DRAWS as f64;
            let variance = draws.iter().map(|draw| (draw - mean) * (draw - mean)).sum::<f64>() / DRAWS as f64;
            // Both are the shape. Five standard errors: the fourth central moment is 3 k² + 6 k.
            let error = |variance: f64| 5.0 * f64::sqrt(variance / DRAWS as f64);
            assert!((mean - shape).abs() < error(shape), "{shape}: mean {mean}");
            assert!((variance - shape).abs() < error(2.0 * shape * shape + 6.0 * shape), "{shape}: {variance}");
        }
    }

    #[test]
    fn a_move_is_made_as_often_as_its_ratio_says() {
        const DRAWS: usize = 20_000;
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for ratio in [0.0, 0.1, 0.5, 0.9, 1.0, 3.0, f64::NAN] {
            let made = (0..DRAWS).filter(|_| accepts(f64::ln(ratio), &mut rng)).count() as f64 / DRAWS as f64;
            let expected = if ratio.is_nan() { 0.0 } else { ratio.min(1.0) };
            assert!((made - expected).abs() < 0.02, "{ratio}: {made}");
        }
    }
}
