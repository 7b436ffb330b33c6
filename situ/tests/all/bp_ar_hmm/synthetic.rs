//! Draws from the model without the sampler, and the distance of two labellings.

use nalgebra::{SMatrix, SVector};
use rand::{Rng, RngExt};
use situ::method::bp_ar_hmm::sampler::{DynamicsPrior, GammaPrior, LaggedSequence, Prior};
use situ::random::standard_normal;

/// The published priors, for observations whose first differences have unit variance.
pub(crate) fn published<const D: usize>() -> Prior<D> {
    let vague = GammaPrior { shape: 0.01, rate: 0.01 };
    let dynamics = DynamicsPrior {
        precision: SMatrix::identity() * 0.5,
        scale: SMatrix::identity() * 0.5,
        freedom: D as f64 + 2.0,
    };
    Prior { dynamics, alpha: vague, kappa: vague, gamma: vague, c: vague }
}

/// A gamma draw of whole or half shape: half the sum of squared normals (chi squared).
pub(crate) fn gamma_of_halves(halves: usize, rate: f64, rng: &mut impl Rng) -> f64 {
    (0..halves).map(|_| standard_normal(rng).powi(2)).sum::<f64>() / (2.0 * rate)
}

/// A Poisson draw: uniforms are multiplied until the product is below e^−mean (Knuth).
pub(crate) fn poisson(mean: f64, rng: &mut impl Rng) -> usize {
    let (mut product, mut count) = (rng.random::<f64>(), 0);
    while product > (-mean).exp() {
        product *= rng.random::<f64>();
        count += 1;
    }
    count
}

/// The frames of a sequence that begins at `first`. Each frame is `step` of the frame before.
pub(crate) fn frames<const D: usize>(
    first: SVector<f64, D>,
    states: &[usize],
    mut step: impl FnMut(usize, &SVector<f64, D>) -> SVector<f64, D>,
) -> LaggedSequence<D> {
    let (mut current, mut lagged) = (Vec::new(), Vec::new());
    let mut before = first;
    for state in states {
        lagged.push(before);
        before = step(*state, &before);
        current.push(before);
    }
    LaggedSequence { current, lagged }
}

/// The share of the frames with a wrong label. Found labels are matched one to one with true labels, in the best way.
pub(crate) fn hamming(truth: &[Vec<usize>], found: &[Vec<usize>]) -> f64 {
    let mut names: Vec<usize> = found.iter().flatten().copied().collect();
    names.sort_unstable();
    names.dedup();
    let true_names = 1 + truth.iter().flatten().copied().max().unwrap_or(0);
    let mut together = vec![vec![0_usize; names.len()]; true_names];
    let mut total = 0;
    for (truth, found) in truth.iter().flatten().zip(found.iter().flatten()) {
        together[*truth][names.binary_search(found).unwrap()] += 1;
        total += 1;
    }
    // Every choice of a found label, or none, for each true label. There are few true labels.
    fn best(together: &[Vec<usize>], taken: &mut Vec<bool>) -> usize {
        let Some((row, rest)) = together.split_first() else { return 0 };
        let mut most = best(rest, taken);
        for (name, count) in row.iter().enumerate() {
            if *count > 0 && !taken[name] {
                taken[name] = true;
                most = most.max(count + best(rest, taken));
                taken[name] = false;
            }
        }
        most
    }
    1.0 - best(&together, &mut vec![false; names.len()]) as f64 / total as f64
}
