//! The recursions of a chain of any topology, in numbers of any magnitude.

use core::ops::Range;

use super::wide::Wide;
use crate::keyframe::hmm::model::Hmm;
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

/// A chain, and the variables of the recursions over one sequence.
pub(super) struct GeneralChain {
    initial: Vec<Wide>,
    end: Vec<Wide>,
    /// Probability of state j after state i at `i * K + j`.
    transition: Vec<Wide>,
    /// For each state, the range that holds its successors.
    successors: Vec<Range<usize>>,
    /// Densities of the sequence and forward variables, T × K.
    densities: Vec<Wide>,
    forward: Vec<Wide>,
    /// b β of the frame after, and β of this one; shape (K) each.
    after: Vec<Wide>,
    now: Vec<Wide>,
    frames: usize,
    likelihood: Wide,
}

impl GeneralChain {
    pub(super) fn new(frames: usize, states: usize) -> Self {
        let zeros = |count| vec![Wide::ZERO; count];
        Self {
            initial: zeros(states),
            end: zeros(states),
            transition: zeros(states * states),
            successors: vec![0..0; states],
            densities: zeros(frames * states),
            forward: zeros(frames * states),
            after: zeros(states),
            now: zeros(states),
            frames: 0,
            likelihood: Wide::ZERO,
        }
    }

    pub(super) fn set<E>(&mut self, hmm: &Hmm<E>) {
        let copy = |wide: &mut [Wide], plain: &[f64]| {
            wide.iter_mut().zip(plain).for_each(|(wide, plain)| *wide = Wide::new(*plain));
        };
        copy(&mut self.initial, &hmm.initial);
        copy(&mut self.end, &hmm.end);
        copy(&mut self.transition, &hmm.transition);
        for (range, row) in self.successors.iter_mut().zip(hmm.transition.chunks_exact(hmm.states())) {
            let is_open = |probability: &f64| *probability > 0.0;
            let first = row.iter().position(is_open).unwrap_or_default();
            *range = first..row.iter().rposition(is_open).map_or(first, |last| last + 1);
        }
    }

    /// The log likelihood of a sequence, from the log densities of its frames.
    pub(super) fn forward(&mut self, log_densities: &Cells, frames: Range<usize>) -> f64 {
        let k = self.initial.len();
        self.frames = frames.len();
        for (frame, densities) in frames.zip(self.densities.chunks_exact_mut(k)) {
            for (state, density) in densities.iter_mut().enumerate() {
                *density = Wide::exp(log_densities.at(state, frame));
            }
        }
        for (state, value) in self.forward[..k].iter_mut().enumerate() {
            *value = self.initial[state].times(self.densities[state]);
        }
        for frame in 1..self.frames {
            let (past, next) = self.forward.split_at_mut(frame * k);
            let (now, next) = (&past[(frame - 1) * k..], &mut next[..k]);
            next.fill(Wide::ZERO);
            for (state, range) in self.successors.iter().enumerate() {
                for to in range.clone() {
                    next[to] = next[to].plus(now[state].times_unnormalised(self.transition[state * k + to]));
                }
            }
            for (value, density) in next.iter_mut().zip(&self.densities[frame * k..]) {
                *value = value.normalised().times(*density);
            }
        }
        let last = self.forward[(self.frames - 1) * k..].iter().zip(&self.end);
        let sum = last.fold(Wide::ZERO, |sum, (forward, end)| sum.plus(forward.times_unnormalised(*end)));
        self.likelihood = sum.normalised();
        self.likelihood.log()
    }

    /// The posteriors of the sequence of the last [`GeneralChain::forward`], whose likelihood must not be 0. Calls
    /// `occupies(frame, state, share)` with the share of each state in each frame, and adds to `transitions`, shape (K,
    /// K).
    pub(super) fn backward(&mut self, transitions: &mut [f64], mut occupies: impl FnMut(usize, usize, f64)) {
        let k = self.initial.len();
        let share = self.likelihood.inverse();
        self.now.copy_from_slice(&self.end);
        for frame in (0..self.frames).rev() {
            for state in 0..k {
                let reached = self.forward[frame * k + state].times(share);
                if frame + 1 < self.frames {
                    let mut sum = Wide::ZERO;
                    for to in self.successors[state].clone() {
                        let way = self.after[to].times_unnormalised(self.transition[state * k + to]);
                        transitions[state * k + to] += reached.times_unnormalised(way).value();
                        sum = sum.plus(way);
                    }
                    self.now[state] = sum.normalised();
                }
                occupies(frame, state, reached.times_unnormalised(self.now[state]).value());
            }
            for (state, density) in self.densities[frame * k..(frame + 1) * k].iter().enumerate() {
                self.after[state] = self.now[state].times(*density);
            }
        }
    }
}
