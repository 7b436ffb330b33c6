//! The parameters of a fit, and what can go wrong with one.

use thiserror::Error;

/// The parameters of [`super::Hmm::fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HmmParameters {
    /// The prior standard deviation of positions, metres: the root of the first block of S₀ (decision D12).
    pub position_floor: f64,
    /// The prior standard deviations of rotations about the axes of the gripper's frame, radians: the roots of the
    /// second block of S₀ (decisions D12 and D21).
    pub rotation_floor: [f64; 3],
    /// The weight ν₀ of the prior, in frames (decision D12).
    pub prior_weight: f64,
    /// The least probability of a transition, an end or a start that the topology allows (decision D12).
    pub transition_floor: f64,
    /// Whether a state can be skipped (decision D14). The probability of skipping starts at the floor.
    pub skip: bool,
    /// The greatest number of re-estimations.
    pub max_iterations: usize,
    /// The fit stops when the relative change of the objective is below this.
    pub tolerance: f64,
    /// Frames with which each kind of gripper command is credited before any command is seen.
    pub gripper_smoothing: f64,
}

impl Default for HmmParameters {
    /// Decisions D12 to D14: 2 cm, 9°, ν₀ = 4, floor 10⁻³, skips allowed, 20 iterations, 10⁻⁶.
    fn default() -> Self {
        Self {
            position_floor: 0.02,
            rotation_floor: [9.0 * core::f64::consts::PI / 180.0; 3],
            prior_weight: 4.0,
            transition_floor: 1e-3,
            skip: true,
            max_iterations: 20,
            tolerance: 1e-6,
            gripper_smoothing: 0.1,
        }
    }
}

/// A row has at most four ways on (stay, next, skip, end), and the floor must leave room for all of them.
const GREATEST_TRANSITION_FLOOR: f64 = 0.25;

impl HmmParameters {
    /// The prior standard deviation of each coordinate of a tangent vector: metres, then radians.
    pub(crate) fn floor(&self, coordinate: usize) -> f64 {
        if coordinate < 3 { self.position_floor } else { self.rotation_floor[coordinate - 3] }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`HmmError::Parameter`] for the first parameter that is out of its range.
    pub fn check(&self) -> Result<(), HmmError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let least = self
            .rotation_floor
            .into_iter()
            .fold(f64::INFINITY, |least, floor| if floor > least { least } else { floor });
        let rules = [
            ("position_floor", self.position_floor, positive(self.position_floor), "must be above 0"),
            ("rotation_floor", least, positive(least), "must be above 0"),
            ("prior_weight", self.prior_weight, positive(self.prior_weight), "must be above 0"),
            (
                "transition_floor",
                self.transition_floor,
                (0.0..GREATEST_TRANSITION_FLOOR).contains(&self.transition_floor),
                "must be at least 0 and below 0.25",
            ),
            ("tolerance", self.tolerance, self.tolerance >= 0.0, "must be at least 0"),
            ("gripper_smoothing", self.gripper_smoothing, positive(self.gripper_smoothing), "must be above 0"),
        ];
        match rules.into_iter().find(|(_, _, holds, _)| !holds) {
            None => Ok(()),
            Some((parameter, value, _, rule)) => Err(HmmError::Parameter { parameter, value, rule }),
        }
    }
}

/// Why a model could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum HmmError {
    /// There is no sequence.
    #[error("no sequence: a model is fitted to at least one")]
    NoSequence,
    /// A sequence has no frame.
    #[error("sequence {sequence} has no frame")]
    EmptySequence {
        /// Index of the sequence.
        sequence: usize,
    },
    /// The model would have no state.
    #[error("0 states: a model has at least one")]
    NoState,
    /// A number in the data is NaN or infinite.
    #[error("sequence {sequence}, frame {frame}: a pose or gripper value is not finite")]
    NotFinite {
        /// Index of the sequence.
        sequence: usize,
        /// Index of the frame in it.
        frame: usize,
    },
    /// No path of the model explains a sequence. This cannot happen with a transition floor above 0.
    #[error("sequence {sequence} has probability 0 under every path")]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
    },
    /// A covariance is not positive definite.
    #[error("a covariance is not positive definite")]
    NotPositiveDefinite,
    /// A hidden state that was read has numbers that no fit gives.
    #[error(
        "a hidden state needs finite numbers, a rotation of length 1, and probabilities and variances of a gripper"
    )]
    Written,
    /// The model to start from does not have the shape that the parameters ask for.
    #[error("the model to start from is not a left-to-right model of these parameters")]
    Topology,
    /// A parameter is out of its range.
    #[error("parameter `{parameter}` is {value}: {rule}")]
    Parameter {
        /// The parameter's name.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The rule it breaks.
        rule: &'static str,
    },
}
