//! The priors of the model.

use super::dynamics::DynamicsPrior;

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
