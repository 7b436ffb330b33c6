//! The step in which a world is advanced.

/// Duration of a step in seconds. At 120 Hz a full pitcher slips 10 mm in the hand.
pub const DT: f64 = 1.0 / 240.0;

/// The longest time that is waited in one go, seconds: an hour.
const LONGEST: f64 = 3600.0;

/// Whole steps in so many seconds; none if negative or not a number, at most an hour's worth.
pub(crate) fn steps_in(seconds: f64) -> u64 {
    if seconds > 0.0 { libm::round(seconds.min(LONGEST) / DT) as u64 } else { 0 }
}
