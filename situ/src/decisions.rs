//! What the paper leaves open about the *structure* of an update, each decision a switch.
//!
//! The kernels' own decisions (D2b, D2c, D5 to D8, D12 to D16) are parameters of [`crate::keyframe`].

use serde::{Deserialize, Serialize};

/// Decision D2: negatives that no sibling gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Background {
    /// Whether the start states of predecessors and successors are negatives.
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
    /// object, the nearest by start state.
    ReferenceFallback(usize),
    /// Every primitive of the model: what indexing saves, made visible (`situ:all_nodes`).
    All,
}

/// Decision D18: when a segment replaces a primitive's policy instead of adding a primitive beside it, or being averaged into it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modify {
    /// The primitive's classifier must give the segment's start state at least this probability. The primitive that ran last is
    /// asked for none: it has just been seen to run, and the teacher to step in.
    pub min_probability: f64,
    /// The segment must be no further from the primitive's policy than this, in the unit of the cut.
    pub max_distance: f64,
    /// A segment replaces the policy where it is displaced from it by at least this much, be it a match or not: within the cut, an average
    /// would do neither the old thing nor the new; beyond it, a clumsy demonstration of the old thing would put itself in its place. One that
    /// is displaced by less is an instance. Metres; infinite is never. See [`crate::primitive::Learner::displacement`].
    pub min_displacement: f64,
}

/// The decisions; [`Decisions::mended`] is `situ`, [`Decisions::literal`] the listing as printed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decisions {
    /// D1: take a primitive's own positives out of its negatives (A2.17 as printed leaves them in).
    pub subtract_own_positives: bool,
    /// D2: background negatives.
    pub background: Background,
    /// D3: give the segment's start state to the siblings as a negative, END among them, and terminal states to END's siblings.
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
            // A keyframe that a novice gives with 1 cm of noise is 6 cm from the mean at the most, that of a near-variant 8 cm.
            // The robot would have executed the child it modifies (0.3 is the quick protocol's confidence), and a shape that changes by
            // 12 cm is further away than the 8 cm of a near-variant: distances of 17 to 34 in sort_blocks/high_bins.
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
