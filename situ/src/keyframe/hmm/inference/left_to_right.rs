//! The recursions of a left-to-right model, in plain floats, over several sequences at once. Every state can stay, go
//! to the next state, or skip it.

use crate::keyframe::hmm::model::Hmm;
use crate::vector::{Four, Kernel, LANES, Wide};

/// How many states ahead a state can go: it can skip one.
const REACH: usize = 2;
/// The number of sequences in a batch.
pub(super) const TOGETHER: usize = LANES;
/// From this scaled likelihood on, the likelihood is right to the last digits, and so are posteriors from 10⁻⁴⁰ on.
pub(super) const LEAST: f64 = 1e-250;

/// One number for each sequence of a batch.
pub(super) type Lanes = [f64; TOGETHER];

/// The chain of a left-to-right model of K states.
pub(super) struct Chain {
    initial: Vec<f64>,
    end: Vec<f64>,
    /// The probabilities into each state: from the state two before it, from the one before it, and of staying.
    into: Vec<[f64; REACH + 1]>,
    /// The probabilities out of each state: of staying, of going to the next, and of skipping it.
    out: Vec<[f64; REACH + 1]>,
}

impl Chain {
    pub(super) fn new(states: usize) -> Self {
        Self {
            initial: vec![0.0; states],
            end: vec![0.0; states],
            into: vec![[0.0; REACH + 1]; states],
            out: vec![[0.0; REACH + 1]; states],
        }
    }

    /// Takes over the chain of a model with as many states. False if that chain is not left-to-right: a state goes
    /// back, or more than two ahead.
    pub(super) fn set<E>(&mut self, hmm: &Hmm<E>) -> bool {
        let k = hmm.states();
        self.initial.copy_from_slice(&hmm.initial);
        self.end.copy_from_slice(&hmm.end);
        for ahead in 0..=REACH {
            for state in 0..k {
                let to = state + ahead;
                self.out[state][ahead] = if to < k { hmm.transition[state * k + to] } else { 0.0 };
                self.into[state][REACH - ahead] =
                    state.checked_sub(ahead).map_or(0.0, |from| hmm.transition[from * k + state]);
            }
        }
        let mut probabilities = hmm.transition.iter().enumerate();
        probabilities.all(|(at, probability)| *probability == 0.0 || (at / k..=at / k + REACH).contains(&(at % k)))
    }
}

/// Up to [`TOGETHER`] sequences, side by side from their first frames on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Batch {
    /// The frames of each sequence; 0 if a lane has no sequence.
    pub(super) lengths: [usize; TOGETHER],
    /// The first row, and the number of rows: the frames of the longest sequence.
    pub(super) first: usize,
    pub(super) rows: usize,
}

/// The expected numbers of transitions out of a state: of stays, of steps to the next, and of skips. The sum over the
/// lanes is the count.
pub(super) type Counts = [Lanes; REACH + 1];

/// The tables of the recursions over batches: one row per frame, and in it one cell per state.
pub(super) struct Rows {
    /// The densities over the greatest of the frame, shape (rows, K); 0 where a sequence has no frame.
    pub(super) densities: Vec<Lanes>,
    /// The forward variables, shape (rows, 2 + K). Before the first state there are two cells that are always 0.
    forward: Vec<Lanes>,
    /// The posteriors, shape (rows, K).
    pub(super) occupancy: Vec<Lanes>,
    /// b β of the frame after, shape (K + 2). After the last state there are two cells that are always 0.
    after: Vec<Lanes>,
    /// Shape (K).
    pub(super) counts: Vec<Counts>,
}

impl Rows {
    pub(super) fn new(rows: usize, states: usize) -> Self {
        let cells = |count| vec![[0.0; TOGETHER]; count];
        Self {
            densities: cells(rows * states),
            forward: cells(rows * (REACH + states)),
            occupancy: cells(rows * states),
            after: cells(states + REACH),
            counts: vec![[[0.0; TOGETHER]; REACH + 1]; states],
        }
    }
}

/// Computes the scaled likelihood of every sequence. With `BACK` it also computes the posteriors and the expected
/// transitions of the sequences for which plain floats are enough.
pub(super) struct ForwardBackward<'a, const BACK: bool> {
    pub(super) chain: &'a Chain,
    pub(super) batches: &'a [Batch],
    pub(super) rows: &'a mut Rows,
    /// One per batch.
    pub(super) likelihoods: &'a mut [Lanes],
}

impl<const BACK: bool> Kernel for ForwardBackward<'_, BACK> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        self.rows.counts.fill([[0.0; TOGETHER]; REACH + 1]);
        for (batch, likelihoods) in self.batches.iter().zip(self.likelihoods) {
            *likelihoods = self.chain.forward(simd, batch, self.rows);
            if BACK {
                self.chain.backward(simd, batch, likelihoods, self.rows);
            }
        }
    }
}

impl Chain {
    /// Computes the forward variables of a batch; returns the scaled likelihoods.
    #[inline(always)]
    fn forward<S: Wide>(&self, simd: S, batch: &Batch, rows: &mut Rows) -> Lanes {
        let k = self.initial.len();
        let width = REACH + k;
        let mut likelihoods = [0.0; TOGETHER];
        let densities = rows.densities[batch.first * k..].chunks_exact(k);
        let forward = &mut rows.forward[batch.first * width..(batch.first + batch.rows) * width];
        for (row, densities) in densities.take(batch.rows).enumerate() {
            let (before, now) = forward.split_at_mut(row * width);
            let now = &mut now[REACH..width];
            if let Some(before) = before.rchunks_exact(width).next() {
                let cells = now.iter_mut().zip(densities).zip(before.windows(REACH + 1)).zip(&self.into);
                for (((now, density), before), into) in cells {
                    let two = Four::new(simd, before[0]) * into[0];
                    let one = Four::new(simd, before[1]) * into[1];
                    let same = Four::new(simd, before[2]) * into[2];
                    *now = ((two + one + same) * Four::new(simd, *density)).numbers();
                }
            } else {
                for ((now, density), initial) in now.iter_mut().zip(densities).zip(&self.initial) {
                    *now = (Four::new(simd, *density) * *initial).numbers();
                }
            }
            for lane in (0..TOGETHER).filter(|lane| batch.lengths[*lane] == row + 1) {
                likelihoods[lane] = now.iter().zip(&self.end).map(|(now, end)| now[lane] * end).sum();
            }
        }
        likelihoods
    }

    /// Computes the posteriors of a batch from its forward variables, and adds its transitions to the counts.
    #[inline(always)]
    fn backward<S: Wide>(&self, simd: S, batch: &Batch, likelihoods: &Lanes, rows: &mut Rows) {
        let k = self.initial.len();
        let width = REACH + k;
        let inverse = |likelihood: f64| if likelihood >= LEAST { 1.0 / likelihood } else { 0.0 };
        let share = Four::new(simd, likelihoods.map(inverse));
        rows.after.fill([0.0; TOGETHER]);
        for row in (batch.first..batch.first + batch.rows).rev() {
            let ends = |length| if batch.first + length == row + 1 { 1.0 } else { 0.0 };
            let last = Four::new(simd, batch.lengths.map(ends));
            let densities = &rows.densities[row * k..][..k];
            let forward = &rows.forward[row * width + REACH..][..k];
            let occupancy = &mut rows.occupancy[row * k..][..k];
            let after = &mut rows.after[..width];
            let counts = &mut rows.counts[..k];
            let (out, end) = (&self.out[..k], &self.end[..k]);
            for state in 0..k {
                let reached = Four::new(simd, forward[state]) * share;
                let stay = Four::new(simd, after[state]) * out[state][0];
                let step = Four::new(simd, after[state + 1]) * out[state][1];
                let past = Four::new(simd, after[state + 2]) * out[state][2];
                for (count, way) in counts[state].iter_mut().zip([stay, step, past]) {
                    *count = (Four::new(simd, *count) + reached * way).numbers();
                }
                let beta = stay + step + past + last * end[state];
                occupancy[state] = (reached * beta).numbers();
                after[state] = (beta * Four::new(simd, densities[state])).numbers();
            }
        }
    }
}
