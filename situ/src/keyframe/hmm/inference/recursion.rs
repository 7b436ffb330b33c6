//! The recursions over all sequences of a fit.

use super::general::{Cells, GeneralChain};
use super::left_to_right::{Batch, Chain, ForwardBackward, LEAST, Lanes, Rows, TOGETHER};
use crate::keyframe::hmm::model::Hmm;
use crate::vector::{Four, Kernel, LANES, Wide, exp, fours, widest};

/// Sequences of frames under a model of K states, and the tables of the recursions over them. All is allocated once,
/// and what only few sequences need is allocated for the first of them.
pub(in crate::keyframe::hmm) struct Recursion {
    states: usize,
    /// The frame at which each sequence starts, and at the end the number of all frames.
    starts: Vec<usize>,
    /// The log densities, which the caller fills.
    log_densities: Cells,
    /// The greatest log density of each frame.
    scales: Vec<f64>,
    chain: Chain,
    /// The sequences side by side.
    batches: Vec<Batch>,
    rows: Rows,
    /// For each frame, the place in the rows of its first state. The next state's is [`TOGETHER`] further on.
    places: Vec<usize>,
    /// For each sequence, its batch and its lane in the batch.
    lanes: Vec<(usize, usize)>,
    /// One per batch.
    likelihoods: Vec<Lanes>,
    log_likelihoods: Vec<f64>,
    /// Expected transitions, shape (K, K).
    transitions: Vec<f64>,
    /// For the sequences that need more than plain floats: allocated for the first of them.
    general: Option<GeneralChain>,
}

/// Puts sequences of these lengths side by side, the longest first. Returns the batches, and the batch and the lane of
/// each sequence.
fn side_by_side(lengths: &[usize]) -> (Vec<Batch>, Vec<(usize, usize)>) {
    let mut order: Vec<usize> = (0..lengths.len()).collect();
    order.sort_by_key(|sequence| core::cmp::Reverse(lengths[*sequence]));
    let mut lanes = vec![(0, 0); lengths.len()];
    let mut first = 0;
    let batches = order.chunks(TOGETHER).enumerate().map(|(index, members)| {
        let mut batch = Batch { first, rows: lengths[members[0]], ..Batch::default() };
        first += batch.rows;
        for (lane, sequence) in members.iter().enumerate() {
            batch.lengths[lane] = lengths[*sequence];
            lanes[*sequence] = (index, lane);
        }
        batch
    });
    (batches.collect(), lanes)
}

impl Recursion {
    /// The recursions over these sequences, each of at least one frame.
    pub(in crate::keyframe::hmm) fn new(starts: Vec<usize>, states: usize) -> Self {
        let lengths: Vec<usize> = starts.windows(2).map(|bounds| bounds[1] - bounds[0]).collect();
        let frames = starts.last().copied().unwrap_or_default();
        let (batches, lanes) = side_by_side(&lengths);
        let mut places = Vec::with_capacity(frames);
        for (length, (batch, lane)) in lengths.iter().zip(&lanes) {
            let first = batches[*batch].first;
            places.extend((first..first + length).map(|row| row * states * TOGETHER + lane));
        }
        let rows = batches.last().map_or(0, |batch| batch.first + batch.rows);
        Self {
            states,
            log_densities: Cells::new(frames, states),
            scales: vec![0.0; frames.next_multiple_of(LANES)],
            chain: Chain::new(states),
            rows: Rows::new(rows, states),
            likelihoods: vec![[0.0; TOGETHER]; batches.len()],
            log_likelihoods: vec![0.0; lengths.len()],
            transitions: vec![0.0; states * states],
            general: None,
            batches,
            places,
            lanes,
            starts,
        }
    }

    /// The log densities, which must be filled before each recursion.
    pub(in crate::keyframe::hmm) fn log_densities_mut(&mut self) -> &mut Cells {
        &mut self.log_densities
    }

    /// The frame at which each sequence starts, and at the end the number of all frames.
    pub(in crate::keyframe::hmm) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The probability of a state at a frame.
    pub(in crate::keyframe::hmm) fn occupancy(&self, frame: usize, state: usize) -> f64 {
        self.rows.occupancy.as_flattened()[self.places[frame] + TOGETHER * state]
    }

    /// The probability of a state at a frame, to be set.
    pub(in crate::keyframe::hmm) fn occupancy_mut(&mut self, frame: usize, state: usize) -> &mut f64 {
        &mut self.rows.occupancy.as_flattened_mut()[self.places[frame] + TOGETHER * state]
    }

    /// Writes the share of a state in each frame into a column.
    pub(in crate::keyframe::hmm) fn occupancy_of(&self, state: usize, column: &mut [f64]) {
        let occupancy = &self.rows.occupancy.as_flattened()[TOGETHER * state..];
        for (share, place) in column.iter_mut().zip(&self.places) {
            *share = occupancy[*place];
        }
    }

    /// Expected transitions, shape (K, K).
    pub(in crate::keyframe::hmm) fn transitions(&self) -> &[f64] {
        &self.transitions
    }

    /// The expected transitions, to be set.
    pub(in crate::keyframe::hmm) fn transitions_mut(&mut self) -> &mut [f64] {
        &mut self.transitions
    }

    /// The log likelihood of each sequence, from the log densities.
    pub(in crate::keyframe::hmm) fn forward<E>(&mut self, hmm: &Hmm<E>) -> &[f64] {
        self.go::<E, false>(hmm)
    }

    /// The same, and the posteriors. A sequence with a log likelihood of −∞ has no posterior and is left out of the
    /// counts.
    pub(in crate::keyframe::hmm) fn expect<E>(&mut self, hmm: &Hmm<E>) -> &[f64] {
        self.transitions.fill(0.0);
        self.go::<E, true>(hmm)
    }

    fn go<E, const BACK: bool>(&mut self, hmm: &Hmm<E>) -> &[f64] {
        if self.lanes.is_empty() {
            return &[];
        }
        let k = self.states;
        let is_plain = self.chain.set(hmm);
        if is_plain {
            widest(Scale {
                log_densities: &self.log_densities.columns,
                scales: &mut self.scales,
                densities: self.rows.densities.as_flattened_mut(),
                places: &self.places,
            });
            let (batches, rows, likelihoods) = (&self.batches[..], &mut self.rows, &mut self.likelihoods[..]);
            widest(ForwardBackward::<BACK> { chain: &self.chain, batches, rows, likelihoods });
            if BACK {
                for (state, counts) in self.rows.counts.iter().enumerate() {
                    for (ahead, count) in counts[..(k - state).min(counts.len())].iter().enumerate() {
                        self.transitions[state * k + state + ahead] += count.iter().sum::<f64>();
                    }
                }
            }
        }
        let mut is_set = false;
        for (sequence, (batch, lane)) in self.lanes.iter().enumerate() {
            let frames = self.starts[sequence]..self.starts[sequence + 1];
            let likelihood = self.likelihoods[*batch][*lane];
            self.log_likelihoods[sequence] = if is_plain && likelihood >= LEAST {
                libm::log(likelihood) + self.scales[frames].iter().sum::<f64>()
            } else {
                let general = self.general.get_or_insert_with(|| new_general(&self.starts, k));
                if !is_set {
                    general.set(hmm);
                    is_set = true;
                }
                let log_likelihood = general.forward(&self.log_densities, frames.clone());
                if BACK && log_likelihood > f64::NEG_INFINITY {
                    let occupancy = self.rows.occupancy.as_flattened_mut();
                    let places = &self.places[frames];
                    general.backward(&mut self.transitions, |frame, state, share| {
                        occupancy[places[frame] + TOGETHER * state] = share;
                    });
                }
                log_likelihood
            };
        }
        &self.log_likelihoods
    }
}

fn new_general(starts: &[usize], states: usize) -> GeneralChain {
    let longest = starts.windows(2).map(|bounds| bounds[1] - bounds[0]).max();
    GeneralChain::new(longest.unwrap_or_default(), states)
}

/// Finds the greatest log density of each frame, and writes the densities over it to their places.
struct Scale<'a> {
    log_densities: &'a [f64],
    scales: &'a mut [f64],
    densities: &'a mut [f64],
    places: &'a [usize],
}

impl Kernel for Scale<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Wide>(self, simd: S) {
        let columns = self.log_densities.chunks_exact(self.scales.len());
        let scales = self.scales.as_chunks_mut::<LANES>().0;
        // If no state can emit a frame, all its scaled densities are 0.
        scales.fill([f64::MIN; LANES]);
        for column in columns.clone() {
            for (scale, logs) in scales.iter_mut().zip(fours(column)) {
                *scale = Four::new(simd, *logs).max(Four::new(simd, *scale)).numbers();
            }
        }
        for (state, column) in columns.enumerate() {
            let rows = &mut self.densities[TOGETHER * state..];
            for ((logs, scales), places) in fours(column).iter().zip(&*scales).zip(self.places.chunks(LANES)) {
                let densities = exp(simd, Four::new(simd, *logs) - Four::new(simd, *scales)).numbers();
                for (place, density) in places.iter().zip(densities) {
                    rows[*place] = density;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Where plain floats are enough, they give what wide numbers give. Where states are far apart, they are not
    /// enough.
    #[test]
    fn both_ways_to_go_through_a_sequence_agree() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut plain, mut wide) = (0, 0);
        for case in 0..600 {
            let k = 1 + case % 13;
            let mut draw = || rng.random::<f64>();
            let mut transition = vec![0.0; k * k];
            let mut end = vec![0.0; k];
            for state in 0..k {
                let row = &mut transition[state * k + state..state * k + k.min(state + 3)];
                row.iter_mut().for_each(|way| *way = 1e-3 + draw());
                end[state] = 1e-3 + draw();
                let total = row.iter().sum::<f64>() + end[state];
                row.iter_mut().for_each(|way| *way /= total);
                end[state] /= total;
            }
            let hmm = Hmm { initial: vec![1.0 / k as f64; k], transition, end, emissions: vec![(); k] };
            let mut starts = vec![0];
            (0..1 + case % 6).for_each(|sequence| starts.push(starts[sequence] + 1 + (case / 7 + 5 * sequence) % 23));
            let mut recursion = Recursion::new(starts.clone(), k);
            let spread = [1.0, 30.0, 1000.0][case / 2 % 3];
            recursion.log_densities_mut().columns.iter_mut().for_each(|log| *log = -spread * draw());
            let found = recursion.expect(&hmm).to_vec();
            *(if recursion.general.is_some() { &mut wide } else { &mut plain }) += 1;
            let mut general = new_general(&starts, k);
            general.set(&hmm);
            let mut transitions = vec![0.0; k * k];
            for (bounds, found) in starts.windows(2).zip(found) {
                let frames = bounds[0]..bounds[1];
                let expected = general.forward(&recursion.log_densities, frames.clone());
                assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{case}: {found} for {expected}");
                general.backward(&mut transitions, |frame, state, expected| {
                    near(case, recursion.occupancy(frames.start + frame, state), expected);
                });
            }
            recursion
                .transitions()
                .iter()
                .zip(&transitions)
                .for_each(|(found, expected)| near(case, *found, *expected));
        }
        assert!(plain > 300 && wide > 20, "{plain} in plain numbers, {wide} not");
    }

    fn near(case: usize, found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-11 * (1e-30 + expected), "{case}: {found} for {expected}");
    }
}
