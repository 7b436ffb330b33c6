//! The sampler of the beta-process autoregressive hidden Markov model (Fox, Sudderth, Jordan and Willsky 2009 and 2014;
//! split–merge moves in the manner of Hughes, Fox and Sudderth 2012). It knows frames, and nothing about robots, files
//! or clocks.
//!
//! There are N sequences. Sequence i uses the behaviours f_i:
//!
//! ```text
//! γ, c, α, κ ~ their gamma priors;   F ~ IBP(γ, c), given that every sequence has a behaviour
//! η_jk ~ Gamma(α + κ δ_jk, 1) for j, k in f_i;   π_jk = η_jk / Σ_k η_jk          for each sequence
//! z_1 ~ uniform over f_i;   z_t ~ π_{z_{t−1}}
//! x_t ~ N(A_{z_t} y_t, Σ_{z_t}), y_t = x_{t−1};   (A_k, Σ_k) ~ MNIW
//! ```
//!
//! The condition that every sequence has a behaviour is on the whole model, with its hyperparameters, so it cancels in
//! each conditional. Behaviours differ by their θ, never by their place in a list: the density of F is that of a *set*
//! of columns.

mod chain;
mod concentration;
mod draw;
mod dynamics;
mod features;
mod split_merge;
mod states;
mod weights;

pub use chain::{Chain, ChainState, GammaPrior, LaggedSequence, Moves, Prior, SequenceState};
pub use dynamics::{Dynamics, DynamicsPosterior, DynamicsPrior, Statistics};
pub use states::{backward_sample, log_forward, log_forward_of_weights};
pub use weights::Weights;
