//! The nodes of a task model: primitives with the data beneath them, and END.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::place::{SampleId, Samples, SegmentId};
use crate::primitive::Learner;

/// One way of doing what a primitive does (decision D20).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Way<P> {
    /// The segments that its policy is fitted to.
    pub segments: BTreeSet<SegmentId>,
    /// The policy `π`.
    pub policy: P,
    /// The states in which this way is known to be the right one: where it was shown to begin, and where another way
    /// was begun and this one was shown in its place.
    pub wanted: BTreeSet<SampleId>,
    /// Whether a correction added it.
    pub is_corrective: bool,
}

/// A node `z`: a primitive with the data beneath it.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, bound(serialize = "L::Policy: Serialize, L::Classifier: Serialize"))]
#[serde(bound(deserialize = "L::Policy: DeserializeOwned, L::Classifier: DeserializeOwned"))]
pub struct Node<L: Learner> {
    /// The reference object of all its segments.
    pub reference: Arc<str>,
    /// The segments that are instances of the primitive.
    pub segments: BTreeSet<SegmentId>,
    /// The ways of doing it, the oldest first; never empty. The listing knows one, the policy `π`.
    pub ways: Vec<Way<L::Policy>>,
    /// The samples of its classifier.
    pub samples: Samples,
    /// The initiation classifier `c`.
    pub classifier: L::Classifier,
}

/// END: a pseudo-node with a classifier of its own (decision D11).
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(bound(serialize = "L::Classifier: Serialize", deserialize = "L::Classifier: DeserializeOwned"))]
pub struct End<L: Learner> {
    /// The samples of its classifier.
    pub samples: Samples,
    /// Its classifier; `None` until a demonstration was carried on to the end.
    pub classifier: Option<L::Classifier>,
}

impl<L: Learner> Node<L> {
    /// The newest way.
    pub fn newest(&self) -> &Way<L::Policy> {
        self.ways.last().expect("a node has a way")
    }

    /// The policies of its ways, the oldest first.
    pub fn policies(&self) -> Vec<&L::Policy> {
        self.ways.iter().map(|way| &way.policy).collect()
    }

    /// The segments that a policy of it is fitted to: fewer than it holds, where a modification replaced others.
    pub fn policy_segments(&self) -> BTreeSet<SegmentId> {
        self.ways.iter().flat_map(|way| &way.segments).copied().collect()
    }
}

// Written out, for a derived `Clone` would ask the learner for one.
impl<L: Learner> Clone for Node<L> {
    fn clone(&self) -> Self {
        Self {
            reference: self.reference.clone(),
            segments: self.segments.clone(),
            ways: self.ways.clone(),
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
