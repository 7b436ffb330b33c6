//! The exact counters and the clock of an update, as columns.

use situ::trace::Counters;

use super::cell::middle;
use super::column::{Columns, Shape};

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
            middle(&of(row).iter().map(|counters| counters.named()[index].1 as f64).collect::<Vec<_>>())
        })
    })
}
