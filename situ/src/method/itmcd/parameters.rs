//! The choices of the reconstruction, where the paper's numbers are not known to us.

use super::starhmm::FitParameters;

/// The parameters of `itmcd`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItmcdParameters {
    /// The points that a segment is interpolated to, uniform in arc length, at least 2.
    pub points: usize,
    /// How many of the hand's nine coordinates are kept: those that vary most.
    pub coordinates: usize,
    /// How many state features an entry is regressed on: those that vary most.
    pub features: usize,
    /// The fit.
    pub fit: FitParameters,
}

impl Default for ItmcdParameters {
    /// Ten points: a segment has three to five keyframes, and more points count the same evidence more often. With 20,
    /// most corrections that need nothing get an edit. With 5, n is so small that the penalty hides many modifications.
    /// Three coordinates: an emission then has 15 parameters for 30 observations per segment. With six it has 39 for
    /// 60, with all nine 72 for 90.
    fn default() -> Self {
        Self {
            points: 10,
            coordinates: 3,
            features: 2,
            fit: FitParameters {
                // 2 cm, in units of 1 cm² ([`super::frames::UNIT`]). A missing or an additional keyframe moves the
                // points between its neighbours by about that much. With 1 cm most corrections that need nothing got a
                // new node or a modification.
                floor: 4.0,
                ridge: 1e-3,
                // A separable choice among a handful of samples gets a probability of about 95 %.
                switch_ridge: 0.05,
                // Candidates differ by whole nats; a hundredth of a nat decides nothing.
                tolerance: 0.01,
                max_iterations: 30,
            },
        }
    }
}
