//! The recursions of a left-to-right model, in plain numbers: every state stays, goes to the next, or past it.

use super::super::Hmm;
use super::exp;

/// The farthest that a state goes on: past the next one.
const REACH: usize = 2;
/// A scaled likelihood from here on is right to the last digits, and so are its posteriors from 10⁻⁴⁰ on.
const LEAST: f64 = 1e-250;

/// A chain, and the variables of the recursions over one sequence.
pub(super) struct LeftToRightChain {
    /// Whether it is one: no state goes back or farther.
    holds: bool,
    initial: Vec<f64>,
    end: Vec<f64>,
    /// Probabilities into each state: from two before it, from the one before it, and of staying; 3 × K.
    into: [Vec<f64>; REACH + 1],
    /// Probabilities out of each state: of staying, to the next, and past it; 3 × K.
    out: [Vec<f64>; REACH + 1],
    /// Scaled densities of the sequence, T × K.
    densities: Vec<f64>,
    /// Forward variables, T × (2 + K): before the first state come two that are always 0.
    forward: Vec<f64>,
    /// b β of the frame after, K + 2: after the last state come two that are always 0.
    after: Vec<f64>,
    /// β of a frame, and the forward variables as shares of the likelihood; K each.
    now: Vec<f64>,
    reached: Vec<f64>,
    /// Expected transitions of the sequence, as `out`.
    counts: [Vec<f64>; REACH + 1],
    frames: usize,
    likelihood: f64,
}

impl LeftToRightChain {
    pub(super) fn new(frames: usize, states: usize) -> Self {
        let row = || vec![0.0; states];
        let band = || [row(), row(), row()];
        Self {
            holds: false,
            initial: row(),
            end: row(),
            into: band(),
            out: band(),
            densities: vec![0.0; frames * states],
            forward: vec![0.0; frames * (REACH + states)],
            after: vec![0.0; states + REACH],
            now: row(),
            reached: row(),
            counts: band(),
            frames: 0,
            likelihood: 0.0,
        }
    }

    pub(super) fn set<E>(&mut self, hmm: &Hmm<E>) {
        let k = hmm.states();
        let probabilities = hmm.transition.iter().enumerate();
        self.holds = probabilities
            .filter(|(_, probability)| **probability > 0.0)
            .all(|(at, _)| (at / k..=at / k + REACH).contains(&(at % k)));
        self.initial.copy_from_slice(&hmm.initial);
        self.end.copy_from_slice(&hmm.end);
        for ahead in 0..=REACH {
            for state in 0..k {
                let to = state + ahead;
                self.out[ahead][state] = if to < k { hmm.transition[state * k + to] } else { 0.0 };
                self.into[REACH - ahead][state] =
                    state.checked_sub(ahead).map_or(0.0, |from| hmm.transition[from * k + state]);
            }
        }
    }

    /// The log likelihood of a sequence by the log densities of its frames, T × K. None where it cannot be told in plain
    /// numbers, or the chain is not left-to-right.
    pub(super) fn forward(&mut self, log_densities: &[f64]) -> Option<f64> {
        if !self.holds {
            return None;
        }
        let k = self.initial.len();
        self.frames = log_densities.len() / k;
        let mut log_scale = 0.0;
        for (logs, densities) in log_densities.chunks_exact(k).zip(self.densities.chunks_exact_mut(k)) {
            let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            log_scale += greatest;
            for (density, log) in densities.iter_mut().zip(logs) {
                *density = exp(log - greatest);
            }
        }
        let width = REACH + k;
        for (state, value) in self.forward[REACH..width].iter_mut().enumerate() {
            *value = self.initial[state] * self.densities[state];
        }
        let [past, step, stay] = self.into.each_ref().map(|row| &row[..k]);
        for frame in 1..self.frames {
            let (before, next) = self.forward[(frame - 1) * width..(frame + 1) * width].split_at_mut(width);
            let (two, one, same) = (&before[..k], &before[1..][..k], &before[2..][..k]);
            let (next, densities) = (&mut next[REACH..][..k], &self.densities[frame * k..][..k]);
            for state in 0..k {
                let sum = two[state] * past[state] + one[state] * step[state] + same[state] * stay[state];
                next[state] = sum * densities[state];
            }
        }
        let last = &self.forward[(self.frames - 1) * width + REACH..self.frames * width];
        self.likelihood = last.iter().zip(&self.end).map(|(forward, end)| forward * end).sum();
        // A frame that no state can emit makes the scale −∞, and the sum no number.
        (self.likelihood >= LEAST && log_scale.is_finite()).then(|| libm::log(self.likelihood) + log_scale)
    }

    /// The posteriors of the sequence that [`LeftToRightChain::forward`] went through: fills `occupancy` (T × K) and adds to
    /// `transitions` (K × K).
    pub(super) fn backward(&mut self, occupancy: &mut [f64], transitions: &mut [f64]) {
        let k = self.initial.len();
        let width = REACH + k;
        let share = 1.0 / self.likelihood;
        let [stay, step, past] = self.out.each_ref().map(|row| &row[..k]);
        let [stays, steps, passes] = self.counts.each_mut().map(|row| {
            row.fill(0.0);
            &mut row[..k]
        });
        let (now, reached) = (&mut self.now[..k], &mut self.reached[..k]);
        now.copy_from_slice(&self.end);
        for frame in (0..self.frames).rev() {
            for (reached, forward) in reached.iter_mut().zip(&self.forward[frame * width + REACH..][..k]) {
                *reached = forward * share;
            }
            if frame + 1 < self.frames {
                let (same, one, two) = (&self.after[..k], &self.after[1..][..k], &self.after[2..][..k]);
                for state in 0..k {
                    let ways = [stay[state] * same[state], step[state] * one[state], past[state] * two[state]];
                    stays[state] += reached[state] * ways[0];
                    steps[state] += reached[state] * ways[1];
                    passes[state] += reached[state] * ways[2];
                    now[state] = ways[0] + ways[1] + ways[2];
                }
            }
            let (cells, densities) = (&mut occupancy[frame * k..][..k], &self.densities[frame * k..][..k]);
            let after = &mut self.after[..k];
            for state in 0..k {
                cells[state] = reached[state] * now[state];
                after[state] = now[state] * densities[state];
            }
        }
        for (ahead, counts) in self.counts.iter().enumerate() {
            for (state, count) in counts[..k.saturating_sub(ahead)].iter().enumerate() {
                transitions[state * k + state + ahead] += count;
            }
        }
    }
}
