//! The effort of teaching.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// The effort of teaching: number and length of demonstrations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TotalEffort {
    /// Demonstrations.
    pub demonstrations: u32,
    /// Keyframes over all of them.
    pub keyframes: u32,
    /// Simulated seconds over all of them.
    pub seconds: f64,
    /// Path length of the gripper over all of them, metres.
    pub metres: f64,
}

impl From<&situ_teachers::TeachingEffort> for TotalEffort {
    /// The effort of one demonstration.
    fn from(effort: &situ_teachers::TeachingEffort) -> Self {
        let situ_teachers::TeachingEffort { keyframes, seconds, metres } = *effort;
        Self { demonstrations: 1, keyframes, seconds, metres }
    }
}

impl AddAssign for TotalEffort {
    fn add_assign(&mut self, other: Self) {
        self.demonstrations += other.demonstrations;
        self.keyframes += other.keyframes;
        self.seconds += other.seconds;
        self.metres += other.metres;
    }
}
