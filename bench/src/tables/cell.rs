//! Cells: the content of a table, and how it is made of records.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::random::stream;

use crate::record::Rate;
use crate::stats::{self, Estimate};

/// How an estimate stands to the truth where runs were censored at their budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    Exact,
    AtLeast,
    AtMost,
    Unknown,
}

impl Bound {
    /// The bound of a ratio. Its numerator and its denominator are known exactly, or are lower bounds.
    pub(super) const fn of(numerator_is_exact: bool, denominator_is_exact: bool) -> Self {
        match (numerator_is_exact, denominator_is_exact) {
            (true, true) => Self::Exact,
            (false, true) => Self::AtLeast,
            (true, false) => Self::AtMost,
            (false, false) => Self::Unknown,
        }
    }

    pub(super) const fn mark(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::AtLeast => "≥",
            Self::AtMost => "≤",
            Self::Unknown => "~",
        }
    }
}

/// The content of a row under a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Text(String),
    Count(usize),
    Number(f64),
    Rate(Rate),
    Estimate(Estimate, Bound),
    Nothing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count as usize)
    }
}

/// A cell of a value that may be missing.
pub(super) fn some<T>(value: Option<T>, cell: impl FnOnce(T) -> Cell) -> Cell {
    value.map_or(Cell::Nothing, cell)
}

/// Rates pooled over their rollouts; nothing where there was no rollout.
pub(super) fn rate(rates: impl Iterator<Item = Rate>) -> Cell {
    let pooled: Rate = rates.sum();
    if pooled.rollouts == 0 { Cell::Nothing } else { Cell::Rate(pooled) }
}

/// The share of things that are so, as a rate.
pub(super) fn share(of: impl Iterator<Item = bool>) -> Cell {
    rate(of.map(Rate::from))
}

/// The median alone.
pub(super) fn middle(values: &[f64]) -> Cell {
    some(stats::median(values), Cell::Number)
}

/// An estimate without censored runs.
pub(super) fn estimate(estimate: Option<Estimate>) -> Cell {
    some(estimate, |estimate| Cell::Estimate(estimate, Bound::Exact))
}

/// The median with its bootstrap interval.
pub(super) fn median(values: &[f64], seed: u64) -> Cell {
    estimate(stats::bootstrap(values.len(), seed, |drawn| {
        stats::median(&drawn.iter().map(|index| values[*index]).collect::<Vec<_>>())
    }))
}

/// The mean with its bootstrap interval.
pub(super) fn mean(values: &[f64], seed: u64) -> Cell {
    estimate(stats::bootstrap(values.len(), seed, |drawn| {
        (!drawn.is_empty()).then(|| drawn.iter().map(|index| values[*index]).sum::<f64>() / drawn.len() as f64)
    }))
}

/// The restricted mean over runs. Each is its spending, and whether it used its budget up.
pub(super) fn spent(of: impl Iterator<Item = (f64, bool)>, seed: u64) -> Cell {
    some(stats::restricted_mean(&of.collect::<Vec<_>>(), seed), |mean| {
        Cell::Estimate(mean.estimate, Bound::of(mean.censored == 0, true))
    })
}

/// How often each edit was made, in words.
pub(super) fn made(edits: impl Iterator<Item = Edit>) -> Cell {
    let mut counts: BTreeMap<Edit, usize> = BTreeMap::new();
    for edit in edits {
        *counts.entry(edit).or_default() += 1;
    }
    let words: Vec<String> = counts.iter().map(|(edit, count)| format!("{edit} {count}")).collect();
    if words.is_empty() { Cell::Nothing } else { Cell::Text(words.join(", ")) }
}

/// The seed of a bootstrap. Each quantity of each row has its own stream, so that a row does not depend on its
/// neighbours.
pub(super) fn seed(row: &str, quantity: &str) -> u64 {
    stream(0, &format!("bootstrap/{row}/{quantity}"))
}
