//! Draws the behaviours of a sequence, with its states summed out, and then its states.

use std::collections::BTreeMap;

use rand::{Rng, RngExt};

use super::chain::Chain;
use super::draw::accepts;
use super::dynamics::{Dynamics, DynamicsPosterior, Statistics};
use super::states::{backward_sample, log_forward, log_forward_of_weights};
use super::weights::Weights;

/// The behaviours of a sequence, and the likelihood of the sequence under them.
struct Proposal {
    active: Vec<usize>,
    weights: Weights,
    log_likelihood: f64,
}

/// log p(x_t) of every frame of a sequence, by behaviour; and p(x_t) divided by a factor of each frame.
struct Densities {
    logarithms: BTreeMap<usize, Vec<f64>>,
    weights: BTreeMap<usize, Vec<f64>>,
    /// The logarithms of the factors: for each frame, the greatest of the behaviours that there were at first.
    shift: Vec<f64>,
}

impl Densities {
    fn new(logarithms: BTreeMap<usize, Vec<f64>>, frames: usize) -> Self {
        let mut shift = vec![f64::NEG_INFINITY; frames];
        for own in logarithms.values() {
            shift.iter_mut().zip(own).for_each(|(shift, own)| *shift = shift.max(*own));
        }
        let mut densities = Self { logarithms: BTreeMap::new(), weights: BTreeMap::new(), shift };
        logarithms.into_iter().for_each(|(name, own)| densities.insert(name, own));
        densities
    }

    fn insert(&mut self, name: usize, logarithms: Vec<f64>) {
        let weights = logarithms.iter().zip(&self.shift).map(|(own, shift)| libm::exp(own - shift)).collect();
        self.weights.insert(name, weights);
        self.logarithms.insert(name, logarithms);
    }

    fn remove(&mut self, name: usize) {
        self.weights.remove(&name);
        self.logarithms.remove(&name);
    }

    /// log p(x) of the sequence.
    fn log_likelihood(&self, active: &[usize], probabilities: &[f64]) -> f64 {
        let weights: Vec<&[f64]> = active.iter().map(|name| self.weights[name].as_slice()).collect();
        match log_forward_of_weights(&weights, probabilities) {
            Some(log_likelihood) => log_likelihood + self.shift.iter().sum::<f64>(),
            None => log_forward(&self.logarithms(active), probabilities, &mut Vec::new()),
        }
    }

    fn logarithms(&self, active: &[usize]) -> Vec<&[f64]> {
        active.iter().map(|name| self.logarithms[name].as_slice()).collect()
    }
}

impl Proposal {
    fn new(active: Vec<usize>, weights: Weights, densities: &Densities) -> Self {
        let log_likelihood = densities.log_likelihood(&active, &weights.probabilities());
        Self { active, weights, log_likelihood }
    }

    fn with(&self, name: usize, densities: &Densities, stickiness: (f64, f64), rng: &mut impl Rng) -> Self {
        let mut active = self.active.clone();
        active.push(name);
        Self::new(active, self.weights.grown(stickiness.0, stickiness.1, rng), densities)
    }

    fn without(&self, place: usize, densities: &Densities) -> Self {
        let mut active = self.active.clone();
        active.remove(place);
        Self::new(active, self.weights.shrunk(place), densities)
    }
}

impl<const D: usize> Chain<D> {
    /// Updates the shared behaviours, the behaviours of its own, and the states of one sequence.
    pub(super) fn update_sequence(&mut self, index: usize, rng: &mut impl Rng) -> Option<()> {
        let densities = self.state.dynamics.iter().map(|(name, own)| (*name, self.densities(index, own))).collect();
        let mut densities = Densities::new(densities, self.sequences[index].len());
        let mut others: BTreeMap<usize, usize> = BTreeMap::new();
        for (_, row) in self.state.rows.iter().enumerate().filter(|(other, _)| *other != index) {
            row.active.iter().for_each(|name| *others.entry(*name).or_default() += 1);
        }
        let row = &self.state.rows[index];
        let mut now = Proposal::new(row.active.clone(), row.weights.clone(), &densities);
        self.update_shared(&mut now, &others, &densities, rng);
        for _ in 0..self.moves.births {
            self.birth_or_death(index, &mut now, &others, &mut densities, rng)?;
        }
        let Proposal { active, weights, .. } = now;
        let (probabilities, mut filter) = (weights.probabilities(), Vec::new());
        log_forward(&densities.logarithms(&active), &probabilities, &mut filter);
        let states = backward_sample(&filter, &probabilities, active.len(), rng);
        let row = &mut self.state.rows[index];
        row.states = states.into_iter().map(|place| active[place]).collect();
        (row.active, row.weights) = (active, weights);
        Some(())
    }

    /// Metropolis–Hastings moves on each behaviour that another sequence has: it is added if this sequence does not
    /// have it, and removed if it does. The η of an added behaviour is drawn from its prior, so it cancels in the
    /// ratio.
    fn update_shared(
        &self,
        now: &mut Proposal,
        others: &BTreeMap<usize, usize>,
        densities: &Densities,
        rng: &mut impl Rng,
    ) {
        let stickiness = (self.state.alpha, self.state.kappa);
        let n = self.sequences.len() as f64;
        for (name, count) in others {
            let m = *count as f64;
            let log_odds = libm::log(m) - libm::log(n + self.state.c - 1.0 - m);
            let (proposal, log_prior) = match now.active.iter().position(|other| other == name) {
                Some(_) if now.active.len() == 1 => continue,
                Some(place) => (now.without(place, densities), -log_odds),
                None => (now.with(*name, densities, stickiness, rng), log_odds),
            };
            if accepts(proposal.log_likelihood - now.log_likelihood + log_prior, rng) {
                *now = proposal;
            }
        }
    }

    /// A reversible jump. The behaviours that only this sequence has are a Poisson process. Its intensity is
    /// γ c / (c + N − 1) times the prior of θ and η. A birth draws θ half from the prior and half from the posterior
    /// given a window of frames. The window is chosen before the choice between birth and death, so both have the same
    /// window.
    fn birth_or_death(
        &mut self,
        index: usize,
        now: &mut Proposal,
        others: &BTreeMap<usize, usize>,
        densities: &mut Densities,
        rng: &mut impl Rng,
    ) -> Option<()> {
        let window = self.window(index, rng);
        let sequence = &self.sequences[index];
        let given = self.prior.dynamics.posterior(&sequence.statistics(|frame| window.contains(&frame)))?;
        let prior = self.prior.dynamics.posterior(&Statistics::default())?;
        let n = self.sequences.len() as f64;
        let intensity = self.state.gamma * self.state.c / (self.state.c + n - 1.0);
        let unique: Vec<usize> =
            (0..now.active.len()).filter(|place| !others.contains_key(&now.active[*place])).collect();
        if rng.random::<bool>() {
            let dynamics = if rng.random::<bool>() { &given } else { &prior }.draw(rng)?;
            let name = self.fresh;
            densities.insert(name, self.densities(index, &dynamics));
            let proposal = now.with(name, densities, (self.state.alpha, self.state.kappa), rng);
            let log_ratio = proposal.log_likelihood - now.log_likelihood + libm::log(intensity)
                - libm::log(unique.len() as f64 + 1.0)
                - log_birth_excess(&dynamics, &given, &prior);
            if accepts(log_ratio, rng) {
                *now = proposal;
                self.fresh += 1;
                self.state.dynamics.insert(name, dynamics);
            } else {
                densities.remove(name);
            }
        } else if !unique.is_empty() && now.active.len() > 1 {
            let place = unique[rng.random_range(0..unique.len())];
            let name = now.active[place];
            let proposal = now.without(place, densities);
            let log_ratio = proposal.log_likelihood - now.log_likelihood - libm::log(intensity)
                + libm::log(unique.len() as f64)
                + log_birth_excess(&self.state.dynamics[&name], &given, &prior);
            if accepts(log_ratio, rng) {
                *now = proposal;
                densities.remove(name);
                self.state.dynamics.remove(&name);
            }
        }
        Some(())
    }

    /// A window of frames; its length and its place are uniform.
    fn window(&self, index: usize, rng: &mut impl Rng) -> core::ops::Range<usize> {
        let frames = self.sequences[index].len();
        let (shortest, longest) = self.moves.window;
        let (shortest, longest) = (shortest.clamp(1, frames), longest.clamp(1, frames));
        let length = rng.random_range(shortest..=longest.max(shortest));
        let start = rng.random_range(0..=frames - length);
        start..start + length
    }

    fn densities(&self, index: usize, dynamics: &Dynamics<D>) -> Vec<f64> {
        let sequence = &self.sequences[index];
        sequence.current.iter().zip(&sequence.lagged).map(|(x, y)| dynamics.log_density(x, y)).collect()
    }
}

/// log q(θ) − log p(θ), where q is half the posterior given the window and half the prior.
fn log_birth_excess<const D: usize>(
    dynamics: &Dynamics<D>,
    given: &DynamicsPosterior<D>,
    prior: &DynamicsPosterior<D>,
) -> f64 {
    let apart = given.log_density(dynamics) - prior.log_density(dynamics);
    // log (½ e^apart + ½), from the greater of the two terms.
    apart.max(0.0) + libm::log1p(libm::exp(-apart.abs())) - core::f64::consts::LN_2
}
