//! What can go wrong when a scene is built, and where; the rules that its numbers and poses must keep.

use thiserror::Error;

use crate::frame::{self, Pose};

/// A mistake in the description of a scene, or a picture that could not be encoded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimError {
    /// Two objects were given the same name, or a name which the world itself uses.
    #[error("object `{object}`: the name is already taken")]
    DuplicateName {
        /// The name that was to be added.
        object: String,
    },
    /// No object has this name.
    #[error("object `{object}`: there is no object of this name")]
    UnknownObject {
        /// The name that was asked for.
        object: String,
    },
    /// A pose is not finite or lies outside the workshop.
    #[error("object `{object}`: its pose is not finite or lies further than {limit} m from the origin")]
    BadPose {
        /// The object concerned.
        object: String,
        /// The largest allowed distance from the world's origin, in metres.
        limit: f64,
    },
    /// A dimension or a property of the material is impossible.
    #[error("object `{object}`: {what} (got {value})")]
    BadValue {
        /// The object concerned.
        object: String,
        /// The rule that was broken.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// Beads were to be put into something that has no interior.
    #[error("object `{object}`: it is no container, so nothing can be put into it")]
    NoInterior {
        /// The object concerned.
        object: String,
    },
    /// The beads do not fit into the container.
    #[error("object `{object}`: {asked} beads do not fit, there is room for {room}")]
    DoesNotFit {
        /// The container.
        object: String,
        /// How many beads were to be put in.
        asked: usize,
        /// How many fit below the rim.
        room: usize,
    },
    /// An object was to slide that cannot.
    #[error("object `{object}`: it cannot slide, for it is fixed, slides already, or was to slide along itself")]
    NoSlide {
        /// The object that was to slide.
        object: String,
    },
    /// An object was to turn that cannot.
    #[error("object `{object}`: it cannot turn, for it is fixed, slides or turns already, or was to turn about itself")]
    NoHinge {
        /// The object that was to turn.
        object: String,
    },
    /// A mesh cannot be read, or is no body of convex groups.
    #[error("mesh: {problem}")]
    Mesh {
        /// What is wrong with it, and what was expected.
        problem: String,
    },
    /// An object was to be pushed that cannot go straight.
    #[error("object `{object}`: it turns on a hinge, so it cannot be pushed along a line")]
    NoPush {
        /// The object that was to be pushed.
        object: String,
    },
    /// An arm cannot be read, or cannot be mounted.
    #[error("arm: {reason}")]
    Arm {
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// A picture could not be encoded.
    #[error("picture: {reason}")]
    Picture {
        /// What is wrong with it.
        reason: String,
    },
}

/// No pose may be further than this from the world's origin, in metres.
const WORKSHOP: f64 = 5.0;

/// An error if any value is not within `[low, high]` (a value that is not a number is not). `what` is the rule, in
/// words.
pub(crate) fn within(object: &str, what: &'static str, values: &[f64], low: f64, high: f64) -> Result<(), SimError> {
    match values.iter().find(|&&v| !(low..=high).contains(&v)) {
        Some(&value) => Err(SimError::BadValue { object: object.to_owned(), what, value }),
        None => Ok(()),
    }
}

/// An error if the pose is not finite or outside the workshop.
pub(crate) fn check_pose(object: &str, pose: &Pose) -> Result<(), SimError> {
    if frame::is_finite(pose) && pose.translation.vector.norm() <= WORKSHOP {
        Ok(())
    } else {
        Err(SimError::BadPose { object: object.to_owned(), limit: WORKSHOP })
    }
}
