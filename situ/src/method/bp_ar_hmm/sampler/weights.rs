//! The transition weights η of one sequence.

use rand::Rng;
use serde::Serialize;

use super::draw::gamma;

/// η over the behaviours of one sequence, row by row. The probabilities π are its rows, normalised.
///
/// The sums of the rows matter: the η of an added behaviour is compared with them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weights {
    size: usize,
    values: Vec<f64>,
}

impl Weights {
    /// A draw from the prior for so many behaviours.
    pub fn from_prior(size: usize, alpha: f64, kappa: f64, rng: &mut impl Rng) -> Self {
        let values =
            (0..size * size).map(|cell| gamma(prior_shape(cell / size == cell % size, alpha, kappa), rng)).collect();
        Self { size, values }
    }

    /// A draw given the numbers of transitions: π_j ~ Dir(α + κδ + n_j). The sum of the row does not depend on z, so it
    /// is ~ Gamma(K α + κ, 1). A draw from Gamma(α + κδ + n, 1) would have the right π, but its sum would be too great.
    pub(super) fn given(counts: &[f64], size: usize, alpha: f64, kappa: f64, rng: &mut impl Rng) -> Self {
        let mut values = Vec::with_capacity(size * size);
        for from in 0..size {
            let row: Vec<f64> = (0..size)
                .map(|to| gamma(prior_shape(from == to, alpha, kappa) + counts[from * size + to], rng))
                .collect();
            let sum: f64 = row.iter().sum();
            let whole = gamma(size as f64 * alpha + kappa, rng);
            values.extend(row.iter().map(|value| (value / sum * whole).max(super::draw::LEAST)));
        }
        Self { size, values }
    }

    /// The number of behaviours.
    pub fn size(&self) -> usize {
        self.size
    }

    /// η from one behaviour to another, by their places in the sequence's list.
    pub fn value(&self, from: usize, to: usize) -> f64 {
        self.values[from * self.size + to]
    }

    /// π, row by row.
    pub fn probabilities(&self) -> Vec<f64> {
        let mut values = self.values.clone();
        for row in values.chunks_mut(self.size.max(1)) {
            let sum: f64 = row.iter().sum();
            row.iter_mut().for_each(|value| *value /= sum);
        }
        values
    }

    /// With one more behaviour at the end; its weights are drawn from the prior.
    pub(super) fn grown(&self, alpha: f64, kappa: f64, rng: &mut impl Rng) -> Self {
        let size = self.size + 1;
        let mut values = Vec::with_capacity(size * size);
        for from in 0..size {
            for to in 0..size {
                let known = from < self.size && to < self.size;
                values.push(if known {
                    self.value(from, to)
                } else {
                    gamma(prior_shape(from == to, alpha, kappa), rng)
                });
            }
        }
        Self { size, values }
    }

    /// Without the behaviour at this place.
    pub(super) fn shrunk(&self, place: usize) -> Self {
        let kept = |cell: &usize| cell / self.size != place && cell % self.size != place;
        let values = (0..self.values.len()).filter(kept).map(|cell| self.values[cell]).collect();
        Self { size: self.size - 1, values }
    }
}

/// α + κ δ.
pub(super) fn prior_shape(is_self: bool, alpha: f64, kappa: f64) -> f64 {
    if is_self { alpha + kappa } else { alpha }
}
