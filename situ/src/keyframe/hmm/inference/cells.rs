//! A table with one number per frame and state.

use crate::vector::LANES;

/// One number per frame and state, one padded column per state.
pub(in crate::keyframe::hmm) struct Cells {
    pub(super) columns: Vec<f64>,
    length: usize,
}

impl Cells {
    pub(super) fn new(frames: usize, states: usize) -> Self {
        let length = frames.next_multiple_of(LANES);
        Self { columns: vec![0.0; length * states], length }
    }

    /// The number of a frame in a state.
    pub(super) fn at(&self, state: usize, frame: usize) -> f64 {
        self.columns[state * self.length + frame]
    }

    /// The column of a state.
    pub(in crate::keyframe::hmm) fn column_mut(&mut self, state: usize) -> &mut [f64] {
        &mut self.columns[state * self.length..(state + 1) * self.length]
    }
}
