//! The hyperparameters: α and κ of the transitions, γ and c of the beta process.

use rand::Rng;

use super::chain::{Chain, GammaPrior};
use super::draw::{accepts, gamma, log_gamma_density};

/// The variance of the random walk of α and of c, which are about 1.
const NARROW: f64 = 1.0;
/// The variance of the random walk of κ, which is about 25.
const WIDE: f64 = 100.0;
/// The least value: the prior is cut off here. Below it a gamma walk of fixed variance does not move, and a weight of
/// shape α underflows.
const LEAST: f64 = 1e-3;

/// One Metropolis–Hastings step of a positive number. The proposal is gamma, with the present value as its mean and a
/// fixed variance.
fn walk(now: f64, variance: f64, prior: GammaPrior, log_rest: impl Fn(f64) -> f64, rng: &mut impl Rng) -> f64 {
    let shape_and_rate = |mean: f64| (mean * mean / variance, mean / variance);
    let (shape, rate) = shape_and_rate(now);
    let proposal = gamma(shape, rng) / rate;
    if !(LEAST..f64::MAX).contains(&proposal) {
        return now;
    }
    let (back, back_rate) = shape_and_rate(proposal);
    let log_target = |value: f64| log_gamma_density(value, prior.shape, prior.rate) + log_rest(value);
    let log_ratio = log_target(proposal) - log_target(now) + log_gamma_density(now, back, back_rate)
        - log_gamma_density(proposal, shape, rate);
    if accepts(log_ratio, rng) { proposal } else { now }
}

impl<const D: usize> Chain<D> {
    /// Updates α and κ given η.
    pub(super) fn update_stickiness(&mut self, rng: &mut impl Rng) {
        // The number of weights and the sum of their logarithms, on the diagonal and off it.
        let (mut own, mut other) = ((0.0, 0.0), (0.0, 0.0));
        for row in &self.state.rows {
            for from in 0..row.weights.size() {
                for to in 0..row.weights.size() {
                    let sums = if from == to { &mut own } else { &mut other };
                    sums.0 += 1.0;
                    sums.1 += libm::log(row.weights.value(from, to));
                }
            }
        }
        let log_weights = |shape: f64, sums: (f64, f64)| (shape - 1.0) * sums.1 - sums.0 * libm::lgamma(shape);
        for _ in 0..self.moves.inner {
            let kappa = self.state.kappa;
            let rest = |alpha: f64| log_weights(alpha, other) + log_weights(alpha + kappa, own);
            self.state.alpha = walk(self.state.alpha, NARROW, self.prior.alpha, rest, rng);
            let alpha = self.state.alpha;
            let rest = |kappa: f64| log_weights(alpha + kappa, own);
            self.state.kappa = walk(kappa, WIDE, self.prior.kappa, rest, rng);
        }
    }

    /// Updates γ and c given F: γ from its gamma posterior, c by a random walk.
    pub(super) fn update_beta_process(&mut self, rng: &mut impl Rng) {
        let mut owners = std::collections::BTreeMap::<usize, usize>::new();
        self.state.rows.iter().flat_map(|row| &row.active).for_each(|name| *owners.entry(*name).or_default() += 1);
        let n = self.sequences.len() as f64;
        let behaviours = owners.len() as f64;
        for _ in 0..self.moves.inner {
            let prior = self.prior.gamma;
            let shape = prior.shape + behaviours;
            self.state.gamma = gamma(shape, rng) / (prior.rate + self.harmonic(self.state.c));
            let mass = self.state.gamma;
            let rest = |c: f64| {
                let columns: f64 = owners.values().map(|m| libm::lgamma(n - *m as f64 + c)).sum();
                behaviours * (libm::log(c) - libm::lgamma(n + c)) + columns - mass * self.harmonic(c)
            };
            self.state.c = walk(self.state.c, NARROW, self.prior.c, rest, rng);
        }
    }
}
