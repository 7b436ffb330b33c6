//! A state-based transition autoregressive hidden Markov model (STARHMM; Kroemer, Daniel, Neumann, van Hoof and Peters
//! 2015).
//!
//! A hidden phase ρ_t makes the next state, y_t | x_t, ρ_t = i ~ N(W_i x_t, Σ_i), where x_t holds whatever the next
//! state is regressed on (the state before, an action, a constant). After a step the phase ends with probability τ_i =
//! σ(w_iᵀφ), and another begins: η_ij = softmax over the children j of i of v_jᵀψ, where φ and ψ are features of the
//! state that was reached. So T(i, j) = (1 − τ_i) 1\[i = j\] + τ_i η_ij. A phase that ends and begins again inside a
//! sequence would need a count of its own, so there a phase is no child of itself; as the phase that ran *before* a
//! sequence it can be.
//!
//! Three things are added to the paper's model. A step carries an observed *context* (here: the object that it is
//! about), and a phase makes steps of its own context alone. Where a segmentation is known, a phase can end at its cuts
//! alone: elsewhere τ is 0. And phases can share w and v, and be absent from some sequences: a new version of an old
//! phase.
//!
//! Nothing here knows tasks, physics, files or clocks. Sums are in a fixed order and logarithms from `libm`: equal
//! input, equal bits.

mod cholesky;
mod emission;
mod fit;
mod inference;
mod switch;

pub use emission::Emission;
pub use fit::{Fit, FitParameters};
pub use inference::{Posterior, Transition};

use std::collections::BTreeSet;

use thiserror::Error;

use crate::keyframe::hmm::log_sum_exp;
use crate::keyframe::logistic::dot;

/// The end of a sequence, as a child.
pub const END: usize = usize::MAX;

/// A phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// The context whose steps it makes.
    pub context: usize,
    /// W_i and Σ_i.
    pub emission: Emission,
    /// Index of its w in [`Starhmm::exits`].
    pub exit: usize,
    /// Index of its v in [`Starhmm::entries`].
    pub entry: usize,
    /// The sequences, by index, in which it cannot run.
    pub absent: BTreeSet<usize>,
}

/// The model.
#[derive(Clone, Debug, PartialEq)]
pub struct Starhmm {
    /// The phases.
    pub phases: Vec<Phase>,
    /// Children of each phase: indices of phases, or [`END`].
    pub children: Vec<Vec<usize>>,
    /// What can begin a sequence that nothing ran before.
    pub first: Vec<usize>,
    /// Each w, shape (number of φ).
    pub exits: Vec<Vec<f64>>,
    /// Each v, shape (number of ψ).
    pub entries: Vec<Vec<f64>>,
    /// Index of the v of [`END`].
    pub end_entry: usize,
}

/// One step of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What it is about.
    pub context: usize,
    /// x_t, shape (m).
    pub regressors: Vec<f64>,
    /// y_t, shape (d).
    pub target: Vec<f64>,
    /// Whether the phase can end after it; where the segmentation is known, inside a segment it cannot: τ is 0 there.
    pub can_end: bool,
    /// φ of the state that it reached.
    pub exit_features: Vec<f64>,
    /// ψ of the state that it reached.
    pub entry_features: Vec<f64>,
}

/// A sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// The phase that had ended when it began; `None` where nothing had run.
    pub origin: Option<usize>,
    /// ψ of the state in which it began.
    pub entry_features: Vec<f64>,
    /// At least one step.
    pub steps: Vec<Step>,
    /// Whether [`END`] follows; otherwise it just stops.
    pub ends: bool,
}

/// Why a model could not be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum StarhmmError {
    /// A sequence, a vector or an index that does not fit the others.
    #[error("sequence {sequence}: {problem}")]
    Shape {
        /// Index of the sequence.
        sequence: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// A model whose indices or vectors do not fit together.
    #[error("the model: {0}")]
    Model(&'static str),
    /// No path of phases makes this sequence.
    #[error("sequence {sequence} is impossible under the structure")]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
    },
}

impl Starhmm {
    /// The children of a phase, or of `None` (nothing ran before), that can run in a sequence. `inside`: without the
    /// phase itself.
    pub(crate) fn options(&self, from: Option<usize>, sequence: usize, inside: bool) -> impl Iterator<Item = usize> {
        let children = from.map_or(&self.first, |phase| &self.children[phase]);
        let is_present = move |to: usize| to == END || !self.phases[to].absent.contains(&sequence);
        children.iter().copied().filter(move |to| is_present(*to) && !(inside && Some(*to) == from))
    }

    fn entry_of(&self, to: usize) -> usize {
        if to == END { self.end_entry } else { self.phases[to].entry }
    }

    /// log η of each option, in order.
    fn log_choice(&self, options: &[usize], features: &[f64]) -> Vec<f64> {
        let scores: Vec<f64> = options.iter().map(|to| dot(&self.entries[self.entry_of(*to)], features)).collect();
        let total = log_sum_exp(scores.iter().copied());
        scores.into_iter().map(|score| score - total).collect()
    }

    /// The number of free parameters k: W and the symmetric Σ of each phase, each w, and of the v those that the
    /// choices tell apart (a softmax does not change where all its v move together, so a connected group of g of them
    /// counts g − 1).
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

    fn check(&self, sequences: &[Sequence]) -> Result<(), StarhmmError> {
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
            let fits = |step: &Step| {
                let shape =
                    [step.regressors.len(), step.target.len(), step.exit_features.len(), step.entry_features.len()];
                shape == [inputs, outputs, w.len(), v.len()]
            };
            if sequence.entry_features.len() != v.len() || !sequence.steps.iter().all(fits) {
                return refuse("a vector has another length than the model's");
            }
            let numbers = |step: &Step| {
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

/// log σ(z), without overflow.
fn log_sigmoid(z: f64) -> f64 {
    z.min(0.0) - libm::log1p(libm::exp(-z.abs()))
}
