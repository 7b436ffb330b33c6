//! The sequences that a model makes.

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmStep {
    /// The context: what the step is about.
    pub context: usize,
    /// x_t, shape (m).
    pub regressors: Vec<f64>,
    /// y_t, shape (d).
    pub target: Vec<f64>,
    /// Whether the phase can end after it. If the segmentation is known, it cannot end inside a segment, and τ is 0
    /// there.
    pub can_end: bool,
    /// φ of the state that the step reached.
    pub exit_features: Vec<f64>,
    /// ψ of the state that the step reached.
    pub entry_features: Vec<f64>,
}

/// A sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmSequence {
    /// The phase that had ended when the sequence began. `None` if nothing had run.
    pub origin: Option<usize>,
    /// ψ of the state in which it began.
    pub entry_features: Vec<f64>,
    /// The steps, at least one.
    pub steps: Vec<StarhmmStep>,
    /// Whether [`super::END`] follows. Otherwise the sequence just stops.
    pub ends: bool,
}
