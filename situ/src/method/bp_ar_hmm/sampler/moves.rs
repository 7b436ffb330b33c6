//! How the sampler moves.

/// How the sampler moves. None of it changes what is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moves {
    /// Birth or death moves a sequence and sweep.
    pub births: usize,
    /// The shortest and the longest window of a data-driven birth, frames; both are cut to the sequence.
    pub window: (usize, usize),
    /// Split–merge moves a sweep.
    pub split_merges: usize,
    /// Random-walk moves of each of α, κ and c a sweep.
    pub inner: usize,
}

impl Default for Moves {
    /// Windows of 15 to 100 frames, 5 split–merge trials and 20 inner iterations are Fox's and Hughes's. Ten births or
    /// deaths are ours: a recording has many short behaviours, and with three a chain of 300 sweeps was further from
    /// the best states.
    fn default() -> Self {
        Self { births: 10, window: (15, 100), split_merges: 5, inner: 20 }
    }
}
