//! What tables say of runs: success, effort, and statistics over them.

use std::collections::BTreeSet;

use super::column::{Bound, Cell, some};
use super::pooled::{OfRuns, Pooled, pooled_by, pooled_ratio, pooled_share, unit, variation};
use crate::record::RunRecord;
use crate::stats;
use crate::tally::Rate;

/// A quantity of the effort of a run: its name, the quantity, and decimals in Markdown.
pub(super) type Measure = (&'static str, fn(&RunRecord) -> f64, usize);

/// What was spent on a changed task until the target was reached. A run that did not reach it counts the budget of
/// demonstrations, and what it spent of the rest: these are lower bounds.
pub(super) const EFFORT: [Measure; 5] = [
    ("demonstrations", |run| f64::from(run.charged()), 2),
    ("tries", |run| f64::from(run.effort.tries), 2),
    ("keyframes", |run| f64::from(run.effort.keyframes), 1),
    ("seconds", |run| run.effort.seconds, 1),
    ("metres", |run| run.effort.metres, 2),
];

/// The share of rollouts that succeeded; `None` where there was none.
pub(super) fn share(rate: Option<Rate>) -> Option<f64> {
    rate.filter(|rate| rate.rollouts > 0).map(|rate| f64::from(rate.successes) / f64::from(rate.rollouts))
}

/// A pooled statistic as a cell.
pub(super) fn cell(pooled: Option<Pooled>, bound: Bound) -> Cell {
    some(pooled, |pooled| Cell::Pooled(pooled, bound))
}

/// Things of runs, where the run has such a thing.
pub(super) fn of_runs<'a, T>(
    runs: impl IntoIterator<Item = &'a RunRecord>,
    thing: impl Fn(&'a RunRecord) -> Option<T>,
) -> Vec<(&'a RunRecord, T)> {
    runs.into_iter().filter_map(|run| Some((run, thing(run)?))).collect()
}

/// The share of rollouts that succeeded, over runs.
pub(super) fn success<'a>(runs: impl IntoIterator<Item = &'a RunRecord>, rate: fn(&RunRecord) -> Option<Rate>) -> Cell {
    let pair = |rate: Rate| (f64::from(rate.successes), f64::from(rate.rollouts));
    cell(pooled_share(&of_runs(runs, |run| rate(run).map(pair))), Bound::Exact)
}

/// The same of success at some time in the rollout, if not at its end.
pub(super) fn once<'a>(runs: impl IntoIterator<Item = &'a RunRecord>) -> Cell {
    let pair = |rate: Rate| (f64::from(rate.once), f64::from(rate.rollouts));
    cell(pooled_share(&of_runs(runs, |run| run.after.map(pair))), Bound::Exact)
}

/// The share of things of runs that are so; each run has a number of those that are, and a number of all.
pub(super) fn share_of(of: &OfRuns<'_, (f64, f64)>) -> Cell {
    cell(pooled_share(of), Bound::Exact)
}

/// The mean of a quantity over runs that have it.
pub(super) fn mean<'a>(
    runs: impl IntoIterator<Item = &'a RunRecord>,
    quantity: impl Fn(&RunRecord) -> Option<f64>,
) -> Cell {
    cell(pooled_ratio(&of_runs(runs, |run| Some((quantity(run)?, 1.0)))), Bound::Exact)
}

/// The median of things of runs.
pub(super) fn median(of: &OfRuns<'_, f64>) -> Cell {
    let statistic = |values: &mut dyn Iterator<Item = &f64>| stats::median(&values.copied().collect::<Vec<_>>());
    cell(pooled_by(of, statistic), Bound::Exact)
}

/// The interquartile mean of success over runs, the last demonstration given.
pub(super) fn interquartile_mean<'a>(runs: impl IntoIterator<Item = &'a RunRecord>) -> Cell {
    let statistic =
        |values: &mut dyn Iterator<Item = &f64>| stats::interquartile_mean(&values.copied().collect::<Vec<_>>());
    cell(pooled_by(&of_runs(runs, |run| share(run.after)), statistic), Bound::Exact)
}

/// The mean effort over runs: a lower bound where one of them did not reach the target.
pub(super) fn effort<'a>(runs: impl IntoIterator<Item = &'a RunRecord>, measure: fn(&RunRecord) -> f64) -> Cell {
    let of = of_runs(runs, |run| Some((measure(run), 1.0)));
    let bound = Bound::of(of.iter().all(|(run, _)| run.is_reached()), true);
    cell(pooled_ratio(&of), bound)
}

/// The ratio of the effort of runs to that of their partners.
pub(super) fn effort_ratio(pairs: &[(&RunRecord, &RunRecord)], measure: fn(&RunRecord) -> f64) -> Cell {
    let of: Vec<_> = pairs.iter().map(|(own, other)| (*own, (measure(own), measure(other)))).collect();
    let reached = |of: fn(&(&RunRecord, &RunRecord)) -> bool| pairs.iter().all(of);
    let bound = Bound::of(reached(|pair| pair.0.is_reached()), reached(|pair| pair.1.is_reached()));
    cell(pooled_ratio(&of), bound)
}

/// The mean difference of two quantities of runs, over the runs that have both.
pub(super) fn difference<'a>(of: impl Iterator<Item = (&'a RunRecord, Option<f64>, Option<f64>)>) -> Cell {
    let of: Vec<_> = of.filter_map(|(run, own, other)| Some((run, (own? - other?, 1.0)))).collect();
    cell(pooled_ratio(&of), Bound::Exact)
}

/// The number of units of these runs.
pub(super) fn units<'a>(runs: impl IntoIterator<Item = &'a RunRecord>) -> usize {
    runs.into_iter().map(unit).collect::<BTreeSet<_>>().len()
}

/// The number of their variations.
pub(super) fn variations<'a>(runs: impl IntoIterator<Item = &'a RunRecord>) -> usize {
    runs.into_iter().map(variation).collect::<BTreeSet<_>>().len()
}
