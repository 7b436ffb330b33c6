//! The method's parameters.

use super::sampler::Moves;

/// How long and how often the sampler runs, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BpArHmmParameters {
    /// The number of chains; the best state is kept. At least 1.
    pub chains: u32,
    /// The number of sweeps of each chain. At least 1.
    pub sweeps: u32,
    /// The number of behaviours of its own that each sequence starts with (published: 2).
    pub unique_features: usize,
    /// The moves.
    pub moves: Moves,
}

impl Default for BpArHmmParameters {
    /// 2 chains of 200 sweeps, for cost: every correction samples all recordings anew. The original has, as we remember
    /// Niekum et al. 2012, 10 chains of 1000 sweeps.
    fn default() -> Self {
        Self { chains: 2, sweeps: 200, unique_features: 2, moves: Moves::default() }
    }
}
