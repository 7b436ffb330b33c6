//! The edit to a task model that a variation needs.

use serde::Deserialize;

/// The edit to a task model that a variation needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NeededEdit {
    /// A primitive that the model does not have.
    NodeAddition,
    /// A transition that the model does not have, between primitives that it has.
    EdgeAddition,
    /// A primitive must be performed in another way.
    NodeModification,
    /// None: the model's relative keyframes absorb the change. The control.
    None,
}

impl NeededEdit {
    /// The word that files use.
    pub fn word(self) -> &'static str {
        match self {
            NeededEdit::NodeAddition => "node-addition",
            NeededEdit::EdgeAddition => "edge-addition",
            NeededEdit::NodeModification => "node-modification",
            NeededEdit::None => "none",
        }
    }
}
