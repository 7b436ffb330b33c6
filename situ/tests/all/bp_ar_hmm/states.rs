//! The forward pass and the backward draws, against the enumeration of every path.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::method::bp_ar_hmm::sampler::{backward_sample, log_forward, log_forward_of_weights};

const STATES: usize = 3;
const FRAMES: usize = 4;

struct Chain {
    densities: Vec<Vec<f64>>,
    probabilities: Vec<f64>,
}

fn chain(seed: u64) -> Chain {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut probabilities: Vec<f64> = (0..STATES * STATES).map(|_| rng.random_range(0.05..1.0)).collect();
    for row in probabilities.chunks_mut(STATES) {
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|value| *value /= sum);
    }
    let densities = (0..STATES).map(|_| (0..FRAMES).map(|_| rng.random_range(-3.0..1.0)).collect()).collect();
    Chain { densities, probabilities }
}

impl Chain {
    /// Every path, with p(path, frames).
    fn paths(&self) -> Vec<(Vec<usize>, f64)> {
        (0..STATES.pow(FRAMES as u32))
            .map(|code| {
                let path: Vec<usize> = (0..FRAMES).map(|frame| code / STATES.pow(frame as u32) % STATES).collect();
                let mut weight = 1.0 / STATES as f64;
                path.windows(2).for_each(|pair| weight *= self.probabilities[pair[0] * STATES + pair[1]]);
                path.iter().enumerate().for_each(|(frame, state)| weight *= self.densities[*state][frame].exp());
                (path, weight)
            })
            .collect()
    }

    fn forward(&self) -> (f64, Vec<f64>) {
        let rows: Vec<&[f64]> = self.densities.iter().map(Vec::as_slice).collect();
        let mut filter = Vec::new();
        (log_forward(&rows, &self.probabilities, &mut filter), filter)
    }
}

#[test]
fn the_likelihood_is_the_sum_over_every_path() {
    for seed in 0..50 {
        let chain = chain(seed);
        let total: f64 = chain.paths().iter().map(|(_, weight)| weight).sum();
        assert!((chain.forward().0 - total.ln()).abs() < 1e-12, "{} is not {}", chain.forward().0, total.ln());
        let weights: Vec<Vec<f64>> =
            chain.densities.iter().map(|own| own.iter().map(|density| density.exp()).collect()).collect();
        let weights: Vec<&[f64]> = weights.iter().map(Vec::as_slice).collect();
        let found = log_forward_of_weights(&weights, &chain.probabilities).unwrap();
        assert!((found - total.ln()).abs() < 1e-12, "{found} is not {}", total.ln());
    }
}

/// Pearson's χ² over the 81 paths. Paths with an expected count below 5 are put together.
#[test]
fn states_are_drawn_as_often_as_their_paths_weigh() {
    const DRAWS: usize = 50_000;
    let chain = chain(7);
    let filter = chain.forward().1;
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut drawn: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
    for _ in 0..DRAWS {
        *drawn.entry(backward_sample(&filter, &chain.probabilities, STATES, &mut rng)).or_default() += 1;
    }
    let paths = chain.paths();
    let total: f64 = paths.iter().map(|(_, weight)| weight).sum();
    let (mut squares, mut cells, mut rare) = (0.0, 0, (0.0, 0.0));
    for (path, weight) in &paths {
        let (found, expected) = (drawn.get(path).copied().unwrap_or(0) as f64, DRAWS as f64 * weight / total);
        if expected < 5.0 {
            rare = (rare.0 + found, rare.1 + expected);
        } else {
            squares += (found - expected).powi(2) / expected;
            cells += 1;
        }
    }
    if rare.1 > 0.0 {
        squares += (rare.0 - rare.1).powi(2) / rare.1;
    }
    // χ² has the mean n and the variance 2n: this is four standard deviations above the mean.
    let n = f64::from(cells);
    assert!(cells > 40 && squares < n + 4.0 * (2.0 * n).sqrt(), "χ² of {squares} over {cells} cells");
}

/// A state that is at first 800 nats below the other one, and is still the only one that explains what follows.
#[test]
fn nothing_that_can_still_matter_is_rounded_away() {
    let densities = [vec![0.0, -3000.0, -3000.0], vec![-600.0, 0.0, 0.0]];
    let probabilities = [1.0 - 1e-200, 1e-200, 0.5, 0.5];
    let mut filter = Vec::new();
    let found = log_forward(&[&densities[0], &densities[1]], &probabilities, &mut filter);
    // There are two ways: out of the first state at the second frame, with log 1e-200 = −460.5, or in the second state
    // from the start, with −600 + log ½.
    let expected = 0.5_f64.ln() + 1e-200_f64.ln() + 0.5_f64.ln();
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
    // Without logarithms it would be lost, and the function reports that.
    let weights = densities.map(|own| own.into_iter().map(f64::exp).collect::<Vec<_>>());
    assert_eq!(log_forward_of_weights(&[&weights[0], &weights[1]], &probabilities), None);
}
