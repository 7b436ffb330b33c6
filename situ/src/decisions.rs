//! What the paper leaves open about the *structure* of an update, each decision a switch.
//!
//! | decision | where |
//! |---|---|
//! | D0, D0b, D0c, D0d: start states, frames, segments, schema | [`demonstration`], [`segmentation`], [`state`] |
//! | D1, D2, D3, D10: switches of an update | here; what they do is in [`crate::mending`] |
//! | D18, D19: a segment shows another way of a primitive | here; [`crate::another_way`] |
//! | D20: old ways and new ones | here; [`crate::worlds`], [`crate::task_model::TaskModel::way_in`] |
//! | D22: obedience | here; `situ/src/obedience.rs` |
//! | D23: the trail of the rollout that failed | here; [`crate::trail`] |
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

use crate::primitive::Displacement;

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

/// How far is far enough for another way, in both units (decisions D18 and D21).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// Metres.
    pub metres: f64,
    /// Units of the teacher's own scatter.
    pub scatters: f64,
}

impl Limit {
    /// Whether a displacement is as far as that, in both units.
    pub fn is_reached(self, displacement: Displacement) -> bool {
        displacement.metres >= self.metres && displacement.scatters >= self.scatters
    }
}

/// Decision D18: when a segment shows another way of doing what a primitive does. Otherwise the segment adds a
/// primitive, or is averaged into the policy. An average of a displaced match would do neither the old thing nor the
/// new. A segment that is not displaced is one more instance: a clumsy demonstration of the old thing is no new way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modify {
    /// By distance alone, the primitive's classifier must give the segment's start state at least this probability.
    /// What was interrupted needs none: the teacher has just seen it run, and stepped in.
    pub min_probability: f64,
    /// By distance alone, the segment must be no further from the primitive's policy than this, in the unit of the cut.
    pub max_distance: f64,
    /// How far a segment is displaced that shows another way of what the robot was just doing: of the primitive that
    /// was interrupted, or kept from beginning, or that ran last and is done again (decision D21).
    pub near: Limit,
    /// How far a segment is displaced that shows another way of any other primitive.
    pub far: Limit,
}

/// Decision D20: what becomes of the old way where a new one is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ways {
    /// The new way replaces it.
    Replace,
    /// Both stand in one node, which has so many ways at the most; in its own world the older one runs.
    Keep(usize),
}

impl Ways {
    /// How many ways a node has at the most.
    pub const fn most(self) -> usize {
        match self {
            Self::Replace => 1,
            Self::Keep(most) => most,
        }
    }
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
    /// D19: whether an unmatched segment takes the place of a primitive by what follows it, whatever the distance.
    pub follow: bool,
    /// D20: old ways and new ones.
    pub ways: Ways,
    /// D22: whether the model obeys: in the state in which something was shown, it chooses that.
    pub obey: bool,
    /// D23: whether the trail of the rollout that failed is heeded.
    pub trail: bool,
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
            // that changes by 12 cm has distances of 17 to 34 in sort_blocks/high_bins.
            modify: Some(Modify {
                min_probability: 0.3,
                max_distance: 40.0,
                near: Limit { metres: 0.0, scatters: 4.0 },
                far: Limit { metres: 0.07, scatters: 7.0 },
            }),
            follow: true,
            // People change their mind a few times; each way costs an evaluation of A2.2 as a primitive does.
            ways: Ways::Keep(6),
            obey: true,
            trail: true,
        }
    }

    /// The same, but a new way replaces the old one: D19, D20, D22 and D23 are off. What the robot was doing and what
    /// it did not count alike.
    pub const fn replacing() -> Self {
        let far = Limit { metres: 0.07, scatters: 0.0 };
        Self {
            modify: Some(Modify { min_probability: 0.3, max_distance: 40.0, near: far, far }),
            follow: false,
            ways: Ways::Replace,
            obey: false,
            trail: false,
            ..Self::mended()
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
            follow: false,
            ways: Ways::Replace,
            obey: false,
            trail: false,
        }
    }
}

impl Default for Decisions {
    fn default() -> Self {
        Self::mended()
    }
}
