//! A state-based transition autoregressive hidden Markov model (STARHMM; Kroemer, Daniel, Neumann, van Hoof and Peters
//! 2015).
//!
//! A hidden phase ρ_t makes the next state, y_t | x_t, ρ_t = i ~ N(W_i x_t, Σ_i), where x_t holds whatever the next
//! state is regressed on (the state before, an action, a constant). After a step the phase ends with probability τ_i =
//! σ(w_iᵀφ), and another begins: η_ij = softmax over the children j of i of v_jᵀψ, where φ and ψ are features of the
//! state that was reached. So T(i, j) = (1 − τ_i) 1\[i = j\] + τ_i η_ij. A phase that ends and begins again inside a
//! sequence would need a count of its own, so there a phase is no child of itself; as the phase that ran *before* a
//! sequence it can be.
//!
//! Three things are added to the paper's model. A step carries an observed *context* (here: the object that it is
//! about), and a phase makes steps of its own context alone. Where a segmentation is known, a phase can end at its cuts
//! alone: elsewhere τ is 0. And phases can share w and v, and be absent from some sequences: a new version of an old
//! phase.
//!
//! Nothing here knows tasks, physics, files or clocks. Sums are in a fixed order and logarithms from `libm`: equal
//! input, equal bits.

mod cholesky;
mod emission;
mod error;
mod fit;
mod inference;
mod logarithms;
mod model;
mod sequence;
mod switch;

pub use emission::LinearGaussian;
pub use error::StarhmmError;
pub use fit::{FitParameters, StarhmmFit};
pub use inference::{Posterior, Transition};
pub use model::{END, Phase, Starhmm};
pub use sequence::{StarhmmSequence, StarhmmStep};
