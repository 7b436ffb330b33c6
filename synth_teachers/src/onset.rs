//! When a teacher steps in to correct a robot.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::random::stream;

use crate::profile::Profile;

/// When a teacher steps in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Onset {
    /// At the first moment at which the robot has to be stopped.
    OnTime,
    /// One primitive before.
    Early,
    /// At the second such moment, or at the robot's own end.
    Late,
}

/// When a teacher of this profile steps in: one draw a correction.
pub(crate) fn onset(profile: &Profile, seed: u64) -> Onset {
    let draw = ChaCha8Rng::seed_from_u64(stream(seed, "onset")).random::<f64>();
    if draw < profile.begins_early {
        Onset::Early
    } else if draw < profile.begins_early + profile.begins_late {
        Onset::Late
    } else {
        Onset::OnTime
    }
}
