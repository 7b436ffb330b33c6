//! What the reconstruction chooses where the paper's numbers are not known.

use super::starhmm::FitParameters;

/// What a step is regressed on beside the share of the segment that is behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lag {
    /// Nothing: a phase is a path with scatter.
    None,
    /// The point before in the same segment: a first-order autoregression. Interpolated neighbours are so alike that it
    /// learns to copy: a path that is shifted as a whole is then improbable at its first point alone, and modifications
    /// are not seen.
    One,
}

/// The parameters of `itmcd`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItmcdParameters {
    /// Points a segment is interpolated to, uniform in arc length, at least 2.
    pub points: usize,
    /// Coordinates of the hand that are kept, of nine: those that vary most.
    pub coordinates: usize,
    /// State features that an entry is regressed on: those that vary most.
    pub features: usize,
    /// The regressors.
    pub lag: Lag,
    /// The fit.
    pub fit: FitParameters,
}

impl Default for ItmcdParameters {
    /// Ten points: three to five keyframes are a segment, so more count the same evidence more often (with 20, most
    /// corrections that need nothing are given an edit), and with 5 the penalty of a small n hides many modifications.
    /// Three coordinates: an emission has 15 parameters then for 30 observations a segment, with six 39 for 60, with
    /// all nine 72 for 90.
    fn default() -> Self {
        Self {
            points: 10,
            coordinates: 3,
            features: 2,
            lag: Lag::None,
            fit: FitParameters {
                // In units of 1 cm² ([`super::frames::UNIT`]): 2 cm, about what a keyframe too many or too few moves
                // the points between its neighbours by. With 1 cm most corrections that need nothing got a new node or
                // a modification.
                floor: 4.0,
                ridge: 1e-3,
                // A separable choice among a handful of samples is believed to about 95 %.
                switch_ridge: 0.05,
                // A candidate is chosen by differences of nats; a hundredth of one decides nothing.
                tolerance: 0.01,
                max_iterations: 30,
            },
        }
    }
}
