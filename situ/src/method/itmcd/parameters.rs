//! What the reconstruction chooses where the paper's numbers are not known.

use serde::Serialize;

use super::starhmm::FitParameters;

/// What a step is regressed on beside the share of the segment that is behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Lag {
    /// Nothing: a phase is a path with scatter.
    None,
    /// The point before in the same segment: a first-order autoregression.
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
    /// Ten points: fewer leave a single original with no more observations than parameters; more count the same keyframes more often.
    /// Three coordinates and two features: with all nine a phase has 72 parameters, more than a demonstration has observations of it.
    fn default() -> Self {
        Self {
            points: 10,
            coordinates: 3,
            features: 2,
            lag: Lag::None,
            fit: FitParameters {
                // In units of 1 cm² ([`super::frames::UNIT`]): the variance of a novice's keyframe, so that what is interpolated, and
                // smooth between its keyframes, is not taken for exact.
                floor: 1.0,
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
