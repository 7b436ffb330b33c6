//! The verdict on a measurement.

use std::fmt;

/// Instructions that differ by no more than this share are unchanged.
pub const TOLERANCE: f64 = 0.02;

/// A measurement compared with the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Some work is less and none is more.
    Improved,
    /// Some work is more.
    Regressed,
    /// All work is the same.
    Unchanged,
    /// There is nothing to compare with: the protocol is another, or one of the two lacks the row.
    Incomparable,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Improved => "improved",
            Self::Regressed => "regressed",
            Self::Unchanged => "unchanged",
            Self::Incomparable => "incomparable",
        })
    }
}

/// Whether so many instructions now are another number than before, by [`TOLERANCE`].
pub(super) fn instructions_differ(before: u64, now: u64) -> bool {
    (now as f64 - before as f64).abs() > TOLERANCE * before as f64
}
