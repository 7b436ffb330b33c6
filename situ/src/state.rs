//! The observed state: named, scaled features of the world.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::error::SituError;

/// One scalar of the observed state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feature {
    /// Unique within its schema.
    pub name: String,
    /// The typical size of a difference that matters, in the feature's own unit, above 0 (decision D16).
    pub scale: f64,
}

/// An axis of the gripper's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// The named, scaled features of an observed state; one schema a task family (decision D0d).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Schema {
    features: Vec<Feature>,
    /// Half a turn of the hand about this axis of its frame is the same grasp (decision D24).
    #[serde(skip)]
    half_turn: Option<Axis>,
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
        Ok(Self { features, half_turn: None })
    }

    /// The same for a hand that is as it was after half a turn about an axis of its frame: a parallel gripper about its
    /// approach (decision D24).
    pub fn with_half_turn(self, axis: Option<Axis>) -> Self {
        Self { half_turn: axis, ..self }
    }

    /// The axis of the gripper's frame about which half a turn is the same grasp, if there is one.
    pub fn half_turn(&self) -> Option<Axis> {
        self.half_turn
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

    /// The squared distance to another state, each feature in units of its scale.
    pub fn squared_distance(&self, other: &Self, scales: &[f64]) -> f64 {
        let units = self.values().iter().zip(other.values()).zip(scales);
        units.map(|((here, there), scale)| ((here - there) / scale) * ((here - there) / scale)).sum()
    }

    /// The values, in the order of the schema.
    pub fn values(&self) -> &[f64] {
        &self.0
    }

    pub(crate) fn check(&self, schema: &Schema, place: impl Fn() -> String) -> Result<(), SituError> {
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
