//! Cells of a table and the columns that make them.

use std::collections::{BTreeMap, BTreeSet};

use situ::edit::Edit;
use situ::trace::Counters;

use super::pooled::{Pooled, draws};
use crate::stats::{self, Estimate};
use crate::tally::Rate;

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
    Pooled(Pooled, Bound),
    Nothing,
}

impl Cell {
    /// Whether it holds something, and no zero among counts.
    pub(super) fn says_something(&self) -> bool {
        !matches!(self, Self::Nothing | Self::Count(0))
    }
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

/// The share of independent things that are so, as a rate.
pub(super) fn share(of: impl Iterator<Item = bool>) -> Cell {
    let rate: Rate = of.map(Rate::from).sum();
    if rate.rollouts == 0 { Cell::Nothing } else { Cell::Rate(rate) }
}

/// The median without an interval.
pub(super) fn middle(values: impl IntoIterator<Item = f64>) -> Cell {
    some(stats::median(&values.into_iter().collect::<Vec<_>>()), Cell::Number)
}

/// An estimate whose data are exact.
pub(super) fn estimate(estimate: Option<Estimate>) -> Cell {
    some(estimate, |estimate| Cell::Estimate(estimate, Bound::Exact))
}

/// A statistic of the values, with a bootstrap interval.
fn drawn(values: impl IntoIterator<Item = f64>, statistic: fn(&[f64]) -> Option<f64>) -> Cell {
    let values: Vec<f64> = values.into_iter().collect();
    let of = |drawn: &[usize]| statistic(&drawn.iter().map(|index| values[*index]).collect::<Vec<_>>());
    estimate(stats::bootstrap(values.len(), draws(), of))
}

/// The median, with a bootstrap interval.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Cell {
    drawn(values, stats::median)
}

/// How often each set of edits was made, in words.
pub(super) fn made(edits: impl Iterator<Item = BTreeSet<Edit>>) -> Cell {
    let mut counts: BTreeMap<BTreeSet<Edit>, usize> = BTreeMap::new();
    for edits in edits {
        *counts.entry(edits).or_default() += 1;
    }
    let name = |edits: &BTreeSet<Edit>| edits.iter().map(|edit| edit.name()).collect::<Vec<_>>().join("+");
    let words: Vec<String> = counts.iter().map(|(edits, count)| format!("{} {count}", name(edits))).collect();
    if words.is_empty() { Cell::Nothing } else { Cell::Text(words.join(", ")) }
}

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Words.
    Text,
    /// A whole number.
    Count,
    /// A number with this many decimals in Markdown.
    Number(usize),
    /// k of n independent things, with the Wilson 95 % interval.
    Rate,
    /// A number with its 95 % interval, and this many decimals in Markdown.
    Estimate(usize),
    /// A number with two 95 % intervals, by units and by variations, and this many decimals in Markdown.
    Pooled(usize),
}

/// The head of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    /// Whether it holds the clock: the same run then gives other numbers.
    pub(super) wall: bool,
}

impl Head {
    /// The head in words.
    pub(super) fn words(&self) -> String {
        let name = self.name.replace('_', " ");
        if self.wall { format!("{name} (wall)") } else { name }
    }
}

/// A column of a table whose rows are made of `R`.
pub(super) struct Column<'a, R> {
    pub(super) head: Head,
    pub(super) cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

/// The columns of a table whose rows are made of `R`, from left to right.
pub(super) struct Columns<'a, R>(pub(super) Vec<Column<'a, R>>);

impl<'a, R> Columns<'a, R> {
    /// No column yet.
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// And a column that does not hold the clock.
    pub(super) fn column<C: Into<Cell>>(self, name: &'static str, shape: Shape, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Head { name, shape, wall: false }, cell)
    }

    /// And a column that holds the clock.
    pub(super) fn wall<C: Into<Cell>>(self, name: &'static str, shape: Shape, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Head { name, shape, wall: true }, cell)
    }

    /// And a column of words.
    pub(super) fn text<C: Into<Cell>>(self, name: &'static str, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.column(name, Shape::Text, cell)
    }

    /// And a column of whole numbers.
    pub(super) fn count<C: Into<Cell>>(self, name: &'static str, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.column(name, Shape::Count, cell)
    }

    fn and<C: Into<Cell>>(mut self, head: Head, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.0.push(Column { head, cell: Box::new(move |row| cell(row).into()) });
        self
    }
}

pub(super) const MILLISECONDS_PER_SECOND: f64 = 1000.0;

/// The exact counters, in the order of [`Counters::named`].
pub(super) const COUNTERS: [&str; 7] = [
    "hmm_fits",
    "em_iterations",
    "divergences",
    "classifier_fits",
    "classifier_evaluations",
    "nodes_touched",
    "segments_touched",
];

/// And a column for the median of each counter; `of` are the counters of a row's updates.
pub(super) fn medians<'a, R>(columns: Columns<'a, R>, of: impl Fn(&R) -> Vec<Counters> + Copy + 'a) -> Columns<'a, R> {
    COUNTERS.into_iter().enumerate().fold(columns, |columns, (index, name)| {
        columns.column(name, Shape::Number(1), move |row| {
            middle(of(row).iter().map(|counters| counters.named()[index].1 as f64))
        })
    })
}
