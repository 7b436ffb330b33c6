//! How the sampler moves.

/// How the sampler moves. None of this changes the distribution that it samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moves {
    /// The birth or death moves per sequence and sweep.
    pub births: usize,
    /// The shortest and the longest window of a data-driven birth, frames. Both are cut to the length of the sequence.
    pub window: (usize, usize),
    /// The split–merge moves per sweep.
    pub split_merges: usize,
    /// The random-walk moves of each of α, κ and c per sweep.
    pub inner: usize,
}

impl Default for Moves {
    /// Windows of 15 to 100 frames, 5 split–merge trials and 20 inner iterations are from Fox and Hughes. Ten births or
    /// deaths are our choice: a recording has many short behaviours, and with three a chain of 300 sweeps was further
    /// from the best states.
    fn default() -> Self {
        Self { births: 10, window: (15, 100), split_merges: 5, inner: 20 }
    }
}
