//! A sequence of a family's variations, met one after another.

/// Variations that a robot meets one after another, keeping what it learned of each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariationSequence {
    /// Its name.
    pub name: String,
    /// Why these, and in this order, in prose.
    pub analysis: String,
    /// The names of the variations, in order.
    pub variations: Vec<String>,
}
