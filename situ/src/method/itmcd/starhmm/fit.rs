//! Generalised expectation maximisation (Dempster, Laird and Rubin 1977).
//!
//! The expected log-likelihood is a sum of parts: one per emission, one per w, and one for all entries. Each part is
//! improved or left as it is. Ridge and floor keep the numbers bounded. A step that they would make lower is not taken,
//! so the log-likelihood itself never falls.

use super::inference::Posterior;
use super::model::{Starhmm, StarhmmError, StarhmmSequence};
use super::switch::{Choice, Exit, improve_entries, improve_exit};

/// The parameters of [`Starhmm::fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitParameters {
    /// The ridge on W, in the unit of a squared regressor, above 0.
    pub ridge: f64,
    /// ε of Σ + ε I, in the unit of a squared state, above 0.
    pub floor: f64,
    /// The ridge on each w and v, above 0. Without it, separable choices would give infinite weights.
    pub switch_ridge: f64,
    /// The fit stops when an iteration gains less than this, nats.
    pub tolerance: f64,
    /// The greatest number of iterations.
    pub max_iterations: usize,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmFit {
    /// The model.
    pub model: Starhmm,
    /// The log-likelihood of all sequences at the start and after each iteration, nats.
    pub log_likelihoods: Vec<f64>,
    /// The Newton steps of the logistic regressions in the M-steps.
    pub logistic_steps: usize,
}

impl StarhmmFit {
    /// The log-likelihood of the fitted model, nats.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihoods.last().copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// The number of iterations.
    pub fn iterations(&self) -> usize {
        self.log_likelihoods.len().saturating_sub(1)
    }
}

impl Starhmm {
    /// Fits all parameters to these sequences, starting from their present values. The structure (children, contexts,
    /// absences) stays.
    ///
    /// # Errors
    /// If shapes do not fit, or a sequence is impossible under the structure.
    pub fn fit(
        mut self,
        sequences: &[StarhmmSequence],
        parameters: &FitParameters,
    ) -> Result<StarhmmFit, StarhmmError> {
        self.check(sequences)?;
        let (mut log_likelihoods, mut logistic_steps) = (Vec::new(), 0);
        loop {
            let posteriors = sequences
                .iter()
                .enumerate()
                .map(|(index, sequence)| self.posterior_unchecked(index, sequence))
                .collect::<Result<Vec<_>, _>>()?;
            let now: f64 = posteriors.iter().map(|posterior| posterior.log_likelihood).sum();
            let gain = log_likelihoods.last().map_or(f64::INFINITY, |before| now - before);
            log_likelihoods.push(now);
            if gain < parameters.tolerance || log_likelihoods.len() > parameters.max_iterations {
                return Ok(StarhmmFit { model: self, log_likelihoods, logistic_steps });
            }
            logistic_steps += self.maximise(sequences, &posteriors, parameters);
        }
    }

    /// One M-step. Returns the Newton steps that it made.
    fn maximise(
        &mut self,
        sequences: &[StarhmmSequence],
        posteriors: &[Posterior],
        parameters: &FitParameters,
    ) -> usize {
        for (index, phase) in self.phases.iter_mut().enumerate() {
            let mut samples = Vec::new();
            for (sequence, posterior) in sequences.iter().zip(posteriors) {
                let weighted = sequence.steps.iter().zip(&posterior.gamma).filter(|(_, gamma)| gamma[index] > 0.0);
                samples.extend(weighted.map(|(step, gamma)| (gamma[index], &*step.regressors, &*step.target)));
            }
            phase.emission.improve(&samples, parameters.ridge, parameters.floor);
        }
        let mut exits: Vec<Vec<Exit<'_>>> = vec![Vec::new(); self.exits.len()];
        let mut choices = Vec::new();
        for (index, (sequence, posterior)) in sequences.iter().zip(posteriors).enumerate() {
            let first = (sequence.origin, false, &sequence.entry_features, &posterior.first);
            let later = posterior.transitions.iter().map(|transition| {
                let step = &sequence.steps[transition.step];
                (Some(transition.from), true, &step.entry_features, &transition.ends)
            });
            for (from, inside, features, seen) in std::iter::once(first).chain(later) {
                let options: Vec<usize> = self.options(from, index, inside).collect();
                if seen.is_empty() || options.len() < 2 {
                    continue;
                }
                let weight = |to: &usize| seen.iter().find(|(child, _)| child == to).map_or(0.0, |(_, weight)| *weight);
                choices.push(Choice {
                    weights: options.iter().map(weight).collect(),
                    entries: options.iter().map(|to| self.entry_of(*to)).collect(),
                    features,
                });
            }
            let learned = posterior.transitions.iter().filter(|transition| sequence.steps[transition.step].can_end);
            for transition in learned {
                let ends: f64 = transition.ends.iter().map(|(_, weight)| weight).sum();
                let features = &*sequence.steps[transition.step].exit_features;
                exits[self.phases[transition.from].exit].push((features, ends, transition.stays));
            }
        }
        let ridge = parameters.switch_ridge;
        let of_entries = improve_entries(&mut self.entries, &choices, ridge);
        let of_exits = self.exits.iter_mut().zip(&exits).map(|(weights, seen)| improve_exit(weights, seen, ridge));
        of_entries + of_exits.sum::<usize>()
    }
}
