//! What carries the hand in an episode.

/// What carries the hand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Plant {
    /// An arm of seven joints behind the table. Motions keep to its reach and to the ranges and speeds of its joints,
    /// and it runs into things.
    #[default]
    Arm,
    /// Nothing: the hand goes wherever it is told.
    Hand,
}
