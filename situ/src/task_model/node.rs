//! The nodes of a task model: primitives with the data beneath them, and END.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::Serialize;

use crate::place::{Samples, SegmentId};
use crate::primitive::Learner;

/// A node `z`: a primitive with the data beneath it.
#[derive(Debug, PartialEq, Serialize)]
#[serde(bound = "L::Policy: Serialize, L::Classifier: Serialize")]
pub struct Node<L: Learner> {
    /// The reference object of all its segments.
    pub reference: Arc<str>,
    /// The segments that are instances of the primitive.
    pub segments: BTreeSet<SegmentId>,
    /// The segments among them that its policy is fitted to: fewer after a modification (decision D18).
    pub policy_segments: BTreeSet<SegmentId>,
    /// The policy `π`.
    pub policy: L::Policy,
    /// The samples of its classifier.
    pub samples: Samples,
    /// The initiation classifier `c`.
    pub classifier: L::Classifier,
}

/// END: a pseudo-node with a classifier of its own (decision D11).
#[derive(Debug, PartialEq, Serialize)]
#[serde(bound = "L::Classifier: Serialize")]
pub struct End<L: Learner> {
    /// The samples of its classifier.
    pub samples: Samples,
    /// Its classifier; `None` until a demonstration was carried on to the end.
    pub classifier: Option<L::Classifier>,
}

// Written out, for a derived `Clone` would ask the learner for one.
impl<L: Learner> Clone for Node<L> {
    fn clone(&self) -> Self {
        Self {
            reference: self.reference.clone(),
            segments: self.segments.clone(),
            policy_segments: self.policy_segments.clone(),
            policy: self.policy.clone(),
            samples: self.samples.clone(),
            classifier: self.classifier.clone(),
        }
    }
}

impl<L: Learner> Clone for End<L> {
    fn clone(&self) -> Self {
        Self { samples: self.samples.clone(), classifier: self.classifier.clone() }
    }
}
