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
    /// 2 chains of 200 sweeps, for cost: every correction pays for them anew, with all recordings. The original's are,
    /// as we remember Niekum et al. 2012, 10 chains of 1000. What those find and cost beside ours prints
    /// `cargo test --release -p situ --test bp_ar_hmm a_lesson -- --include-ignored --nocapture`.
    fn default() -> Self {
        Self { chains: 2, sweeps: 200, unique_features: 2, moves: Moves::default() }
    }
}
