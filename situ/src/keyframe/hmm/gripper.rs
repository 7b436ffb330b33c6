//! The gripper command of a hidden state: its kind and its value (decision D11).

use core::f64::consts::PI;

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::parameters::HmmParameters;
use crate::demonstration::Gripper;
use crate::random::standard_normal;

/// The number of kinds. Arrays here have the order `Opening`, `Open`, `Close`.
const KINDS: usize = 3;
/// The prior standard deviation within a kind: a tenth of the stroke, a centimetre, five newtons.
const FLOOR: [f64; KINDS] = [0.1, 0.01, 5.0];
/// The mean of a kind that was never seen, and also its standard deviation: the middle of the hand's range, and the
/// whole range.
const UNSEEN: [f64; KINDS] = [0.5, 0.04, 20.0];

/// A categorical distribution over the kinds of command, and a Gaussian over the value within each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperEmission {
    /// The probability of each kind.
    pub probabilities: [f64; KINDS],
    /// The mean value of each kind: fraction, metres, newtons.
    pub means: [f64; KINDS],
    /// The variance of each kind, in the square of its unit, the prior included.
    pub variances: [f64; KINDS],
}

fn index(command: Gripper) -> usize {
    match command {
        Gripper::Opening(_) => 0,
        Gripper::Open(_) => 1,
        Gripper::Close(_) => 2,
    }
}

fn command(kind: usize, value: f64) -> Gripper {
    match kind {
        0 => Gripper::Opening(value),
        1 => Gripper::Open(value),
        _ => Gripper::Close(value),
    }
}

/// An emission, with the logarithms that its densities need.
pub(super) struct Scores {
    emission: GripperEmission,
    log_normalisers: [f64; KINDS],
}

impl Scores {
    /// See [`GripperEmission::log_density`].
    pub(super) fn log_density(&self, command: Gripper) -> f64 {
        let kind = index(command);
        self.log_normalisers[kind] - self.emission.half_squared(kind, command.value())
    }
}

impl GripperEmission {
    /// Whether its numbers are those of a distribution.
    pub(super) fn is_sound(&self) -> bool {
        let Self { probabilities, means, variances } = self;
        probabilities.iter().all(|share| (0.0..=1.0).contains(share))
            && means.iter().all(|mean| mean.is_finite())
            && variances.iter().all(|variance| variance.is_finite() && *variance > 0.0)
    }

    /// Before any command is seen, every kind is equally likely.
    pub(super) fn unseen() -> Self {
        Self { probabilities: [1.0 / KINDS as f64; KINDS], means: UNSEEN, variances: UNSEEN.map(|value| value * value) }
    }

    /// The log density of a command. The value is in the unit of its kind.
    pub fn log_density(&self, command: Gripper) -> f64 {
        let kind = index(command);
        self.log_normaliser(kind) - self.half_squared(kind, command.value())
    }

    /// The emission prepared for the densities of many commands.
    pub(super) fn scores(&self) -> Scores {
        Scores { emission: *self, log_normalisers: [0, 1, 2].map(|kind| self.log_normaliser(kind)) }
    }

    fn log_normaliser(&self, kind: usize) -> f64 {
        libm::log(self.probabilities[kind]) - 0.5 * libm::log(2.0 * PI * self.variances[kind])
    }

    /// Half the squared error of a value, in units of its standard deviation.
    fn half_squared(&self, kind: usize, value: f64) -> f64 {
        let error = value - self.means[kind];
        0.5 * error * error / self.variances[kind]
    }

    /// KL(self ‖ other): that of the kinds, and that of the values within each kind.
    pub fn kl(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for kind in 0..KINDS {
            let probability = self.probabilities[kind];
            if probability > 0.0 {
                let ratio = self.variances[kind] / other.variances[kind];
                let error = self.means[kind] - other.means[kind];
                let values = 0.5 * (ratio - 1.0 - libm::log(ratio) + error * error / other.variances[kind]);
                sum += probability * (libm::log(probability / other.probabilities[kind]) + values);
            }
        }
        sum
    }

    /// A command drawn from the density. The value is not clipped to the range of the hand.
    pub fn sample(&self, rng: &mut impl Rng) -> Gripper {
        let uniform = rng.random::<f64>();
        let kind = if uniform < self.probabilities[0] {
            0
        } else if uniform < self.probabilities[0] + self.probabilities[1] {
            1
        } else {
            2
        };
        command(kind, self.means[kind] + libm::sqrt(self.variances[kind]) * standard_normal(rng))
    }

    /// The most probable kind with its mean value; the first of those that tie.
    pub fn most_probable(&self) -> Gripper {
        let mut best = 0;
        for kind in 1..KINDS {
            if self.probabilities[kind] > self.probabilities[best] {
                best = kind;
            }
        }
        command(best, self.means[best])
    }

    /// The maximum a posteriori from weighted commands. Each kind is smoothed by `gripper_smoothing` frames, and each
    /// variance by `prior_weight` frames at the kind's floor. A kind without weight keeps its values.
    pub(super) fn estimate(
        &mut self,
        commands: impl Iterator<Item = (Gripper, f64)> + Clone,
        negligible: f64,
        parameters: &HmmParameters,
    ) {
        let (mut weights, mut sums, mut squares) = ([0.0; KINDS], [0.0; KINDS], [0.0; KINDS]);
        for (command, weight) in commands.clone() {
            weights[index(command)] += weight;
            sums[index(command)] += weight * command.value();
        }
        let total: f64 = weights.iter().sum();
        if total <= negligible {
            return;
        }
        for kind in 0..KINDS {
            let smoothing = parameters.gripper_smoothing;
            self.probabilities[kind] = (weights[kind] + smoothing) / (total + KINDS as f64 * smoothing);
            if weights[kind] > negligible {
                self.means[kind] = sums[kind] / weights[kind];
            }
        }
        for (command, weight) in commands {
            let error = command.value() - self.means[index(command)];
            squares[index(command)] += weight * error * error;
        }
        for kind in 0..KINDS {
            if weights[kind] > negligible {
                let prior = parameters.prior_weight * FLOOR[kind] * FLOOR[kind];
                self.variances[kind] = (squares[kind] + prior) / (weights[kind] + parameters.prior_weight);
            }
        }
    }

    /// What the prior adds to the objective of the fit.
    pub(super) fn log_prior(&self, parameters: &HmmParameters) -> f64 {
        (0..KINDS)
            .map(|kind| {
                let (variance, floor) = (self.variances[kind], FLOOR[kind]);
                parameters.gripper_smoothing * libm::log(self.probabilities[kind])
                    - 0.5 * parameters.prior_weight * (libm::log(variance) + floor * floor / variance)
            })
            .sum()
    }
}
