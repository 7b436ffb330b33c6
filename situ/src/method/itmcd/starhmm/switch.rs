//! The M-steps of termination and entry: logistic regressions with soft labels. They never lower the expected
//! log-likelihood.

use super::cholesky;
use super::logarithms::{log_sigmoid, log_sum_exp};
use crate::vector::dot;

/// The Newton steps per M-step. EM repeats the M-step, so a few steps that improve are as good as the minimum.
const NEWTON_STEPS: usize = 2;
/// The greatest number of halvings of a step. After that the old weights stay.
const HALVINGS: usize = 12;

/// What a termination is fitted to: φ, Σ_j ξ(i, j ≠ i), ξ(i, i).
pub(super) type Exit<'a> = (&'a [f64], f64, f64);

/// A choice between children: their indices of v, ψ, and the weight of each child.
pub(super) struct Choice<'a> {
    pub(super) entries: Vec<usize>,
    pub(super) features: &'a [f64],
    pub(super) weights: Vec<f64>,
}

/// Improves w by Newton's method on the ridge objective. A step is taken only if the expected log-likelihood itself
/// does not fall. Returns the steps that were solved.
pub(super) fn improve_exit(weights: &mut Vec<f64>, seen: &[Exit<'_>], ridge: f64) -> usize {
    if seen.is_empty() {
        return 0;
    }
    let size = weights.len();
    let expected = |weights: &[f64]| -> f64 {
        let terms = seen.iter().map(|(features, ends, stays)| {
            let odds = dot(weights, features);
            ends * log_sigmoid(odds) + stays * log_sigmoid(-odds)
        });
        terms.sum()
    };
    for step in 1..=NEWTON_STEPS {
        let mut gradient: Vec<f64> = weights.iter().map(|weight| -ridge * weight).collect();
        let mut hessian = diagonal(size, ridge);
        for (features, ends, stays) in seen {
            let probability = libm::exp(log_sigmoid(dot(weights, features)));
            let slope = ends - (ends + stays) * probability;
            let curvature = (ends + stays) * probability * (1.0 - probability);
            add(&mut gradient, &mut hessian, (0, 0), features, slope, curvature);
        }
        if !climb(weights, gradient, hessian, expected) {
            return step;
        }
    }
    NEWTON_STEPS
}

/// Improves all v at once, in the same way.
pub(super) fn improve_entries(entries: &mut [Vec<f64>], choices: &[Choice<'_>], ridge: f64) -> usize {
    let Some(width) = entries.first().map(Vec::len).filter(|_| !choices.is_empty()) else { return 0 };
    // Only a v that is compared with another can be learned. The others stay out of the equations.
    let mut slot = vec![None; entries.len()];
    let mut used = Vec::new();
    for entry in choices.iter().flat_map(|choice| &choice.entries) {
        if slot[*entry].is_none() {
            slot[*entry] = Some(used.len());
            used.push(*entry);
        }
    }
    let position = |entry: &usize| slot[*entry].unwrap_or_default() * width;
    let mut weights: Vec<f64> = used.iter().flat_map(|entry| entries[*entry].iter().copied()).collect();
    let logs = |weights: &[f64], choice: &Choice<'_>| -> Vec<f64> {
        let score = |entry: &usize| dot(&weights[position(entry)..position(entry) + width], choice.features);
        let scores: Vec<f64> = choice.entries.iter().map(score).collect();
        let total = log_sum_exp(scores.iter().copied());
        scores.into_iter().map(|score| score - total).collect()
    };
    let expected = |weights: &[f64]| -> f64 {
        let of = |choice: &Choice<'_>| {
            let terms = choice.weights.iter().zip(logs(weights, choice)).filter(|(weight, _)| **weight > 0.0);
            terms.map(|(weight, log)| weight * log).sum::<f64>()
        };
        choices.iter().map(of).sum()
    };
    let mut steps = 0;
    while steps < NEWTON_STEPS {
        steps += 1;
        let mut gradient: Vec<f64> = weights.iter().map(|weight| -ridge * weight).collect();
        let mut hessian = diagonal(weights.len(), ridge);
        for choice in choices {
            let total: f64 = choice.weights.iter().sum();
            let probabilities: Vec<f64> = logs(&weights, choice).into_iter().map(libm::exp).collect();
            for (index, entry) in choice.entries.iter().enumerate() {
                let slope = choice.weights[index] - total * probabilities[index];
                for (other, to) in choice.entries.iter().enumerate() {
                    let own = if other == index { 1.0 } else { 0.0 };
                    let curvature = total * probabilities[index] * (own - probabilities[other]);
                    let at = (position(entry), position(to));
                    let slope = if other == index { slope } else { 0.0 };
                    add(&mut gradient, &mut hessian, at, choice.features, slope, curvature);
                }
            }
        }
        if !climb(&mut weights, gradient, hessian, expected) {
            break;
        }
    }
    for (entry, own) in used.iter().zip(weights.chunks_exact(width)) {
        entries[*entry].copy_from_slice(own);
    }
    steps
}

fn diagonal(size: usize, value: f64) -> Vec<f64> {
    let mut matrix = vec![0.0; size * size];
    for index in 0..size {
        matrix[index * size + index] = value;
    }
    matrix
}

/// Adds `slope` · φ to the rows of the gradient, and `curvature` · φ φᵀ to the block of the Hessian.
fn add(
    gradient: &mut [f64],
    hessian: &mut [f64],
    (row, column): (usize, usize),
    features: &[f64],
    slope: f64,
    curvature: f64,
) {
    let size = gradient.len();
    for (index, feature) in features.iter().enumerate() {
        gradient[row + index] += slope * feature;
        for (other, to) in features.iter().enumerate() {
            hessian[(row + index) * size + column + other] += curvature * feature * to;
        }
    }
}

/// One Newton step, halved until `expected` does not fall. False if no length will do.
fn climb(weights: &mut Vec<f64>, mut step: Vec<f64>, mut hessian: Vec<f64>, expected: impl Fn(&[f64]) -> f64) -> bool {
    let size = weights.len();
    if size == 0 || !cholesky::factor(&mut hessian, size) {
        return false;
    }
    cholesky::solve(&hessian, size, &mut step);
    let before = expected(weights);
    let mut length = 1.0;
    for _ in 0..HALVINGS {
        let there: Vec<f64> = weights.iter().zip(&step).map(|(weight, step)| weight + length * step).collect();
        if expected(&there) >= before {
            *weights = there;
            return true;
        }
        length *= 0.5;
    }
    false
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    const RIDGE: f64 = 1.0;
    const DRAWS: u64 = 20;

    /// The slopes of `objective` less the ridge at `weights`, by differences.
    fn slopes(weights: &[f64], objective: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        const STEP: f64 = 1e-5;
        let moved = |axis: usize, by: f64| {
            let mut there = weights.to_vec();
            there[axis] += by;
            objective(&there) - 0.5 * RIDGE * there.iter().map(|weight| weight * weight).sum::<f64>()
        };
        (0..weights.len()).map(|axis| (moved(axis, STEP) - moved(axis, -STEP)) / (2.0 * STEP)).collect()
    }

    fn is_top(slopes: &[f64]) -> bool {
        slopes.iter().all(|slope| slope.abs() < 1e-3)
    }

    /// From 0, a few M-steps end where the ridge objective is greatest; each has at most two Newton steps.
    #[test]
    fn terminations_climb_to_the_top() {
        for seed in 0..DRAWS {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let features: Vec<Vec<f64>> = (0..30).map(|_| vec![1.0, rng.random_range(-2.0..2.0)]).collect();
            let seen: Vec<Exit<'_>> = features
                .iter()
                .map(|features| (features.as_slice(), rng.random::<f64>(), rng.random::<f64>()))
                .collect();
            let mut weights = vec![0.0; 2];
            for _ in 0..10 {
                assert!((1..=NEWTON_STEPS).contains(&improve_exit(&mut weights, &seen, RIDGE)));
            }
            let objective = |weights: &[f64]| -> f64 {
                let probability =
                    |features: &[f64]| 1.0 / (1.0 + f64::exp(-weights[0] * features[0] - weights[1] * features[1]));
                seen.iter()
                    .map(|(x, ends, stays)| ends * probability(x).ln() + stays * (1.0 - probability(x)).ln())
                    .sum()
            };
            let slopes = slopes(&weights, objective);
            assert!(is_top(&slopes), "{seed}: {slopes:?} at {weights:?}");
        }
    }

    #[test]
    fn entries_climb_to_the_top() {
        const PLANTED: [f64; 4] = [1.5, 0.0, 0.0, -1.5];
        for seed in 0..DRAWS {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let features: Vec<Vec<f64>> = (0..40).map(|_| vec![1.0, rng.random_range(-2.0..2.0)]).collect();
            let choices: Vec<Choice<'_>> = features
                .iter()
                .enumerate()
                .map(|(index, features)| {
                    let entries = if index % 2 == 0 { vec![0, 1, 3] } else { vec![3, 1] };
                    let drawn = |entry: &usize| rng.random::<f64>() * f64::exp(PLANTED[*entry] * features[1]);
                    let weights = entries.iter().map(drawn).collect();
                    Choice { entries, features, weights }
                })
                .collect();
            let mut entries = vec![vec![0.0; 2], vec![0.0; 2], vec![5.0, -5.0], vec![0.0; 2]];
            for _ in 0..10 {
                assert!((1..=NEWTON_STEPS).contains(&improve_entries(&mut entries, &choices, RIDGE)));
            }
            assert_eq!(entries[2], [5.0, -5.0], "no choice is about it");
            let objective = |weights: &[f64]| -> f64 {
                let of = |choice: &Choice<'_>| -> f64 {
                    let score = |entry: &usize| {
                        f64::exp(weights[2 * entry] * choice.features[0] + weights[2 * entry + 1] * choice.features[1])
                    };
                    let all: f64 = choice.entries.iter().map(score).sum();
                    choice
                        .entries
                        .iter()
                        .zip(&choice.weights)
                        .map(|(entry, weight)| weight * (score(entry) / all).ln())
                        .sum()
                };
                choices.iter().map(of).sum()
            };
            let mut slopes = slopes(&entries.concat(), objective);
            slopes.drain(4..6);
            assert!(is_top(&slopes), "{seed}: {slopes:?} at {entries:?}");
        }
    }
}
