//! One chain: what it sees, its priors and moves, its state, and the probability of the state.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::SVector;
use rand::Rng;
use serde::Serialize;

use super::dynamics::{Dynamics, DynamicsPrior, Statistics};
use super::weights::{Weights, prior_shape};

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

/// A gamma prior with the mean `shape` / `rate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaPrior {
    /// Above 0.
    pub shape: f64,
    /// Above 0.
    pub rate: f64,
}

/// The priors of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior<const D: usize> {
    /// That of the dynamics.
    pub dynamics: DynamicsPrior<D>,
    /// That of α, the weight of every transition.
    pub alpha: GammaPrior,
    /// That of κ, the additional weight of a self-transition.
    pub kappa: GammaPrior,
    /// That of γ, the mass of the beta process.
    pub gamma: GammaPrior,
    /// That of c, the concentration of the beta process.
    pub c: GammaPrior,
}

/// The frames of one sequence, at least one, each with the frame before it.
#[derive(Clone, Debug, PartialEq)]
pub struct LaggedSequence<const D: usize> {
    /// x_t.
    pub current: Vec<SVector<f64, D>>,
    /// y_t, one per x_t.
    pub lagged: Vec<SVector<f64, D>>,
}

impl<const D: usize> LaggedSequence<D> {
    /// The number of frames.
    pub fn len(&self) -> usize {
        self.current.len()
    }

    /// Whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.current.is_empty()
    }

    /// The statistics of the frames for which `belongs` holds.
    pub(super) fn statistics(&self, belongs: impl Fn(usize) -> bool) -> Statistics<D> {
        let mut statistics = Statistics::default();
        for frame in (0..self.len()).filter(|frame| belongs(*frame)) {
            statistics.add(&self.current[frame], &self.lagged[frame], 1.0);
        }
        statistics
    }
}

/// The state of one sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SequenceState {
    /// f_i: the names of the sequence's behaviours; at least one, each once.
    pub active: Vec<usize>,
    /// η, in the order of `active`.
    pub weights: Weights,
    /// z: the name of the behaviour of each frame.
    pub states: Vec<usize>,
}

/// Everything that is sampled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChainState<const D: usize> {
    /// θ by the name of the behaviour. It has exactly the behaviours that some sequence has.
    pub dynamics: BTreeMap<usize, Dynamics<D>>,
    /// One per sequence.
    pub rows: Vec<SequenceState>,
    /// α.
    pub alpha: f64,
    /// κ.
    pub kappa: f64,
    /// γ.
    pub gamma: f64,
    /// c.
    pub c: f64,
}

/// A Markov chain, whose stationary distribution is the posterior of [`ChainState`] given the sequences.
#[derive(Clone, Debug)]
pub struct Chain<const D: usize> {
    pub(super) prior: Prior<D>,
    pub(super) moves: Moves,
    pub(super) sequences: Vec<LaggedSequence<D>>,
    pub(super) state: ChainState<D>,
    /// A name that no behaviour has had so far.
    pub(super) fresh: usize,
}

/// α, κ, γ and c at the start of a chain (Fox et al. 2014).
const START: [f64; 4] = [1.0, 25.0, 5.0, 1.0];

impl<const D: usize> Chain<D> {
    /// A chain that starts with `unique` behaviours per sequence, none of them shared. Each has an equal part of the
    /// sequence's frames. `None` if a sequence has no frame, or if the numbers are too extreme for a posterior.
    pub fn new(
        prior: Prior<D>,
        moves: Moves,
        sequences: Vec<LaggedSequence<D>>,
        unique: usize,
        rng: &mut impl Rng,
    ) -> Option<Self> {
        if sequences.iter().any(LaggedSequence::is_empty) {
            return None;
        }
        let [alpha, kappa, gamma, c] = START;
        let mut rows = Vec::with_capacity(sequences.len());
        let mut fresh = 0;
        for sequence in &sequences {
            let parts = unique.clamp(1, sequence.len());
            let states = (0..sequence.len()).map(|frame| fresh + frame * parts / sequence.len()).collect();
            let weights = Weights::from_prior(parts, alpha, kappa, rng);
            rows.push(SequenceState { active: (fresh..fresh + parts).collect(), weights, states });
            fresh += parts;
        }
        let state = ChainState { dynamics: BTreeMap::new(), rows, alpha, kappa, gamma, c };
        let mut chain = Self { prior, moves, sequences, state, fresh };
        chain.draw_weights(rng);
        chain.draw_dynamics(rng)?;
        Some(chain)
    }

    /// A chain in a given state, for tests of the sampler. The state must fit the sequences: one row per sequence, with
    /// one state per frame, and all of these states active and with dynamics.
    pub fn at(prior: Prior<D>, moves: Moves, sequences: Vec<LaggedSequence<D>>, state: ChainState<D>) -> Self {
        let fresh = state.dynamics.keys().last().map_or(0, |name| name + 1);
        Self { prior, moves, sequences, state, fresh }
    }

    /// The state.
    pub fn state(&self) -> &ChainState<D> {
        &self.state
    }

    /// The sequences.
    pub fn sequences(&self) -> &[LaggedSequence<D>] {
        &self.sequences
    }

    /// Sets other frames for the same state, as many in each sequence. For tests of the sampler.
    pub fn observe(&mut self, sequences: Vec<LaggedSequence<D>>) {
        self.sequences = sequences;
    }

    /// Draws η of every sequence given z.
    /// One sweep: features and states of each sequence, split–merge moves, transitions, dynamics, α and κ, γ and c.
    /// `None` if rounding leaves a matrix that is not positive definite.
    pub fn sweep(&mut self, rng: &mut impl Rng) -> Option<()> {
        for index in 0..self.sequences.len() {
            self.update_sequence(index, rng)?;
        }
        for _ in 0..self.moves.split_merges {
            self.split_or_merge(rng)?;
        }
        // Split and merge integrate η and θ out, so all of them are drawn anew before they are used.
        self.draw_weights(rng);
        self.draw_dynamics(rng)?;
        self.update_stickiness(rng);
        self.update_beta_process(rng);
        Some(())
    }

    pub(super) fn draw_weights(&mut self, rng: &mut impl Rng) {
        let (alpha, kappa) = (self.state.alpha, self.state.kappa);
        for row in &mut self.state.rows {
            let counts = transitions(&row.active, &row.states);
            row.weights = Weights::given(&counts, row.active.len(), alpha, kappa, rng);
        }
    }

    /// Draws θ of every behaviour given z.
    pub(super) fn draw_dynamics(&mut self, rng: &mut impl Rng) -> Option<()> {
        let mut statistics = self.statistics();
        let names: BTreeSet<usize> = self.state.rows.iter().flat_map(|row| row.active.iter().copied()).collect();
        self.state.dynamics.clear();
        for name in names {
            let own = statistics.remove(&name).unwrap_or_default();
            self.state.dynamics.insert(name, self.prior.dynamics.posterior(&own)?.draw(rng)?);
        }
        Some(())
    }

    /// The statistics of the frames of each behaviour. A behaviour without frames has no entry.
    fn statistics(&self) -> BTreeMap<usize, Statistics<D>> {
        let mut statistics: BTreeMap<usize, Statistics<D>> = BTreeMap::new();
        for (sequence, row) in self.sequences.iter().zip(&self.state.rows) {
            for (frame, name) in row.states.iter().enumerate() {
                statistics.entry(*name).or_default().add(&sequence.current[frame], &sequence.lagged[frame], 1.0);
            }
        }
        statistics
    }

    /// log p(X, z, F | α, κ, γ, c), with η and θ integrated out. The state with the greatest is kept. `None` if
    /// rounding leaves a matrix that is not positive definite.
    pub fn log_joint(&self) -> Option<f64> {
        let state = &self.state;
        let mut owners: BTreeMap<usize, usize> = BTreeMap::new();
        state.rows.iter().flat_map(|row| &row.active).for_each(|name| *owners.entry(*name).or_default() += 1);
        let mut total = -state.gamma * self.harmonic(state.c);
        for count in owners.values() {
            total += self.log_column(*count);
        }
        for row in &state.rows {
            total += log_states(&row.active, &row.states, state.alpha, state.kappa);
        }
        for statistics in self.statistics().values() {
            total += self.prior.dynamics.log_evidence(statistics)?;
        }
        Some(total)
    }

    /// log of γ c B(m, N − m + c): what a behaviour of m sequences contributes to the density of F (Griffiths and
    /// Ghahramani 2011, the two-parameter process).
    pub(super) fn log_column(&self, owners: usize) -> f64 {
        let (m, n, c) = (owners as f64, self.sequences.len() as f64, self.state.c);
        libm::log(self.state.gamma * c) + libm::lgamma(m) + libm::lgamma(n - m + c) - libm::lgamma(n + c)
    }

    /// Σ_i c / (c + i − 1) over the sequences: the expected number of behaviours per unit of γ.
    pub(super) fn harmonic(&self, c: f64) -> f64 {
        (0..self.sequences.len()).map(|index| c / (c + index as f64)).sum()
    }
}

/// The numbers of transitions, from and to, in the order of `active`, row by row.
fn transitions(active: &[usize], states: &[usize]) -> Vec<f64> {
    let size = active.len();
    let places: BTreeMap<usize, usize> = active.iter().enumerate().map(|(place, name)| (*name, place)).collect();
    let mut counts = vec![0.0; size * size];
    for pair in states.windows(2) {
        counts[places[&pair[0]] * size + places[&pair[1]]] += 1.0;
    }
    counts
}

/// log p(z | f, α, κ) of one sequence, with its transitions integrated out.
pub(super) fn log_states(active: &[usize], states: &[usize], alpha: f64, kappa: f64) -> f64 {
    let size = active.len();
    let whole = size as f64 * alpha + kappa;
    let mut total = -libm::log(size as f64);
    for (from, counts) in transitions(active, states).chunks(size.max(1)).enumerate() {
        let sum: f64 = counts.iter().sum();
        if sum > 0.0 {
            total += libm::lgamma(whole) - libm::lgamma(whole + sum);
        }
        for (to, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0.0) {
            let shape = prior_shape(from == to, alpha, kappa);
            total += libm::lgamma(shape + count) - libm::lgamma(shape);
        }
    }
    total
}
