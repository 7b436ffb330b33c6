//! How a run ended.

use serde::{Deserialize, Serialize};

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The target success rate was reached within the budget.
    Reached,
    /// The budget was used up first.
    Censored,
    /// The original task was never learned. Counted apart; it is the same for every method.
    Untaught,
    /// Physics failed (a body quarantined, NaN). Counted apart, and never as a failure of the method.
    Spoilt {
        /// The reason.
        why: String,
    },
    /// The method has nothing to do in this cell.
    NotApplicable,
}

impl Outcome {
    /// Whether the run says something about the method: it reached the target or used the budget up.
    pub fn counts(&self) -> bool {
        matches!(self, Self::Reached | Self::Censored)
    }
}
