//! Split and merge: two behaviours become one, or one becomes two, in all sequences at once. η and θ are integrated out
//! (in the manner of Hughes, Fox and Sudderth 2012, with a sequential allocation after Dahl 2005).
//!
//! Two sequences are drawn, the anchors, and one behaviour of each. If both behaviours are the same, it is to be split:
//! one part is for the first anchor, the other for the second. If they differ, they are to be merged. Then the split
//! that would undo the merge is replayed, which gives its probability.

use std::collections::{BTreeMap, BTreeSet};

use rand::{Rng, RngExt};

use super::chain::{Chain, LaggedSequence, log_states};
use super::draw::{accepts, categorical};
use super::dynamics::{Dynamics, Statistics};
use super::states::{backward_sample, log_forward};

/// What a split assigns to one sequence.
#[derive(Clone)]
struct Allocation {
    /// Whether it has the first part, and whether it has the second part.
    has: [bool; 2],
    /// The states; the two parts have their names.
    states: Vec<usize>,
}

/// The combinations of the two parts that a sequence can have.
const CHOICES: [[bool; 2]; 3] = [[true, false], [false, true], [true, true]];

/// One such combination for a sequence, with its likelihood.
struct Choice {
    has: [bool; 2],
    probabilities: [f64; 4],
    filter: Vec<f64>,
    densities: [Vec<f64>; 2],
    log_likelihood: f64,
}

impl<const D: usize> Chain<D> {
    /// One move. `None` if rounding leaves a matrix that is not positive definite.
    pub(super) fn split_or_merge(&mut self, rng: &mut impl Rng) -> Option<()> {
        let n = self.sequences.len();
        if n < 2 {
            return Some(());
        }
        let first = rng.random_range(0..n);
        let second = (first + rng.random_range(1..n)) % n;
        let pick = |row: usize, rng: &mut _| {
            let active = &self.state.rows[row].active;
            active[RngExt::random_range(rng, 0..active.len())]
        };
        let chosen = [pick(first, rng), pick(second, rng)];
        let is_split = chosen[0] == chosen[1];
        let whole = if is_split { chosen[0] } else { self.fresh };
        let parts = if is_split { [self.fresh, self.fresh + 1] } else { chosen };
        self.fresh += 2;

        // The sequences concerned: the anchors, then the others in a random order.
        let concerned = |row: usize| self.state.rows[row].active.iter().any(|name| chosen.contains(name));
        let mut order = vec![first, second];
        let mut others: Vec<usize> = (0..n).filter(|row| *row != first && *row != second && concerned(*row)).collect();
        while !others.is_empty() {
            order.push(others.remove(rng.random_range(0..others.len())));
        }

        let old = self.part(&order, &chosen)?;
        let current: Option<BTreeMap<usize, Allocation>> = (!is_split).then(|| {
            let allocation = |row: &usize| {
                let own = &self.state.rows[*row];
                (*row, Allocation { has: parts.map(|part| own.active.contains(&part)), states: own.states.clone() })
            };
            order.iter().map(allocation).collect()
        });
        let (allocations, log_proposal) = self.allocate(&order, &chosen, parts, current.as_ref(), rng)?;
        let kept = self.state.rows.clone();
        let picks = |chain: &Self| -> f64 {
            [first, second].iter().map(|row| libm::log(chain.state.rows[*row].active.len() as f64)).sum()
        };
        let before = picks(self);
        for row in &order {
            let own = &mut self.state.rows[*row];
            own.active.retain(|name| !chosen.contains(name));
            if is_split {
                let Allocation { has, states } = &allocations[row];
                own.active.extend((0..2).filter(|part| has[*part]).map(|part| parts[part]));
                own.states.clone_from(states);
            } else {
                own.active.push(whole);
                own.states.iter_mut().filter(|name| parts.contains(name)).for_each(|name| *name = whole);
            }
        }
        let new = self.part(&order, if is_split { &parts } else { core::slice::from_ref(&whole) })?;
        let log_proposal = if is_split { -log_proposal } else { log_proposal };
        if !accepts(new - old + log_proposal + before - picks(self), rng) {
            self.state.rows = kept;
        }
        Some(())
    }

    /// The part of log p(X, z, F) that depends on these behaviours: their columns of F, the states of these sequences,
    /// and their frames.
    fn part(&self, rows: &[usize], names: &[usize]) -> Option<f64> {
        let names: BTreeSet<usize> = names.iter().copied().collect();
        let mut total = 0.0;
        for row in rows {
            let own = &self.state.rows[*row];
            total += log_states(&own.active, &own.states, self.state.alpha, self.state.kappa);
        }
        for name in &names {
            let owners = self.state.rows.iter().filter(|row| row.active.contains(name)).count();
            let mut statistics = Statistics::default();
            for row in rows {
                let states = &self.state.rows[*row].states;
                statistics = statistics.plus(&self.sequences[*row].statistics(|frame| states[frame] == *name));
            }
            total += self.log_column(owners) + self.prior.dynamics.log_evidence(&statistics)?;
        }
        Some(total)
    }

    /// Gives each sequence in turn its parts and states, given those of the sequences before it, and returns the log
    /// probability of that. If there is a `current` allocation, it is replayed.
    fn allocate(
        &self,
        order: &[usize],
        chosen: &[usize; 2],
        parts: [usize; 2],
        current: Option<&BTreeMap<usize, Allocation>>,
        rng: &mut impl Rng,
    ) -> Option<(BTreeMap<usize, Allocation>, f64)> {
        let open = |row: usize, frame: usize| chosen.contains(&self.state.rows[row].states[frame]);
        // Before the turn of an anchor, all its open frames count for its part.
        let anchored = |row: usize| self.sequences[row].statistics(|frame| open(row, frame));
        let provisional = [anchored(order[0]), anchored(order[1])];
        let mut settled: [Statistics<D>; 2] = Default::default();
        let mut allocations = BTreeMap::new();
        let mut log_probability = 0.0;
        for (turn, row) in order.iter().enumerate() {
            let mut dynamics = Vec::with_capacity(2);
            for part in 0..2 {
                let known = if turn <= part { settled[part].plus(&provisional[part]) } else { settled[part].clone() };
                dynamics.push(self.prior.dynamics.posterior(&known)?.at_mean()?);
            }
            let is_open: Vec<bool> = (0..self.sequences[*row].len()).map(|frame| open(*row, frame)).collect();
            let rest = self.state.rows[*row].active.iter().filter(|name| !chosen.contains(name)).count();
            let choices: Vec<Choice> = CHOICES
                .into_iter()
                .filter(|has| turn > 1 || has[turn])
                .map(|has| self.choice(&self.sequences[*row], has, rest, &is_open, &dynamics))
                .collect();
            let greatest = choices.iter().map(|choice| choice.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = choices.iter().map(|choice| libm::exp(choice.log_likelihood - greatest)).collect();
            let allocation = match current {
                Some(current) => current[row].clone(),
                None => {
                    let choice = &choices[categorical(&weights, rng)];
                    Allocation {
                        has: choice.has,
                        states: choice.draw(&self.state.rows[*row].states, &is_open, parts, rng),
                    }
                }
            };
            // No split gives an anchor without its part. That cannot occur here either, as the anchor was drawn with
            // its part.
            let taken = choices.iter().position(|choice| choice.has == allocation.has)?;
            let log_total = greatest + libm::log(weights.iter().sum());
            log_probability += choices[taken].log_path(&allocation.states, &is_open, parts) - log_total;
            for (part, known) in settled.iter_mut().enumerate() {
                let own = self.sequences[*row].statistics(|frame| allocation.states[frame] == parts[part]);
                *known = known.plus(&own);
            }
            allocations.insert(*row, allocation);
        }
        Some((allocations, log_probability))
    }

    /// The chain over the open frames of a sequence that has these parts and `rest` other behaviours. It has the
    /// prior's mean transitions and the parts' mean dynamics. Frames in between are left out: the state of a part is
    /// continued from the last open frame.
    fn choice(
        &self,
        sequence: &LaggedSequence<D>,
        has: [bool; 2],
        rest: usize,
        is_open: &[bool],
        dynamics: &[Dynamics<D>],
    ) -> Choice {
        let (alpha, kappa) = (self.state.alpha, self.state.kappa);
        let own = rest + has.iter().filter(|has| **has).count();
        let whole = own as f64 * alpha + kappa;
        let (stay, leave) = ((alpha + kappa) / whole, alpha / whole);
        let frames = (0..sequence.len()).filter(|frame| is_open[*frame]);
        let densities = [0, 1].map(|part: usize| -> Vec<f64> {
            let density = |frame: usize| {
                if has[part] {
                    dynamics[part].log_density(&sequence.current[frame], &sequence.lagged[frame])
                } else {
                    f64::NEG_INFINITY
                }
            };
            frames.clone().map(density).collect()
        });
        let probabilities = [stay, leave, leave, stay];
        let mut filter = Vec::new();
        let log_likelihood = if densities[0].is_empty() {
            0.0
        } else {
            log_forward(&[&densities[0], &densities[1]], &probabilities, &mut filter)
        };
        Choice { has, probabilities, filter, densities, log_likelihood }
    }
}

impl Choice {
    /// Draws states for the open frames; the others stay as they are.
    fn draw(&self, states: &[usize], is_open: &[bool], parts: [usize; 2], rng: &mut impl Rng) -> Vec<usize> {
        let mut drawn = backward_sample(&self.filter, &self.probabilities, 2, rng).into_iter();
        let state = |(state, open): (&usize, &bool)| {
            if *open { drawn.next().map_or(*state, |part| parts[part]) } else { *state }
        };
        states.iter().zip(is_open).map(state).collect()
    }

    /// The log of the joint weight of the open frames and these states. Divided by the likelihood, it is the
    /// probability of the draw.
    fn log_path(&self, states: &[usize], is_open: &[bool], parts: [usize; 2]) -> f64 {
        let open = states.iter().zip(is_open).filter(|(_, open)| **open);
        let mut total = 0.0;
        let mut before = None;
        for (frame, (state, _)) in open.enumerate() {
            let part = usize::from(*state == parts[1]);
            let onto = before.map_or(0.5, |before: usize| self.probabilities[before * 2 + part]);
            total += libm::log(onto) + self.densities[part][frame];
            before = Some(part);
        }
        total
    }
}
