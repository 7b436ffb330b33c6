//! T4: how long one update takes, and how long the slowest: of many corrections on one automaton.

use situ::edit::Edit;

use super::cell::{Cell, made, median, middle, seed, some};
use super::column::{Columns, Shape};
use super::counters::MILLISECONDS_PER_SECOND;
use super::method_name::{MethodName, Methods};
use super::row::{self, rows};
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{CostRecord, Record};
use crate::stats;

const TITLE: Title = Title {
    id: "t4_latency",
    text: "T4 time of one update, and of the slowest",
    note: "Synthetic automata, many planted corrections of each edit on each, one thread: the wall-clock time of a \
        whole correction, and of one of its segments (a local update). The median has a 95 % bootstrap interval; p99 \
        is the 99th percentile, with what the machine did beside it in it. Only series with more than one correction \
        an automaton are here.",
};

/// The percentile beside the median.
const SLOW: f64 = 0.99;

/// The key of a row.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key<'a> {
    protocol: &'a str,
    series: &'a str,
    method: MethodName<'a>,
    edit: Edit,
    nodes: u32,
}

type Row<'a> = row::Row<Key<'a>, &'a CostRecord>;

/// The local updates of a correction.
fn segments(cost: &CostRecord) -> f64 {
    cost.model_size.len() as f64
}

/// Milliseconds of each whole correction.
fn of_corrections(row: &Row) -> Vec<f64> {
    row.of.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND).collect()
}

/// Milliseconds of a local update, on the average of each correction. A full retraining has no local updates.
fn of_segments(row: &Row) -> Vec<f64> {
    let times = of_corrections(row).into_iter().zip(row.of.iter().map(|cost| segments(cost)));
    times.filter(|(_, count)| *count > 0.0).map(|(time, count)| time / count).collect()
}

fn row_seed(row: &Row, quantity: &str) -> u64 {
    let Key { protocol, series, method, edit, nodes } = &row.key;
    seed(&format!("t4/latency/{protocol}/{series}/{}/{edit}/{nodes}", method.name), quantity)
}

fn slowest(times: &[f64]) -> Cell {
    some(stats::quantile(times, SLOW), Cell::Number)
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.protocol)
        .text("series", |row| row.key.series)
        .text("method", |row| row.key.method.name)
        .text("edit_planted", |row| row.key.edit.name())
        .count("nodes", |row| row.key.nodes)
        .count("corrections", |row| row.of.len())
        .text("edit_made", |row| made(row.of.iter().map(|cost| cost.edit_made)))
        .column("segments", Shape::Number(0), |row| {
            middle(&row.of.iter().map(|cost| segments(cost)).collect::<Vec<_>>())
        })
        .wall("update_ms", Shape::Estimate(2), |row| median(&of_corrections(row), row_seed(row, "correction")))
        .wall("update_p99_ms", Shape::Number(2), |row| slowest(&of_corrections(row)))
        .wall("segment_ms", Shape::Estimate(2), |row| median(&of_segments(row), row_seed(row, "segment")))
        .wall("segment_p99_ms", Shape::Number(2), |row| slowest(&of_segments(row)))
}

/// Times of updates.
pub(super) fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let costs = records.iter().filter_map(|record| if let Record::Cost(cost) = record { Some(cost) } else { None });
    let mut rows: Vec<Row> = rows(costs.map(|cost| {
        let (protocol, series, method) = (&*cost.protocol, &*cost.series, methods.name(&cost.method));
        (Key { protocol, series, method, edit: cost.edit, nodes: cost.nodes }, cost)
    }));
    rows.retain(|row| row.of.iter().any(|cost| cost.correction > 0));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}
