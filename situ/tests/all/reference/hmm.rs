//! A left-to-right hidden Markov model of keyframes, and its fit by expectation maximisation, all in logarithms
//! (decisions D12 to D14).

use core::f64::consts::PI;

use nalgebra::{Matrix6, Vector6};
use situ::demonstration::{Gripper, Pose};
use situ::keyframe::hmm::HmmParameters;

use crate::reference::commands::Commands;
use crate::reference::pose::{dominant, log, mean};

/// A state with at most this many expected frames keeps its values.
pub(crate) const EMPTY: f64 = 1e-12;

/// A pose, and the command if commands are part of the model.
pub(crate) type Frame = (Pose, Option<Gripper>);

/// A hidden state: a Gaussian in the tangent space at its mean, times the commands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Emission {
    pub(crate) mean: Pose,
    pub(crate) commands: Option<Commands>,
    /// Σ⁻¹ and log |Σ|.
    precision: Matrix6<f64>,
    log_determinant: f64,
}

/// A model of K states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hmm {
    pub(crate) emissions: Vec<Emission>,
    /// The log probability of each way. Row K is the start, column K is the end.
    ways: Vec<Vec<f64>>,
}

/// The expected counts of a sequence: the share of each state in each frame, and how often it took each way.
struct Expected {
    log_likelihood: f64,
    shares: Vec<Vec<f64>>,
    ways: Vec<Vec<f64>>,
}

/// S₀.
fn prior(rule: &HmmParameters) -> Matrix6<f64> {
    let (metres, [x, y, z]) = (rule.position_floor.powi(2), rule.rotation_floor.map(|floor| floor.powi(2)));
    Matrix6::from_diagonal(&Vector6::new(metres, metres, metres, x, y, z))
}

impl Emission {
    fn new(mean: Pose, covariance: Matrix6<f64>, commands: Option<Commands>) -> Self {
        let cholesky = covariance.cholesky().expect("the prior keeps it definite");
        let log_determinant = cholesky.l().diagonal().iter().map(|pivot| 2.0 * pivot.ln()).sum();
        Self { mean, commands, precision: cholesky.inverse(), log_determinant }
    }

    /// −½ (6 log 2π + log |Σ| + rᵀ Σ⁻¹ r), plus that of the command.
    fn log_density(&self, (pose, command): &Frame) -> f64 {
        let apart = log(&self.mean, pose);
        let squared = apart.dot(&(self.precision * apart));
        let of_command = self.commands.zip(*command).map_or(0.0, |(commands, command)| commands.log_density(command));
        of_command - 0.5 * (6.0 * (2.0 * PI).ln() + self.log_determinant + squared)
    }

    /// −½ ν₀ (log |Σ| + tr Σ⁻¹ S₀), plus that of the commands.
    fn log_prior(&self, rule: &HmmParameters) -> f64 {
        let of_commands = self.commands.map_or(0.0, |commands| commands.log_prior(rule));
        of_commands - 0.5 * rule.prior_weight * (self.log_determinant + (self.precision * prior(rule)).trace())
    }
}

impl Hmm {
    /// The maximum a posteriori model of so many states.
    pub(crate) fn fit(sequences: &[Vec<Frame>], states: usize, rule: &HmmParameters) -> Self {
        let commands = sequences[0][0].1.map(|_| Commands::unseen());
        let mut hmm = Self {
            emissions: vec![Emission::new(Pose::identity(), prior(rule), commands); states],
            ways: vec![vec![f64::NEG_INFINITY; states + 1]; states + 1],
        };
        for from in 0..=states {
            let open = hmm.open(from, rule);
            open.iter().for_each(|to| hmm.ways[from][*to] = -(open.len() as f64).ln());
        }
        let even: Vec<Expected> = sequences.iter().map(|sequence| evenly_cut(sequence.len(), states)).collect();
        hmm.maximise(sequences, &even, true, rule);
        hmm.refit(sequences, rule)
    }

    /// The model that expectation maximisation climbs to from here.
    pub(crate) fn refit(&self, sequences: &[Vec<Frame>], rule: &HmmParameters) -> Self {
        let mut hmm = self.clone();
        let mut last = f64::NAN;
        for iteration in 0.. {
            let expected: Vec<Expected> = sequences.iter().map(|sequence| hmm.expect(sequence)).collect();
            let objective = expected.iter().map(|of| of.log_likelihood).sum::<f64>()
                + hmm.emissions.iter().map(|emission| emission.log_prior(rule)).sum::<f64>();
            if (objective - last).abs() < rule.tolerance * last.abs() || iteration == rule.max_iterations {
                return hmm;
            }
            last = objective;
            hmm.maximise(sequences, &expected, false, rule);
        }
        unreachable!("the iterations are bounded")
    }

    /// The likeliest state of every frame.
    pub(crate) fn path(&self, sequence: &[Frame]) -> Vec<usize> {
        let k = self.states();
        let densities = self.densities(sequence);
        // The likeliest path to each state, and its log probability.
        let mut best: Vec<(Vec<usize>, f64)> = (0..k).map(|j| (vec![j], self.ways[k][j] + densities[0][j])).collect();
        for density in &densities[1..] {
            let longer = |j: usize| {
                let by = |(path, log): &(Vec<usize>, f64)| (path.clone(), log + self.ways[path[path.len() - 1]][j]);
                let (path, log) = best.iter().map(by).reduce(likelier).expect("a state");
                ([path, vec![j]].concat(), log + density[j])
            };
            best = (0..k).map(longer).collect();
        }
        let ended = best.into_iter().map(|(path, log)| {
            let last = path[path.len() - 1];
            (path, log + self.ways[last][k])
        });
        ended.reduce(likelier).expect("a state").0
    }

    fn states(&self) -> usize {
        self.emissions.len()
    }

    /// Where a state can lead: it can stay, go to the next, skip it, or end. The start leads to the first state, or
    /// skips it.
    fn open(&self, from: usize, rule: &HmmParameters) -> Vec<usize> {
        let (k, skip) = (self.states(), usize::from(rule.skip));
        if from == k {
            (0..=skip.min(k - 1)).collect()
        } else {
            (from..=(from + 1 + skip).min(k - 1)).chain([k]).collect()
        }
    }

    fn densities(&self, sequence: &[Frame]) -> Vec<Vec<f64>> {
        let of_frame = |frame| self.emissions.iter().map(|emission| emission.log_density(frame)).collect();
        sequence.iter().map(of_frame).collect()
    }

    /// α_tj = log p(x_1 … x_t, state j at t), and log p(x) with the end.
    fn forward(&self, densities: &[Vec<f64>]) -> (Vec<Vec<f64>>, f64) {
        let k = self.states();
        let mut alpha: Vec<Vec<f64>> = Vec::new();
        for density in densities {
            let reached = |j: usize| match alpha.last() {
                None => self.ways[k][j],
                Some(before) => log_sum((0..k).map(|i| before[i] + self.ways[i][j])),
            };
            alpha.push((0..k).map(|j| reached(j) + density[j]).collect());
        }
        let log_likelihood = log_sum((0..k).map(|i| alpha[densities.len() - 1][i] + self.ways[i][k]));
        (alpha, log_likelihood)
    }

    pub(crate) fn log_likelihood(&self, sequence: &[Frame]) -> f64 {
        self.forward(&self.densities(sequence)).1
    }

    /// The E step.
    fn expect(&self, sequence: &[Frame]) -> Expected {
        let (k, frames) = (self.states(), sequence.len());
        let densities = self.densities(sequence);
        let (alpha, log_likelihood) = self.forward(&densities);
        // β_ti = log p(x_t+1 …, the end | state i at t).
        let mut beta: Vec<Vec<f64>> = vec![(0..k).map(|i| self.ways[i][k]).collect(); frames];
        for t in (1..frames).rev() {
            for i in 0..k {
                beta[t - 1][i] = log_sum((0..k).map(|j| self.ways[i][j] + densities[t][j] + beta[t][j]));
            }
        }
        let shares = |t: usize| (0..k).map(|i| (alpha[t][i] + beta[t][i] - log_likelihood).exp()).collect();
        let way = |i: usize, j: usize| {
            let at = |t: usize| alpha[t - 1][i] + self.ways[i][j] + densities[t][j] + beta[t][j] - log_likelihood;
            (1..frames).map(|t| at(t).exp()).sum()
        };
        let ways = (0..k).map(|i| (0..k).map(|j| way(i, j)).collect()).collect();
        Expected::new(log_likelihood, (0..frames).map(shares).collect(), ways)
    }

    /// The M step. At the `first` M step the means are no guess.
    fn maximise(&mut self, sequences: &[Vec<Frame>], expected: &[Expected], first: bool, rule: &HmmParameters) {
        for from in 0..=self.states() {
            let open = self.open(from, rule);
            let counts = open.iter().map(|to| expected.iter().map(|of| of.ways[from][*to]).sum()).collect();
            for (to, share) in open.iter().zip(proportions(counts, rule.transition_floor)) {
                self.ways[from][*to] = share.ln();
            }
        }
        for (state, emission) in self.emissions.iter_mut().enumerate() {
            let weights: Vec<f64> = expected.iter().flat_map(|of| &of.shares).map(|shares| shares[state]).collect();
            let total: f64 = weights.iter().sum();
            if total <= EMPTY {
                continue;
            }
            let frames = weights.iter().zip(sequences.iter().flatten());
            let poses: Vec<(f64, Pose)> = frames.clone().map(|(weight, (pose, _))| (*weight, *pose)).collect();
            let given: Vec<(f64, Gripper)> =
                frames.filter_map(|(weight, (_, command))| Some((*weight, (*command)?))).collect();
            let commands = emission.commands.map(|commands| commands.updated(&given, rule));
            // Σ = (Σ γ r rᵀ + ν₀ S₀) / (Σ γ + ν₀).
            let about = |mean: Pose| {
                let mut scatter = prior(rule) * rule.prior_weight;
                for (weight, pose) in &poses {
                    let apart = log(&mean, pose);
                    scatter.ger(*weight, &apart, &apart, 1.0);
                }
                Emission::new(mean, scatter / (total + rule.prior_weight), commands)
            };
            *emission = if first {
                about(mean(&poses, dominant(&poses)))
            } else {
                // The mean on the manifold need not be the best for a full covariance. If it is worse by more than
                // rounding, the old mean stays.
                let (moved, stayed) = (about(mean(&poses, emission.mean.rotation)), about(emission.mean));
                if stayed.log_determinant < moved.log_determinant - 1e-9 { stayed } else { moved }
            };
        }
    }
}

impl Expected {
    /// Adds the start and the end to the ways.
    fn new(log_likelihood: f64, shares: Vec<Vec<f64>>, mut ways: Vec<Vec<f64>>) -> Self {
        ways.iter_mut().zip(&shares[shares.len() - 1]).for_each(|(way, ends)| way.push(*ends));
        ways.push(shares[0].clone());
        Self { log_likelihood, shares, ways }
    }
}

/// The start of the fit: frame t of T is in state ⌊tK/T⌋. A state without a frame borrows the frame that is nearest to
/// its place.
fn evenly_cut(frames: usize, states: usize) -> Expected {
    let mut shares = vec![vec![0.0; states]; frames];
    let mut ways = vec![vec![0.0; states]; states];
    for t in 0..frames {
        shares[t][t * states / frames] = 1.0;
        if t > 0 {
            ways[(t - 1) * states / frames][t * states / frames] += 1.0;
        }
    }
    if frames < states {
        (0..states).for_each(|state| shares[(2 * state + 1) * frames / (2 * states)][state] = 1.0);
    }
    Expected::new(f64::NAN, shares, ways)
}

/// Probabilities in proportion to these counts, but none below the floor. Those that would be below are put on the
/// floor, and the others share the rest. Empty if all counts are 0.
fn proportions(counts: Vec<f64>, floor: f64) -> Vec<f64> {
    let mut on_floor = vec![false; counts.len()];
    loop {
        let rest = 1.0 - floor * on_floor.iter().filter(|on| **on).count() as f64;
        let free: f64 = counts.iter().zip(&on_floor).filter(|(_, on)| !**on).map(|(count, _)| count).sum();
        if free <= 0.0 {
            return Vec::new();
        }
        let share = |way: usize| if on_floor[way] { floor } else { counts[way] * rest / free };
        match (0..counts.len()).find(|way| share(*way) < floor) {
            Some(low) => on_floor[low] = true,
            None => return (0..counts.len()).map(share).collect(),
        }
    }
}

fn likelier(one: (Vec<usize>, f64), other: (Vec<usize>, f64)) -> (Vec<usize>, f64) {
    if other.1 > one.1 { other } else { one }
}

/// log Σ exp.
fn log_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + terms.map(|term| (term - greatest).exp()).sum::<f64>().ln()
}
