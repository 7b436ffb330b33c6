//! What a collider belongs to.

/// The name by which [`crate::World::touching`] knows the table.
pub const TABLE: &str = "table";
/// The name by which [`crate::World::touching`] knows the hand.
pub const HAND: &str = "hand";
/// The name by which [`crate::World::touching`] knows the arm.
pub const ARM: &str = "arm";

/// What a collider belongs to. The engine keeps it in the collider's user data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tag {
    /// The table.
    Table,
    /// Palm or finger.
    Hand,
    /// A link of the arm.
    Arm,
    /// A bead.
    Bead,
    /// The object of this index.
    Object(usize),
}

impl Tag {
    pub(crate) fn encode(self) -> u128 {
        match self {
            Tag::Table => 0,
            Tag::Hand => 1,
            Tag::Bead => 2,
            Tag::Arm => 3,
            Tag::Object(index) => 4 + index as u128,
        }
    }

    pub(crate) fn decode(data: u128) -> Tag {
        match data {
            0 => Tag::Table,
            1 => Tag::Hand,
            2 => Tag::Bead,
            3 => Tag::Arm,
            index => Tag::Object((index - 4) as usize),
        }
    }
}
