//! The model: its phases and their structure, the sequences that it makes, and what can go wrong with one.

use std::collections::BTreeSet;

use thiserror::Error;

use super::emission::LinearGaussian;
use super::logarithms::log_sum_exp;
use crate::vector::dot;

/// Why a model could not be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum StarhmmError {
    /// A sequence, a vector or an index does not fit the others.
    #[error("sequence {sequence}: {problem}")]
    Shape {
        /// Index of the sequence.
        sequence: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// The indices or vectors of the model do not fit together.
    #[error("the model: {0}")]
    Model(&'static str),
    /// No path of phases makes this sequence.
    #[error("sequence {sequence} is impossible under the structure")]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
    },
}

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmStep {
    /// The context: what the step is about.
    pub context: usize,
    /// x_t, shape (m).
    pub regressors: Vec<f64>,
    /// y_t, shape (d).
    pub target: Vec<f64>,
    /// Whether the phase can end after it. If the segmentation is known, it cannot end inside a segment, and τ is 0
    /// there.
    pub can_end: bool,
    /// φ of the state that the step reached.
    pub exit_features: Vec<f64>,
    /// ψ of the state that the step reached.
    pub entry_features: Vec<f64>,
}

/// A sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub struct StarhmmSequence {
    /// The phase that had ended when the sequence began. `None` if nothing had run.
    pub origin: Option<usize>,
    /// ψ of the state in which it began.
    pub entry_features: Vec<f64>,
    /// The steps, at least one.
    pub steps: Vec<StarhmmStep>,
    /// Whether [`END`] follows. Otherwise the sequence just stops.
    pub ends: bool,
}

/// The end of a sequence, as a child.
pub const END: usize = usize::MAX;

/// A phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// The context of the steps that it makes.
    pub context: usize,
    /// W_i and Σ_i.
    pub emission: LinearGaussian,
    /// The index of its w in [`Starhmm::exits`].
    pub exit: usize,
    /// The index of its v in [`Starhmm::entries`].
    pub entry: usize,
    /// The indices of the sequences in which it cannot run.
    pub absent: BTreeSet<usize>,
}

/// A STARHMM.
#[derive(Clone, Debug, PartialEq)]
pub struct Starhmm {
    /// The phases.
    pub phases: Vec<Phase>,
    /// The children of each phase: indices of phases, or [`END`].
    pub children: Vec<Vec<usize>>,
    /// The phases that can begin a sequence before which nothing ran.
    pub first: Vec<usize>,
    /// Each w, shape (number of φ).
    pub exits: Vec<Vec<f64>>,
    /// Each v, shape (number of ψ).
    pub entries: Vec<Vec<f64>>,
    /// The index of the v of [`END`].
    pub end_entry: usize,
}

impl Starhmm {
    /// The children of a phase that can run in a sequence. `from` is `None` if nothing ran before. `inside` leaves out
    /// the phase itself.
    pub(crate) fn options(&self, from: Option<usize>, sequence: usize, inside: bool) -> impl Iterator<Item = usize> {
        let children = from.map_or(&self.first, |phase| &self.children[phase]);
        let is_present = move |to: usize| to == END || !self.phases[to].absent.contains(&sequence);
        children.iter().copied().filter(move |to| is_present(*to) && !(inside && Some(*to) == from))
    }

    pub(super) fn entry_of(&self, to: usize) -> usize {
        if to == END { self.end_entry } else { self.phases[to].entry }
    }

    /// log η of each option, in order.
    pub(super) fn log_choice(&self, options: &[usize], features: &[f64]) -> Vec<f64> {
        let scores: Vec<f64> = options.iter().map(|to| dot(&self.entries[self.entry_of(*to)], features)).collect();
        let total = log_sum_exp(scores.iter().copied());
        scores.into_iter().map(|score| score - total).collect()
    }

    /// The number of free parameters k: W and the symmetric Σ of each phase, each w, and those v that some choice
    /// compares. A softmax does not change if all its v move together, so g connected v count as g − 1.
    pub fn free_parameters(&self) -> usize {
        let emissions: usize = self.phases.iter().map(|phase| phase.emission.free_parameters()).sum();
        let exits: BTreeSet<usize> = self.phases.iter().map(|phase| phase.exit).collect();
        let exits: usize = exits.into_iter().map(|exit| self.exits[exit].len()).sum();
        let mut group: Vec<usize> = (0..self.entries.len()).collect();
        let mut joined = 0;
        for children in self.children.iter().chain([&self.first]) {
            let mut entries = children.iter().map(|to| self.entry_of(*to));
            let Some(first) = entries.next() else { continue };
            for entry in entries {
                let (keep, gone) = (group[first], group[entry]);
                if keep != gone {
                    joined += self.entries[entry].len();
                    group.iter_mut().filter(|name| **name == gone).for_each(|name| *name = keep);
                }
            }
        }
        emissions + exits + joined
    }

    pub(super) fn check(&self, sequences: &[StarhmmSequence]) -> Result<(), StarhmmError> {
        let knows = |to: &usize| *to == END || *to < self.phases.len();
        if self.children.len() != self.phases.len() || !self.children.iter().flatten().chain(&self.first).all(knows) {
            return Err(StarhmmError::Model("a list of children a phase, each child a phase or END"));
        }
        let known = |phase: &Phase| phase.exit < self.exits.len() && phase.entry < self.entries.len();
        if !self.phases.iter().all(known) || self.end_entry >= self.entries.len() {
            return Err(StarhmmError::Model("an index of w or v is out of range"));
        }
        let (Some(phase), Some(w), Some(v)) = (self.phases.first(), self.exits.first(), self.entries.first()) else {
            return Err(StarhmmError::Model("at least one phase"));
        };
        let (outputs, inputs) = (phase.emission.outputs(), phase.emission.inputs());
        let same = |other: &Phase| (other.emission.outputs(), other.emission.inputs()) == (outputs, inputs);
        if !self.phases.iter().all(same)
            || self.exits.iter().any(|other| other.len() != w.len())
            || self.entries.iter().any(|other| other.len() != v.len())
        {
            return Err(StarhmmError::Model("phases, w and v of one shape each"));
        }
        for (index, sequence) in sequences.iter().enumerate() {
            let refuse = |problem| Err(StarhmmError::Shape { sequence: index, problem });
            if sequence.steps.is_empty() {
                return refuse("at least one step");
            }
            if sequence.origin.is_some_and(|phase| phase >= self.phases.len()) {
                return refuse("the origin is not a phase");
            }
            let fits = |step: &StarhmmStep| {
                let shape =
                    [step.regressors.len(), step.target.len(), step.exit_features.len(), step.entry_features.len()];
                shape == [inputs, outputs, w.len(), v.len()]
            };
            if sequence.entry_features.len() != v.len() || !sequence.steps.iter().all(fits) {
                return refuse("a vector has another length than the model's");
            }
            let numbers = |step: &StarhmmStep| {
                let all = step.regressors.iter().chain(&step.target).chain(&step.exit_features);
                all.chain(&step.entry_features).all(|value| value.is_finite())
            };
            if !sequence.entry_features.iter().all(|value| value.is_finite()) || !sequence.steps.iter().all(numbers) {
                return refuse("a number is not finite");
            }
        }
        Ok(())
    }
}
