//! A sequence of a family's variations, met one after another.

/// The name of a stage at which the change is undone: the original task stands there again. No variation has this name.
pub const ORIGINAL: &str = "original";

/// Variations that a robot meets one after another, keeping what it learned of each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariationSequence {
    /// Its name.
    pub name: String,
    /// Why these, and in this order, in prose.
    pub analysis: String,
    /// Its stages: the names of the variations in order, or [`ORIGINAL`]. One may come again, but not at once.
    pub stages: Vec<String>,
}
