//! What the paper leaves open about the *structure* of an update, each decision a switch.
//!
//! | decision | where |
//! |---|---|
//! | D0, D0b, D0c, D0d: start states, frames, segments, schema | [`demonstration`], [`segmentation`], [`state`] |
//! | D1, D2, D3, D10, D18: switches of an update | here; what they do is in [`crate::mending`] |
//! | D4: a segment is clustered with the candidates; other groups of them merge | [`crate::update::Update::cluster`] |
//! | D9: merged nodes have new names | [`crate::update::Renamed`] |
//! | D11: START, END, and no confident child | [`crate::place::Place`], [`crate::update`] |
//! | D17: what an update did | [`crate::trace`] |
//! | D2b, D2c, D5 to D8, D10b, D12 to D16: the kernels | [`crate::keyframe`] |
//!
//! [`demonstration`]: crate::demonstration
//! [`segmentation`]: crate::segmentation
//! [`state`]: crate::state

use serde::{Deserialize, Serialize};

/// Decision D2: negatives that no sibling gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Background {
    /// Whether the start states of neighbours are negatives: of the predecessor in an update, of predecessors and
    /// successors in a full retraining.
    pub neighbours: bool,
    /// How many start states of other primitives, spread evenly over the model, are negatives.
    pub others: usize,
}

/// Decision D10: which primitives are compared with a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Candidates {
    /// The applicable primitives `Z`, of whatever reference object, as printed.
    Applicable,
    /// The primitives of `Z` with the segment's reference object; where none of them matches, this many others of that
    /// object, the most probable in the start state.
    ReferenceFallback(usize),
    /// Every primitive of the model: what indexing saves, made visible (`situ:all_nodes`).
    All,
}

/// Decision D18: when a segment replaces a primitive's policy. Otherwise the segment adds a primitive, or is averaged
/// into the policy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modify {
    /// The primitive's classifier must give the segment's start state at least this probability. The primitive that ran
    /// last needs none: the teacher has just seen it run, and stepped in.
    pub min_probability: f64,
    /// The segment must be no further from the primitive's policy than this, in the unit of the cut.
    pub max_distance: f64,
    /// A segment replaces the policy where it is displaced from it by at least this much, metres; infinite is never.
    /// This holds for a match and for an unmatched segment. An average of a displaced match would do neither the old
    /// thing nor the new. A segment that is displaced by less is one more instance: a clumsy demonstration of the old
    /// thing must not replace it. See [`crate::primitive::Learner::displacement`].
    pub min_displacement: f64,
}

/// The decisions. [`Decisions::mended`] is `situ`. [`Decisions::literal`] is the listing as printed, as far as the
/// keyframe instantiation can do it: with D0, D4, D9, START and END. It takes over the same original model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decisions {
    /// D1: take a primitive's own positives out of its negatives (A2.17 as printed leaves them in).
    pub subtract_own_positives: bool,
    /// D2: background negatives.
    pub background: Background,
    /// D3: give the segment's start state to the siblings as a negative, END among them, and terminal states to END's
    /// siblings.
    pub push_to_siblings: bool,
    /// D4: whether clusters of candidates without the segment are merged.
    pub merge_redundant: bool,
    /// D10: the candidates.
    pub candidates: Candidates,
    /// D18: modification.
    pub modify: Option<Modify>,
}

impl Decisions {
    /// The decisions of `situ`.
    pub const fn mended() -> Self {
        Self {
            subtract_own_positives: true,
            background: Background { neighbours: true, others: 8 },
            push_to_siblings: true,
            merge_redundant: true,
            candidates: Candidates::ReferenceFallback(8),
            // The robot would have executed the child that it modifies: 0.3 is the quick protocol's confidence. A shape
            // that changes by 12 cm has distances of 17 to 34 in sort_blocks/high_bins. A novice's keyframe, with 1 cm
            // of noise, is 6 cm from the mean at the most; that of a near-variant is 8 cm from it.
            modify: Some(Modify { min_probability: 0.3, max_distance: 40.0, min_displacement: 0.07 }),
        }
    }

    /// The listing as printed.
    pub const fn literal() -> Self {
        Self {
            subtract_own_positives: false,
            background: Background { neighbours: false, others: 0 },
            push_to_siblings: false,
            merge_redundant: true,
            candidates: Candidates::Applicable,
            modify: None,
        }
    }
}

impl Default for Decisions {
    fn default() -> Self {
        Self::mended()
    }
}
