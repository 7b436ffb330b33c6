//! Counts of what happened: rollouts that succeeded, and what was spent on teaching.

use std::iter::Sum;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};
use situ_teachers::TeachingEffort;

/// Successes among evaluation rollouts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Rollouts at whose end the goal held.
    pub successes: u32,
    /// Rollouts in which the goal held after some primitive, the last one among them.
    pub once: u32,
    /// Rollouts.
    pub rollouts: u32,
}

impl Sum for Rate {
    fn sum<I: Iterator<Item = Self>>(rates: I) -> Self {
        rates.fold(Self::default(), |sum, rate| Self {
            successes: sum.successes.saturating_add(rate.successes),
            once: sum.once.saturating_add(rate.once),
            rollouts: sum.rollouts.saturating_add(rate.rollouts),
        })
    }
}

impl From<bool> for Rate {
    /// One rollout, and whether it succeeded.
    fn from(is_success: bool) -> Self {
        Self { successes: u32::from(is_success), once: u32::from(is_success), rollouts: 1 }
    }
}

/// The effort of teaching: number and length of demonstrations. A *demonstration* is one that the robot was given; a
/// *try* is one that the teacher performed, given or not. The lengths are over all tries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TotalEffort {
    /// Demonstrations.
    pub demonstrations: u32,
    /// Tries.
    pub tries: u32,
    /// Keyframes over all tries.
    pub keyframes: u32,
    /// Simulated seconds over all tries.
    pub seconds: f64,
    /// Path length of the gripper over all tries, metres.
    pub metres: f64,
    /// Grasps that the teacher thought of and dropped before trying; nobody saw them, so they are no tries.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub foreseen: u32,
}

impl TotalEffort {
    /// The effort of one try, and whether the robot was given it.
    pub fn of_try(effort: &TeachingEffort, given: bool) -> Self {
        let TeachingEffort { keyframes, seconds, metres, foreseen } = *effort;
        Self { demonstrations: u32::from(given), tries: 1, keyframes, seconds, metres, foreseen }
    }
}

impl AddAssign for TotalEffort {
    fn add_assign(&mut self, other: Self) {
        let add = |sum: &mut u32, other| *sum = sum.saturating_add(other);
        add(&mut self.demonstrations, other.demonstrations);
        add(&mut self.tries, other.tries);
        add(&mut self.keyframes, other.keyframes);
        add(&mut self.foreseen, other.foreseen);
        self.seconds += other.seconds;
        self.metres += other.metres;
    }
}

pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(crate) fn is_zero(count: &u32) -> bool {
    *count == 0
}

/// A number of things as the ledger writes it.
pub fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
