//! The moments at which a watching teacher looks.

use serde::Deserialize;

/// When an attentive teacher looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Moment {
    /// Before a primitive begins.
    Before,
    /// After a primitive has ended.
    After,
    /// When the guard has stopped a motion of a primitive.
    Guard,
}
