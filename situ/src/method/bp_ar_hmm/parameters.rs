//! The method's parameters.

use super::sampler::Moves;

/// How long and how often the sampler runs, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BpArHmmParameters {
    /// Chains, of which the best is kept; at least 1.
    pub chains: u32,
    /// Sweeps of each; at least 1.
    pub sweeps: u32,
    /// Behaviours of its own that each sequence starts with (published: 2).
    pub unique_features: usize,
    /// The moves.
    pub moves: Moves,
}

impl Default for BpArHmmParameters {
    /// 3 chains of 300 sweeps: every correction pays for them anew. What longer ones would find, and cost, prints
    /// `cargo test --release -p situ --test bp_ar_hmm speed -- --ignored --nocapture`.
    fn default() -> Self {
        Self { chains: 3, sweeps: 300, unique_features: 2, moves: Moves::default() }
    }
}
