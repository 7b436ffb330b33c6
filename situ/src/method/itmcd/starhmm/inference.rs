//! Forward, backward and the most probable path, in logarithms.

use super::logarithms::{log_sigmoid, log_sum_exp};
use super::model::{END, Starhmm, StarhmmError, StarhmmSequence};
use crate::vector::dot;

/// The posterior of the phases given the steps of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// log p(y_1…y_T | x, θ), with END if the sequence ends.
    pub log_likelihood: f64,
    /// γ_t(i) = p(ρ_t = i | all), shape (T, phases).
    pub gamma: Vec<Vec<f64>>,
    /// The posterior of the first phase. The weights sum to 1.
    pub first: Vec<(usize, f64)>,
    /// ξ: every transition from a phase at a step, with END.
    pub transitions: Vec<Transition>,
}

/// ξ_t(i, ·).
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    /// t, the step that was made last.
    pub step: usize,
    /// i.
    pub from: usize,
    /// ξ_t(i, i).
    pub stays: f64,
    /// ξ_t(i, j) for each child j, with [`END`], without zeros.
    pub ends: Vec<(usize, f64)>,
}

/// The densities and the transitions of one sequence.
struct Tables {
    /// log f, shape (T, phases). −∞ if the phase cannot make the step.
    density: Vec<Vec<f64>>,
    /// log η of the origin, shape (phases).
    first: Vec<f64>,
    /// For each step and each phase that can have made it, log T of each way on, shape (T, phases, …).
    ways: Vec<Vec<Vec<(usize, f64)>>>,
}

impl Tables {
    /// The log probability of a transition and of all that follows it.
    fn ahead(&self, backward: &[Vec<f64>], time: usize, (to, log): &(usize, f64)) -> f64 {
        if *to == END { *log } else { log + self.density[time + 1][*to] + backward[time + 1][*to] }
    }

    /// log β, shape (T, phases).
    fn backward(&self, ends: bool) -> Vec<Vec<f64>> {
        let (steps, phases) = (self.density.len(), self.first.len());
        let mut backward = vec![vec![f64::NEG_INFINITY; phases]; steps];
        for time in (0..steps).rev() {
            for phase in 0..phases {
                backward[time][phase] = if time + 1 == steps && !ends {
                    0.0
                } else {
                    let ways = self.ways[time][phase].iter();
                    log_sum_exp(ways.map(|way| self.ahead(&backward, time, way)))
                };
            }
        }
        backward
    }

    /// log α, shape (T, phases).
    fn forward(&self) -> Vec<Vec<f64>> {
        let (steps, phases) = (self.density.len(), self.first.len());
        let mut forward: Vec<Vec<f64>> = Vec::with_capacity(steps);
        forward.push(self.first.iter().zip(&self.density[0]).map(|(first, density)| first + density).collect());
        for time in 1..steps {
            let mut terms = vec![Vec::new(); phases];
            for (phase, ways) in self.ways[time - 1].iter().enumerate() {
                for (to, log) in ways {
                    terms[*to].push(forward[time - 1][phase] + log);
                }
            }
            let sums = terms.iter().zip(&self.density[time]);
            forward.push(sums.map(|(terms, density)| log_sum_exp(terms.iter().copied()) + density).collect());
        }
        forward
    }
}

impl Starhmm {
    fn tables(&self, index: usize, sequence: &StarhmmSequence) -> Tables {
        let can = |phase: usize, context: usize| {
            self.phases[phase].context == context && !self.phases[phase].absent.contains(&index)
        };
        let density: Vec<Vec<f64>> = sequence
            .steps
            .iter()
            .map(|step| {
                let of = |phase: usize| {
                    if can(phase, step.context) {
                        self.phases[phase].emission.log_density(&step.regressors, &step.target)
                    } else {
                        f64::NEG_INFINITY
                    }
                };
                (0..self.phases.len()).map(of).collect()
            })
            .collect();
        let mut first = vec![f64::NEG_INFINITY; self.phases.len()];
        let options: Vec<usize> = self.options(sequence.origin, index, false).collect();
        for (to, log) in options.iter().zip(self.log_choice(&options, &sequence.entry_features)) {
            if *to != END {
                first[*to] = log;
            }
        }
        let last = sequence.steps.len() - 1;
        let ways = sequence.steps.iter().enumerate().map(|(time, step)| {
            let of = |phase: usize| {
                let mut ways = Vec::new();
                if density[time][phase] == f64::NEG_INFINITY || (time == last && !sequence.ends) {
                    return ways;
                }
                let odds = dot(&self.exits[self.phases[phase].exit], &step.exit_features);
                if time < last && density[time + 1][phase] > f64::NEG_INFINITY {
                    ways.push((phase, if step.can_end { log_sigmoid(-odds) } else { 0.0 }));
                }
                if !step.can_end {
                    return ways;
                }
                let options: Vec<usize> = self.options(Some(phase), index, true).collect();
                let leads = |to: usize| {
                    if time == last { to == END } else { to != END && density[time + 1][to] > f64::NEG_INFINITY }
                };
                if options.iter().any(|to| leads(*to)) {
                    let logs = self.log_choice(&options, &step.entry_features);
                    let ends = options.iter().zip(logs).filter(|(to, _)| leads(**to));
                    ways.extend(ends.map(|(to, log)| (*to, log_sigmoid(odds) + log)));
                }
                ways
            };
            (0..self.phases.len()).map(of).collect()
        });
        let ways = ways.collect();
        Tables { density, first, ways }
    }

    /// Forward and backward: α_1(j) = η_origin,j f_j(y_1); α_{t+1}(j) = Σ_i α_t(i) T_t(i, j) f_j(y_{t+1}); β_T(i) = 1,
    /// or τ_i η_i,END if the sequence ends. `index` is that of the sequence, as in [`super::model::Phase::absent`]. O(T
    /// · edges).
    ///
    /// # Errors
    /// If shapes do not fit, or no path of phases makes the sequence.
    pub fn posterior(&self, index: usize, sequence: &StarhmmSequence) -> Result<Posterior, StarhmmError> {
        self.check(std::slice::from_ref(sequence))?;
        self.posterior_unchecked(index, sequence)
    }

    pub(super) fn posterior_unchecked(
        &self,
        index: usize,
        sequence: &StarhmmSequence,
    ) -> Result<Posterior, StarhmmError> {
        let tables = self.tables(index, sequence);
        let phases = self.phases.len();
        let (backward, forward) = (tables.backward(sequence.ends), tables.forward());
        let log_likelihood =
            log_sum_exp(forward[0].iter().zip(&backward[0]).map(|(forward, backward)| forward + backward));
        if !log_likelihood.is_finite() {
            return Err(StarhmmError::Impossible { sequence: index });
        }
        let share = |log: f64| libm::exp(log - log_likelihood);
        let gamma: Vec<Vec<f64>> = forward
            .iter()
            .zip(&backward)
            .map(|(forward, backward)| forward.iter().zip(backward).map(|(a, b)| share(a + b)).collect())
            .collect();
        let first = (0..phases).map(|phase| (phase, gamma[0][phase])).filter(|(_, weight)| *weight > 0.0).collect();
        let mut transitions = Vec::new();
        for (step, ways) in tables.ways.iter().enumerate() {
            for (from, ways) in ways.iter().enumerate() {
                let mut transition = Transition { step, from, stays: 0.0, ends: Vec::new() };
                for way in ways {
                    let weight = share(forward[step][from] + tables.ahead(&backward, step, way));
                    if way.0 == from {
                        transition.stays = weight;
                    } else if weight > 0.0 {
                        transition.ends.push((way.0, weight));
                    }
                }
                if transition.stays > 0.0 || !transition.ends.is_empty() {
                    transitions.push(transition);
                }
            }
        }
        Ok(Posterior { log_likelihood, gamma, first, transitions })
    }

    /// The most probable path of phases (Viterbi); the first in order if two tie.
    ///
    /// # Errors
    /// As [`Starhmm::posterior`].
    pub fn most_probable_path(&self, index: usize, sequence: &StarhmmSequence) -> Result<Vec<usize>, StarhmmError> {
        self.check(std::slice::from_ref(sequence))?;
        let tables = self.tables(index, sequence);
        let (steps, phases) = (sequence.steps.len(), self.phases.len());
        let mut best: Vec<f64> =
            tables.first.iter().zip(&tables.density[0]).map(|(first, density)| first + density).collect();
        let mut came = Vec::with_capacity(steps);
        for time in 1..steps {
            let mut reached = vec![(f64::NEG_INFINITY, 0); phases];
            for (phase, ways) in tables.ways[time - 1].iter().enumerate() {
                for (to, log) in ways {
                    let value = best[phase] + log + tables.density[time][*to];
                    if value > reached[*to].0 {
                        reached[*to] = (value, phase);
                    }
                }
            }
            best = reached.iter().map(|(value, _)| *value).collect();
            came.push(reached);
        }
        if sequence.ends {
            for (value, ways) in best.iter_mut().zip(&tables.ways[steps - 1]) {
                *value += ways.iter().find(|(to, _)| *to == END).map_or(f64::NEG_INFINITY, |(_, log)| *log);
            }
        }
        let last = (0..phases).reduce(|kept, other| if best[other] > best[kept] { other } else { kept });
        let last = last.filter(|phase| best[*phase].is_finite()).ok_or(StarhmmError::Impossible { sequence: index })?;
        let mut path = vec![last];
        let mut now = last;
        for reached in came.iter().rev() {
            now = reached[now].1;
            path.push(now);
        }
        path.reverse();
        Ok(path)
    }
}
