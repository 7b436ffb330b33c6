//! Demonstrations: what a teacher shows, as the learner sees it.
//!
//! A demonstration is an *observation*: poses and gripper readings in the world frame, each with the state of the world
//! before the motion that led there (decision D0). What a task file commands is another type, in another crate.

use std::sync::Arc;

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::error::SituError;

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

impl Gripper {
    /// The number the command carries, in the unit of its kind.
    pub fn value(self) -> f64 {
        match self {
            Self::Opening(value) | Self::Open(value) | Self::Close(value) => value,
        }
    }
}

/// One scalar of the observed state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feature {
    /// Unique within its schema.
    pub name: String,
    /// The typical size of a difference that matters, in the feature's own unit, above 0 (decision D16).
    pub scale: f64,
}

/// The named, scaled features of an observed state; one schema a task family (decision D0d).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Schema {
    features: Vec<Feature>,
}

impl Schema {
    /// A schema of these features, in this order.
    ///
    /// # Errors
    /// [`SituError::Schema`] where there is no feature, a name appears twice, or a scale is not finite and above 0.
    pub fn new(features: Vec<Feature>) -> Result<Self, SituError> {
        if features.is_empty() {
            return Err(SituError::Schema { feature: String::new(), problem: "a schema needs at least one feature" });
        }
        for (index, feature) in features.iter().enumerate() {
            let refuse = |problem| SituError::Schema { feature: feature.name.clone(), problem };
            if !(feature.scale.is_finite() && feature.scale > 0.0) {
                return Err(refuse("the scale must be a finite number above 0"));
            }
            if features[..index].iter().any(|other| other.name == feature.name) {
                return Err(refuse("the name appears twice"));
            }
        }
        Ok(Self { features })
    }

    /// The features in order.
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// The number of scalars of a state.
    pub fn len(&self) -> usize {
        self.features.len()
    }

    /// Never true: a schema has at least one feature.
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }
}

/// An observed state `s`: one number a feature of the schema, in the feature's own unit. Cheap to clone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct State(Arc<[f64]>);

impl State {
    /// A state of these values, in the order of the schema.
    pub fn new(values: impl Into<Arc<[f64]>>) -> Self {
        Self(values.into())
    }

    /// The values, in the order of the schema.
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    fn check(&self, schema: &Schema, place: impl Fn() -> String) -> Result<(), SituError> {
        if self.0.len() != schema.len() {
            return Err(SituError::StateLength { place: place(), found: self.0.len(), expected: schema.len() });
        }
        match self.0.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(index) => Err(SituError::NotFinite {
                place: place(),
                what: format!("state, feature `{}`", schema.features()[index].name),
            }),
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

/// A keyframe relative to its segment's reference object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelativeKeyframe {
    /// Pose of the gripper in the frame of the reference object, frozen at the segment's first keyframe (decision D0b).
    pub pose: Pose,
    /// The gripper command in force from this keyframe on.
    pub gripper: Gripper,
    /// Seconds of rest at the keyframe.
    pub hold: f64,
}

/// A segment `d` of a demonstration: the keyframes about one reference object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// The reference object.
    pub reference: Arc<str>,
    /// The state `S[i]`: the world before the motion to the segment's first keyframe (decision D0).
    pub start: State,
    /// At least one keyframe, relative to the reference object.
    pub keyframes: Vec<RelativeKeyframe>,
    /// What the teacher called it: one name, or several in order where skills on one object follow each other. Empty
    /// unless every keyframe was named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub narration: Vec<Arc<str>>,
}
