//! Counts in the ledger.

/// A number of things as the ledger writes it.
pub fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
