//! T4: what an update of a synthetic automaton costs, how that grows, from which size on a local update is the cheaper
//! one, and how long the slowest updates take.

use std::collections::{BTreeMap, BTreeSet};

use situ::edit::Edit;

use super::column::{
    COUNTERS, Cell, Columns, MILLISECONDS_PER_SECOND, Shape, estimate, made, median, medians, middle, some,
};
use super::pooled::draws;
use super::rows::{self, MethodName, rows};
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{CostRecord, Record};
use crate::stats;

const SCALING: Title = Title {
    id: "t4_scaling",
    text: "T4 update cost by the size of the task model",
    note: "Synthetic automata, one planted correction each: median exact work of the update, and its time. The ratio \
        is that method's cost divided by that of `situ` on the same automata, of sums over seeds and corrections, with \
        a 95 % bootstrap interval by these pairs. A series varies one thing: the nodes with |Z| held fixed, the nodes \
        with |Z| left free, or the original demonstrations.",
};
const SLOPES: Title = Title {
    id: "t4_slopes",
    text: "T4 growth of the update cost",
    note: "Slope of ln(cost) over the logarithm of what the series varies, by least squares over all its automata, \
        with Student's 95 % interval: 0 is a cost that does not depend on it, 1 one that grows in proportion. \
        `classifier evaluations` is the linear scan of A1.6. A dash: too few sizes, or a cost of 0.",
};
const CROSSOVER: Title = Title {
    id: "t4_crossover",
    text: "T4 crossover: the nodes below which retraining is cheaper",
    note: "The number of nodes below which full retraining is cheaper than `situ`, where the fitted power laws of the \
        two meet: in exact work and by the clock. `< n`: below the smallest automaton that was measured, `situ` is \
        cheaper at all of them; `never`: the lines do not meet above it.",
};
const LATENCY: Title = Title {
    id: "t4_latency",
    text: "T4 time of one update, and of the slowest",
    note: "Synthetic automata, many planted corrections of each edit on each, one thread: the wall-clock time of a \
        whole correction, and of one of its segments (a local update). The median has a 95 % bootstrap interval; p99 \
        is the 99th percentile, with what the machine did beside it in it. Only series with more than one correction \
        an automaton are here.",
};

/// The percentile beside the median.
const SLOW: f64 = 0.99;

/// The method that others' costs are divided by.
const SITU: &str = "situ";

/// The key of a row.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key<'a> {
    protocol: &'a str,
    series: &'a str,
    method: MethodName<'a>,
    edit: Edit,
    /// Where each size has a row of its own.
    nodes: Option<u32>,
    /// Where each number of originals has.
    originals: Option<u32>,
}

type Costs<'a> = rows::Row<Key<'a>, &'a CostRecord>;

struct Row<'a> {
    row: Costs<'a>,
    /// The costs of `situ` in the row's place; `None` in its own rows.
    situ: Option<Vec<&'a CostRecord>>,
}

/// The rows of all synthetic updates. `size` gives the nodes and the originals that have rows of their own.
fn costs<'a>(records: &'a Canonical, size: fn(&CostRecord) -> [Option<u32>; 2]) -> Vec<Costs<'a>> {
    let costs = records.iter().filter_map(|record| if let Record::Cost(cost) = record { Some(cost) } else { None });
    let key = |cost: &'a CostRecord| {
        let (protocol, series, method) = (&*cost.protocol, &*cost.series, MethodName::of(&cost.method));
        let [nodes, originals] = size(cost);
        Key { protocol, series, method, edit: cost.edit, nodes, originals }
    };
    rows(costs.map(|cost| (key(cost), cost)))
}

/// These rows, each with the costs of `situ` in its place.
fn beside_situ<'a>(rows: Vec<Costs<'a>>) -> Vec<Row<'a>> {
    let wanted = MethodName::of(SITU);
    let situ: BTreeMap<_, _> =
        rows.iter().filter(|row| row.key.method == wanted).map(|row| (row.key, row.of.clone())).collect();
    let beside = |row: Costs<'a>| {
        let situ = situ.get(&Key { method: wanted, ..row.key }).filter(|_| row.key.method != wanted).cloned();
        Row { row, situ }
    };
    rows.into_iter().map(beside).collect()
}

fn table<'a>(title: Title, columns: Columns<'a, Row<'a>>, rows: &[Row<'a>]) -> Table {
    Table::new(title, columns, rows, rows.iter().map(|row| (row.row.key.protocol, row.row.of.len())))
}

fn words<'a, R: 'a>(key: fn(&R) -> Key<'a>) -> Columns<'a, R> {
    Columns::new()
        .text("protocol", move |row| key(row).protocol)
        .text("series", move |row| key(row).series)
        .text("method", move |row| key(row).method.name)
        .text("edit_planted", move |row| key(row).edit.name())
}

impl Row<'_> {
    /// The ratio of a cost to that of `situ` on the same automata.
    fn to_situ(&self, of: fn(&CostRecord) -> f64) -> Cell {
        let pair = |cost: &&CostRecord| {
            let place = |cost: &CostRecord| (cost.seed, cost.correction);
            let other = self.situ.as_ref()?.iter().find(|other| place(other) == place(cost))?;
            Some((of(cost), of(other)))
        };
        let pairs: Vec<(f64, f64)> = self.row.of.iter().filter_map(pair).collect();
        estimate(stats::paired_ratio(&pairs, draws()))
    }

    /// The slope of a cost over the quantity that the series varies.
    fn slope(&self, of: impl Fn(&CostRecord) -> f64) -> Cell {
        let size = axis(&self.row.of).1;
        let points: Vec<(f64, f64)> = self.row.of.iter().map(|cost| (size(cost), of(cost))).collect();
        estimate(stats::power_law(&points).map(|law| law.exponent))
    }

    /// Where the cost of `situ` meets this one.
    fn meets(&self, of: fn(&CostRecord) -> f64) -> Cell {
        some(self.situ.as_ref().and_then(|situ| crossing(situ, &self.row.of, of)), Cell::Text)
    }
}

/// Cost of updates by the size of the automaton.
pub(super) fn scaling(records: &Canonical) -> Table {
    let columns = words::<Row>(|row| row.row.key)
        .count("nodes", |row| row.row.key.nodes.unwrap_or_default())
        .count("originals", |row| row.row.key.originals.unwrap_or_default())
        .count("automata", |row| row.row.of.len())
        .text("edit_made", |row| made(row.row.of.iter().map(|cost| [cost.edit_made].into())))
        .column("|Z|", Shape::Number(1), |row| {
            let applicable = row.row.of.iter().flat_map(|cost| &cost.applicable);
            middle(applicable.map(|z| f64::from(*z)))
        });
    let columns = medians(columns, |row| row.row.of.iter().map(|cost| cost.counters).collect());
    let columns = columns
        .column("hmm_fits_ratio", Shape::Estimate(1), |row| row.to_situ(|cost| cost.counters.hmm_fits as f64))
        .wall("update_ms", Shape::Estimate(3), |row| {
            let times = row.row.of.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND);
            median(times)
        })
        .wall("ratio", Shape::Estimate(1), |row| row.to_situ(|cost| cost.update_seconds));
    let rows = costs(records, |cost| [Some(cost.nodes), Some(cost.originals)]);
    table(SCALING, columns, &beside_situ(rows))
}

/// The rows with one for all sizes of a series.
fn all_sizes(records: &Canonical) -> Vec<Row<'_>> {
    beside_situ(costs(records, |_| [None, None]))
}

/// The quantity that a series varies, and its value for an automaton.
fn axis(costs: &[&CostRecord]) -> (&'static str, fn(&CostRecord) -> f64) {
    let sizes: BTreeSet<u32> = costs.iter().map(|cost| cost.nodes).collect();
    if sizes.len() > 1 {
        ("nodes", |cost| f64::from(cost.nodes))
    } else {
        ("originals", |cost| f64::from(cost.originals))
    }
}

/// How the costs of updates grow.
pub(super) fn slopes(records: &Canonical) -> Table {
    let mean = |z: &[u32]| stats::mean(&z.iter().map(|z| f64::from(*z)).collect::<Vec<_>>()).unwrap_or_default();
    let columns = words::<Row>(|row| row.row.key)
        .text("over", |row| axis(&row.row.of).0)
        .count("automata", |row| row.row.of.len())
        .column("|Z|", Shape::Estimate(2), move |row| row.slope(|cost| mean(&cost.applicable)));
    let columns = COUNTERS.into_iter().enumerate().fold(columns, |columns, (index, name)| {
        columns.column(name, Shape::Estimate(2), move |row| row.slope(|cost| cost.counters.named()[index].1 as f64))
    });
    let columns = columns.wall("update_time", Shape::Estimate(2), |row| row.slope(|cost| cost.update_seconds));
    table(SLOPES, columns, &all_sizes(records))
}

/// From which size on `situ` is cheaper.
pub(super) fn crossover(records: &Canonical) -> Table {
    let columns = words::<Row>(|row| row.row.key)
        .text("hmm_fits", |row| row.meets(|cost| cost.counters.hmm_fits as f64))
        .text("em_iterations", |row| row.meets(|cost| cost.counters.em_iterations as f64))
        .text("classifier_fits", |row| row.meets(|cost| cost.counters.classifier_fits as f64))
        .wall("update_time", Shape::Text, |row| row.meets(|cost| cost.update_seconds));
    let mut rows = all_sizes(records);
    // A full retraining has no local update.
    rows.retain(|row| axis(&row.row.of).0 == "nodes" && row.row.of.iter().all(|cost| cost.applicable.is_empty()));
    let source = rows.iter().map(|row| (row.row.key.protocol, row.row.of.len())).collect::<Vec<_>>();
    rows.retain(|row| row.situ.is_some());
    Table::new(CROSSOVER, columns, &rows, source.into_iter())
}

/// Where the power laws of two costs meet, in words; `None` where one of them has none.
fn crossing(situ: &[&CostRecord], other: &[&CostRecord], of: fn(&CostRecord) -> f64) -> Option<String> {
    let law = |costs: &[&CostRecord]| {
        let points: Vec<(f64, f64)> = costs.iter().map(|cost| (f64::from(cost.nodes), of(cost))).collect();
        stats::power_law(&points)
    };
    let (situ_law, other_law) = (law(situ)?, law(other)?);
    let least = situ.iter().chain(other).map(|cost| cost.nodes).min()?;
    let growth = other_law.exponent.value - situ_law.exponent.value;
    let apart = situ_law.log_factor - other_law.log_factor;
    if growth <= 0.0 {
        return Some("never".to_owned());
    }
    let nodes = libm::exp(apart / growth);
    Some(if nodes < f64::from(least) { format!("< {least}") } else { format!("{nodes:.0}") })
}

/// The local updates of a correction.
fn segments(cost: &CostRecord) -> f64 {
    cost.model_size.len() as f64
}

/// Milliseconds of each whole correction.
fn of_corrections(row: &Costs) -> Vec<f64> {
    row.of.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND).collect()
}

/// Milliseconds of a local update, on the average of each correction. A full retraining has no local updates.
fn of_segments(row: &Costs) -> Vec<f64> {
    let times = of_corrections(row).into_iter().zip(row.of.iter().map(|cost| segments(cost)));
    times.filter(|(_, count)| *count > 0.0).map(|(time, count)| time / count).collect()
}

fn slowest(times: &[f64]) -> Cell {
    some(stats::quantile(times, SLOW), Cell::Number)
}

/// Times of updates.
pub(super) fn latency(records: &Canonical) -> Table {
    let columns = words::<Costs>(|row| row.key)
        .count("nodes", |row| row.key.nodes.unwrap_or_default())
        .count("corrections", |row| row.of.len())
        .text("edit_made", |row| made(row.of.iter().map(|cost| [cost.edit_made].into())))
        .column("segments", Shape::Number(0), |row| middle(row.of.iter().map(|cost| segments(cost))))
        .wall("update_ms", Shape::Estimate(2), |row| median(of_corrections(row)))
        .wall("update_p99_ms", Shape::Number(2), |row| slowest(&of_corrections(row)))
        .wall("segment_ms", Shape::Estimate(2), |row| median(of_segments(row)))
        .wall("segment_p99_ms", Shape::Number(2), |row| slowest(&of_segments(row)));
    let mut rows = costs(records, |cost| [Some(cost.nodes), None]);
    rows.retain(|row| row.of.iter().any(|cost| cost.correction > 0));
    Table::new(LATENCY, columns, &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}
