//! The successes of an evaluation.

use std::iter::Sum;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Successes among evaluation rollouts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Rollouts that succeeded.
    pub successes: u32,
    /// Rollouts.
    pub rollouts: u32,
}

impl AddAssign for Rate {
    fn add_assign(&mut self, other: Self) {
        self.successes += other.successes;
        self.rollouts += other.rollouts;
    }
}

impl Sum for Rate {
    fn sum<I: Iterator<Item = Self>>(rates: I) -> Self {
        rates.fold(Self::default(), |mut sum, rate| {
            sum += rate;
            sum
        })
    }
}

impl From<bool> for Rate {
    /// One rollout, and whether it succeeded.
    fn from(is_success: bool) -> Self {
        Self { successes: u32::from(is_success), rollouts: 1 }
    }
}
