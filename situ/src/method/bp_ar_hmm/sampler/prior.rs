//! The priors of the model.

use super::dynamics::DynamicsPrior;

/// A gamma prior with the mean `shape` / `rate`.
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
    /// That of the dynamics.
    pub dynamics: DynamicsPrior<D>,
    /// That of α, the weight of every transition.
    pub alpha: GammaPrior,
    /// That of κ, the additional weight of a self-transition.
    pub kappa: GammaPrior,
    /// That of γ, the mass of the beta process.
    pub gamma: GammaPrior,
    /// That of c, the concentration of the beta process.
    pub c: GammaPrior,
}
