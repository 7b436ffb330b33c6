//! The states of one sequence: forward filtering and backward sampling.
//!
//! The recursion is scaled, not in logarithms. Every transition has a probability above 0, so no path is cut off for
//! good.

use rand::Rng;

use super::draw::categorical;

/// log p(x | π, θ) of one sequence, with its states summed out and a uniform first state. `densities[k][t]` is log
/// p(x_t | state k), for K states and T frames. `probabilities` is π, K × K row by row. −∞ if there is no state.
///
/// `filter` receives p(z_t = k | x_1 … x_t) at `t * K + k`.
pub fn log_forward(densities: &[&[f64]], probabilities: &[f64], filter: &mut Vec<f64>) -> f64 {
    let k = densities.len();
    let frames = densities.first().map_or(0, |density| density.len());
    filter.clear();
    filter.resize(frames * k, 0.0);
    if k == 0 {
        return f64::NEG_INFINITY;
    }
    let mut total = 0.0;
    for frame in 0..frames {
        let (past, rest) = filter.split_at_mut(frame * k);
        let now = &mut rest[..k];
        if frame == 0 {
            now.fill(1.0 / k as f64);
        } else {
            for (from, reached) in past[(frame - 1) * k..].iter().enumerate() {
                for (value, probability) in now.iter_mut().zip(&probabilities[from * k..(from + 1) * k]) {
                    *value += reached * probability;
                }
            }
        }
        let greatest = densities.iter().map(|density| density[frame]).fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (value, density) in now.iter_mut().zip(densities) {
            *value *= libm::exp(density[frame] - greatest);
            sum += *value;
        }
        now.iter_mut().for_each(|value| *value /= sum);
        total += greatest + libm::log(sum);
    }
    total
}

/// If a sum of the forward pass is outside these bounds, [`log_forward`] takes over. Inside them, what is rounded to 0
/// is 10²⁰⁰ times less than what is not.
const TRUSTED: core::ops::Range<f64> = 1e-100..1e100;

/// [`log_forward`] of densities that were exponentiated before, so that many sets of states can be tried without an
/// exponential. `weights[k][t]` is p(x_t | state k) divided by a factor of the frame; the result does not include the
/// factors. `None` if rounding could matter, or if there are more than 64 states.
pub fn log_forward_of_weights(weights: &[&[f64]], probabilities: &[f64]) -> Option<f64> {
    // Most of the time of a sweep is spent here, and loops of a known length stay in registers.
    match weights.len() {
        0 => None,
        1..=4 => padded::<4>(weights, probabilities),
        5..=8 => padded::<8>(weights, probabilities),
        9..=12 => padded::<12>(weights, probabilities),
        13..=16 => padded::<16>(weights, probabilities),
        17..=24 => padded::<24>(weights, probabilities),
        25..=32 => padded::<32>(weights, probabilities),
        33..=64 => padded::<64>(weights, probabilities),
        _ => None,
    }
}

/// [`log_forward_of_weights`] of at most K states. The missing ones have weight 0.
fn padded<const K: usize>(weights: &[&[f64]], probabilities: &[f64]) -> Option<f64> {
    let k = weights.len();
    let frames = weights.first().map_or(0, |weight| weight.len());
    let mut onto = [[0.0; K]; K];
    for (row, probabilities) in onto.iter_mut().zip(probabilities.chunks_exact(k)) {
        row[..k].copy_from_slice(probabilities);
    }
    let mut now = [0.0; K];
    now[..k].fill(1.0 / k as f64);
    // The sums are multiplied as long as that is safe; then the logarithm of the product is taken.
    let (mut total, mut product) = (0.0, 1.0);
    for frame in 0..frames {
        if frame > 0 {
            let mut next = [0.0; K];
            for (reached, row) in now[..k].iter().zip(&onto) {
                for to in 0..K {
                    next[to] += reached * row[to];
                }
            }
            now = next;
        }
        let mut sum = 0.0;
        for (value, weight) in now.iter_mut().zip(weights) {
            *value *= weight[frame];
            sum += *value;
        }
        if !TRUSTED.contains(&sum) {
            return None;
        }
        let scale = 1.0 / sum;
        now.iter_mut().for_each(|value| *value *= scale);
        product *= sum;
        if !TRUSTED.contains(&product) {
            total += libm::log(product);
            product = 1.0;
        }
    }
    Some(total + libm::log(product))
}

/// A draw of the states given a filter of [`log_forward`]: one per frame, as a place in the list of states.
pub fn backward_sample(filter: &[f64], probabilities: &[f64], k: usize, rng: &mut impl Rng) -> Vec<usize> {
    let frames = filter.len().checked_div(k).unwrap_or(0);
    let mut states = vec![0; frames];
    let mut weights = vec![0.0; k];
    for frame in (0..frames).rev() {
        for (from, weight) in weights.iter_mut().enumerate() {
            let onwards = if frame + 1 < frames { probabilities[from * k + states[frame + 1]] } else { 1.0 };
            *weight = filter[frame * k + from] * onwards;
        }
        states[frame] = categorical(&weights, rng);
    }
    states
}
