//! A state-based transition autoregressive hidden Markov model (STARHMM; Kroemer, Daniel, Neumann, van Hoof and Peters
//! 2015).
//!
//! A hidden phase ρ_t makes the next state: y_t | x_t, ρ_t = i ~ N(W_i x_t, Σ_i). x_t holds what the next state is
//! regressed on (the state before, an action, a constant). After a step the phase ends with probability τ_i = σ(w_iᵀφ).
//! Then another phase begins: η_ij = softmax over the children j of i of v_jᵀψ. φ and ψ are features of the state that
//! was reached. So T(i, j) = (1 − τ_i) 1\[i = j\] + τ_i η_ij. Inside a sequence, a phase is not a child of itself,
//! because a phase that ends and begins again would need its own count. The phase that ran *before* a sequence can be
//! its own child.
//!
//! The paper's model is extended by three things. A step has an observed *context* (here the object that it is about),
//! and a phase only makes steps of its own context. If a segmentation is known, a phase can end only at its cuts, and
//! elsewhere τ is 0. Phases can share w and v, and be absent from some sequences, as a new version of an old phase is.
//!
//! Nothing here knows tasks, physics, files or clocks. Sums are in a fixed order and logarithms are from `libm`, so
//! equal input gives equal bits.

mod cholesky;
mod emission;
mod fit;
mod inference;
mod logarithms;
mod model;
mod switch;

pub use emission::LinearGaussian;
pub use fit::{FitParameters, StarhmmFit};
pub use inference::{Posterior, Transition};
pub use model::{END, Phase, Starhmm, StarhmmError, StarhmmSequence, StarhmmStep};
