//! The sampler of the beta-process autoregressive hidden Markov model (Fox, Sudderth, Jordan and Willsky 2009 and 2014;
//! split–merge moves in the manner of Hughes, Fox and Sudderth 2012). It knows frames and nothing of robots, files or
//! clocks.
//!
//! Of N sequences, sequence i uses the behaviours f_i:
//!
//! ```text
//! γ, c, α, κ ~ their gamma priors;   F ~ IBP(γ, c), given that every sequence has a behaviour
//! η_jk ~ Gamma(α + κ δ_jk, 1) for j, k in f_i;   π_jk = η_jk / Σ_k η_jk          for each sequence
//! z_1 ~ uniform over f_i;   z_t ~ π_{z_{t−1}}
//! x_t ~ N(A_{z_t} y_t, Σ_{z_t}), y_t = x_{t−1};   (A_k, Σ_k) ~ MNIW
//! ```
//!
//! That every sequence has a behaviour is a condition on the whole, hyperparameters and all, so that it cancels in each
//! conditional. A behaviour is told from another by its θ, never by its place in a list: the density of F is that of a
//! *set* of columns.

mod chain;
mod concentration;
mod draw;
mod dynamics;
mod features;
mod linear;
mod split_merge;
mod states;
mod weights;

pub use chain::{Chain, Row, State};
pub use dynamics::{Dynamics, DynamicsPrior, Posterior, Statistics};
pub use states::{backward_sample, log_forward, log_forward_of_weights};
pub use weights::Weights;

use nalgebra::SVector;

/// A gamma prior, the mean being `shape` / `rate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaPrior {
    /// Above 0.
    pub shape: f64,
    /// Above 0.
    pub rate: f64,
}

/// The priors of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior<const D: usize> {
    /// Of the dynamics.
    pub dynamics: DynamicsPrior<D>,
    /// Of α, what every transition weighs.
    pub alpha: GammaPrior,
    /// Of κ, what a self-transition weighs besides.
    pub kappa: GammaPrior,
    /// Of γ, the mass of the beta process.
    pub gamma: GammaPrior,
    /// Of c, its concentration.
    pub c: GammaPrior,
}

/// How the sampler moves. None of it changes what is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moves {
    /// Birth or death moves a sequence and sweep.
    pub births: usize,
    /// The shortest and the longest window of a data-driven birth, frames; both are cut to the sequence.
    pub window: (usize, usize),
    /// Split–merge moves a sweep.
    pub split_merges: usize,
    /// Random-walk moves of each of α, κ and c a sweep.
    pub inner: usize,
}

impl Default for Moves {
    /// Windows of 15 to 100 frames, 5 split–merge trials and 20 inner iterations are Fox's and Hughes's. Ten births or
    /// deaths are ours: a recording has many short behaviours, and with three a chain of 300 sweeps was further from
    /// the best states.
    fn default() -> Self {
        Self { births: 10, window: (15, 100), split_merges: 5, inner: 20 }
    }
}

/// The frames of one sequence: at least one, each with the frame before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence<const D: usize> {
    /// x_t.
    pub current: Vec<SVector<f64, D>>,
    /// y_t, as many.
    pub lagged: Vec<SVector<f64, D>>,
}

impl<const D: usize> Sequence<D> {
    /// Frames.
    pub fn len(&self) -> usize {
        self.current.len()
    }

    /// Whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.current.is_empty()
    }

    /// What the frames for which `belongs` say.
    pub(super) fn statistics(&self, belongs: impl Fn(usize) -> bool) -> Statistics<D> {
        let mut statistics = Statistics::default();
        for frame in (0..self.len()).filter(|frame| belongs(*frame)) {
            statistics.add(&self.current[frame], &self.lagged[frame], 1.0);
        }
        statistics
    }
}
