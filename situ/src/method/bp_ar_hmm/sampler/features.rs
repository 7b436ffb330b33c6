//! Which behaviours a sequence has, its states summed out, and then its states.

use std::collections::BTreeMap;

use rand::{Rng, RngExt};

use super::draw::accepts;
use super::{Chain, Dynamics, Posterior, Statistics, Weights, backward_sample, log_forward};

/// The behaviours of a sequence with what the forward pass makes of them.
struct Proposal {
    active: Vec<usize>,
    weights: Weights,
    log_likelihood: f64,
}

/// log p(x_t) of every frame of a sequence, by behaviour.
type Densities = BTreeMap<usize, Vec<f64>>;

impl Proposal {
    fn new(active: Vec<usize>, weights: Weights, densities: &Densities, filter: &mut Vec<f64>) -> Self {
        let rows: Vec<&[f64]> = active.iter().map(|name| densities[name].as_slice()).collect();
        let log_likelihood = log_forward(&rows, &weights.probabilities(), filter);
        Self { active, weights, log_likelihood }
    }

    fn with(&self, name: usize, densities: &Densities, stickiness: (f64, f64), rng: &mut impl Rng) -> Self {
        let mut active = self.active.clone();
        active.push(name);
        Self::new(active, self.weights.grown(stickiness.0, stickiness.1, rng), densities, &mut Vec::new())
    }

    fn without(&self, place: usize, densities: &Densities) -> Self {
        let mut active = self.active.clone();
        active.remove(place);
        Self::new(active, self.weights.shrunk(place), densities, &mut Vec::new())
    }
}

impl<const D: usize> Chain<D> {
    /// Shared behaviours, behaviours of its own, and states of one sequence.
    pub(super) fn update_sequence(&mut self, index: usize, rng: &mut impl Rng) -> Option<()> {
        let mut densities: Densities = self.state.dynamics.keys().map(|name| (*name, Vec::new())).collect();
        for (name, own) in &mut densities {
            *own = self.densities(index, &self.state.dynamics[name]);
        }
        let mut others: BTreeMap<usize, usize> = BTreeMap::new();
        for (_, row) in self.state.rows.iter().enumerate().filter(|(other, _)| *other != index) {
            row.active.iter().for_each(|name| *others.entry(*name).or_default() += 1);
        }
        let row = &self.state.rows[index];
        let mut filter = Vec::new();
        let mut now = Proposal::new(row.active.clone(), row.weights.clone(), &densities, &mut filter);
        self.update_shared(&mut now, &others, &densities, rng);
        for _ in 0..self.moves.births {
            self.birth_or_death(index, &mut now, &others, &mut densities, rng)?;
        }
        let Proposal { active, weights, .. } = Proposal::new(now.active, now.weights, &densities, &mut filter);
        let states = backward_sample(&filter, &weights.probabilities(), active.len(), rng);
        let row = &mut self.state.rows[index];
        row.states = states.into_iter().map(|place| active[place]).collect();
        (row.active, row.weights) = (active, weights);
        Some(())
    }

    /// Each behaviour that another sequence has is proposed where the sequence has it not, and to be given up where it has: Metropolis and
    /// Hastings. The η of what is added come from their prior, so that they cancel.
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

    /// A reversible jump: the behaviours of this sequence alone are a Poisson process of intensity γ c / (c + N − 1) times the prior
    /// of θ and η. A birth draws θ half from the prior, half from the posterior given a window of frames; the window is chosen
    /// before it is known whether there will be a birth or a death, so that both know it.
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
                densities.remove(&name);
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
                densities.remove(&name);
                self.state.dynamics.remove(&name);
            }
        }
        Some(())
    }

    /// A window of frames: its length and its place are uniform.
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

/// log q(θ) − log p(θ), q being half the posterior given the window and half the prior.
fn log_birth_excess<const D: usize>(dynamics: &Dynamics<D>, given: &Posterior<D>, prior: &Posterior<D>) -> f64 {
    let apart = given.log_density(dynamics) - prior.log_density(dynamics);
    // log (½ e^apart + ½), from the greater of the two.
    apart.max(0.0) + libm::log1p(libm::exp(-apart.abs())) - core::f64::consts::LN_2
}
