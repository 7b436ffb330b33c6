//! The sequences that a model makes.

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmStep {
    /// What it is about.
    pub context: usize,
    /// x_t, shape (m).
    pub regressors: Vec<f64>,
    /// y_t, shape (d).
    pub target: Vec<f64>,
    /// Whether the phase can end after it; where the segmentation is known, inside a segment it cannot: τ is 0 there.
    pub can_end: bool,
    /// φ of the state that it reached.
    pub exit_features: Vec<f64>,
    /// ψ of the state that it reached.
    pub entry_features: Vec<f64>,
}

/// A sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmSequence {
    /// The phase that had ended when it began; `None` where nothing had run.
    pub origin: Option<usize>,
    /// ψ of the state in which it began.
    pub entry_features: Vec<f64>,
    /// At least one step.
    pub steps: Vec<StarhmmStep>,
    /// Whether [`END`] follows; otherwise it just stops.
    pub ends: bool,
}
