//! Demonstrations: what a teacher shows, as the learner sees it.
//!
//! A demonstration is an *observation*: poses and gripper readings in the world frame, each with the state of the world
//! before the motion that led there (decision D0). What a task file commands is another type, in another crate.

use std::sync::Arc;

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::error::SituError;
use crate::state::{Schema, State};

/// A rigid pose: translation in metres, rotation a unit quaternion.
pub type Pose = Isometry3<f64>;

/// What the gripper was told, or seen, to do at a keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gripper {
    /// Opening as a fraction of the stroke, 0 (closed) to 1 (open).
    Opening(f64),
    /// Opened to a width between the pads, metres.
    Open(f64),
    /// Closed with a force on each pad, newtons.
    Close(f64),
}

/// Two readings of the opening that differ by more than this, as a fraction of the stroke, are two commands.
const ANOTHER_OPENING: f64 = 0.2;

impl Gripper {
    /// Whether the hand closes or opens from one command to the next.
    pub fn is_moved_by(self, next: Self) -> bool {
        match (self, next) {
            (Self::Opening(before), Self::Opening(after)) => (after - before).abs() > ANOTHER_OPENING,
            (before, after) => std::mem::discriminant(&before) != std::mem::discriminant(&after),
        }
    }

    /// The number the command carries, in the unit of its kind.
    pub fn value(self) -> f64 {
        match self {
            Self::Opening(value) | Self::Open(value) | Self::Close(value) => value,
        }
    }
}

/// One keyframe of a demonstration.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframe {
    /// The reference object that the teacher names.
    pub reference: Arc<str>,
    /// Pose of the reference object, world frame.
    pub reference_pose: Pose,
    /// Pose of the gripper, world frame.
    pub gripper_pose: Pose,
    /// The gripper command in force from this keyframe on.
    pub gripper: Gripper,
    /// Seconds that the gripper rested at the keyframe, 0 or more.
    pub hold: f64,
    /// The world before the motion to this keyframe (decision D0).
    pub state: State,
    /// Whether the teacher names the reference object here anew, although the keyframe before is about the same one: a
    /// segment begins (decision D0c′). Where the object changes, one begins in any case.
    pub announced: bool,
    /// The teacher's name for the skill, where the teacher says one. SITU does not listen; some other methods do.
    pub narration: Option<Arc<str>>,
}

/// Whether a demonstration shows the whole task or mends a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// From the start of the task to its end.
    Original,
    /// Partial, given at or near a failure.
    Corrective,
}

/// A whole demonstration: keyframes in order, and how it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Demonstration {
    name: Arc<str>,
    kind: Kind,
    keyframes: Vec<Keyframe>,
    final_state: State,
    carried_to_end: bool,
}

impl Demonstration {
    /// A demonstration, checked against its schema.
    ///
    /// # Errors
    /// Where there is no keyframe, a state's length is not the schema's, or any number is not finite: with the
    /// demonstration's name and the keyframe's index.
    pub fn new(
        name: impl Into<Arc<str>>,
        kind: Kind,
        schema: &Schema,
        keyframes: Vec<Keyframe>,
        final_state: State,
        carried_to_end: bool,
    ) -> Result<Self, SituError> {
        let name = name.into();
        if keyframes.is_empty() {
            return Err(SituError::EmptyDemonstration { demonstration: name.to_string() });
        }
        for (index, keyframe) in keyframes.iter().enumerate() {
            let place = || format!("demonstration `{name}`, keyframe {index}");
            keyframe.state.check(schema, place)?;
            let finite = |pose: &Pose| pose.to_homogeneous().iter().all(|value| value.is_finite());
            let refuse = |what: &str| SituError::NotFinite { place: place(), what: what.to_owned() };
            if !finite(&keyframe.reference_pose) {
                return Err(refuse("reference_pose"));
            }
            if !finite(&keyframe.gripper_pose) {
                return Err(refuse("gripper_pose"));
            }
            if !keyframe.gripper.value().is_finite() {
                return Err(refuse("gripper"));
            }
            if !(keyframe.hold.is_finite() && keyframe.hold >= 0.0) {
                return Err(refuse("hold"));
            }
        }
        final_state.check(schema, || format!("demonstration `{name}`, final state"))?;
        Ok(Self { name, kind, keyframes, final_state, carried_to_end })
    }

    /// The demonstration's name.
    pub fn name(&self) -> &Arc<str> {
        &self.name
    }

    /// Original or corrective.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The keyframes in order; at least one.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// The world after the last keyframe.
    pub fn final_state(&self) -> &State {
        &self.final_state
    }

    /// Checks that its states, which all have one length, have a number for each of so many features.
    ///
    /// # Errors
    /// [`SituError::StateLength`].
    pub fn check_features(&self, expected: usize) -> Result<(), SituError> {
        let found = self.final_state.values().len();
        if found == expected {
            return Ok(());
        }
        Err(SituError::StateLength { place: format!("demonstration `{}`", self.name), found, expected })
    }

    /// Whether the teacher went on to the end of the task: only then is the final state an example of END.
    pub fn carried_to_end(&self) -> bool {
        self.carried_to_end
    }
}
