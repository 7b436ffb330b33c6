//! T4: how long one update takes, and how long the slowest: of many corrections on one automaton.

use std::collections::BTreeMap;

use situ::edit::Edit;

use super::cost::MILLISECONDS_PER_SECOND;
use super::{Cell, MethodName, Methods, Shape, Table, column, made, median, number, seed, wall};
use crate::record::{Cost, Record};
use crate::stats;

const LATENCY: &str = "Synthetic automata, many planted corrections of each edit on each, one thread: the wall-clock time of a whole correction, and \
of one of its segments (a local update). The median has a 95 % bootstrap interval; p99 is the 99th percentile, with what the machine did beside it \
in it. Only series with more than one correction an automaton are here.";
/// The percentile beside the median.
const SLOW: f64 = 0.99;

type Row<'a> = (&'a str, &'a str, MethodName, Edit, u32);

/// Times of updates, from records in canonical order.
pub(super) fn latency(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<&Cost>> = BTreeMap::new();
    for record in records {
        if let Record::Cost(cost) = record {
            let row = (&*cost.protocol, &*cost.series, methods.name(&cost.method), cost.edit, cost.nodes);
            rows.entry(row).or_default().push(cost);
        }
    }
    rows.retain(|_, costs| costs.iter().any(|cost| cost.correction > 0));
    let rendered = rows.iter().map(|((protocol, series, method, edit, nodes), costs)| {
        let label = format!("t4/latency/{protocol}/{series}/{}/{edit}/{nodes}", method.name);
        let segments: Vec<f64> = costs.iter().map(|cost| cost.model_size.len() as f64).collect();
        let times: Vec<f64> = costs.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND).collect();
        // A full retraining has no local updates.
        let of_segments: Vec<f64> =
            times.iter().zip(&segments).filter(|(_, count)| **count > 0.0).map(|(time, count)| time / count).collect();
        let mut cells =
            [*protocol, *series, &*method.name, edit.name()].map(|word| Cell::Text(word.to_owned())).to_vec();
        cells.extend([*nodes as usize, costs.len()].map(Cell::Count));
        cells.push(made(costs.iter().map(|cost| cost.edit_made)));
        cells.push(number(stats::median(&segments)));
        for (quantity, times) in [("correction", &times), ("segment", &of_segments)] {
            cells.extend([median(times, seed(&label, quantity)), number(stats::quantile(times, SLOW))]);
        }
        cells
    });
    let columns = ["protocol", "series", "method", "edit_planted"]
        .map(|name| column(name, Shape::Text))
        .into_iter()
        .chain(["nodes", "corrections"].map(|name| column(name, Shape::Count)))
        .chain([column("edit_made", Shape::Text), column("segments", Shape::Number(0))])
        .chain([wall("update_ms", Shape::Estimate(2)), wall("update_p99_ms", Shape::Number(2))])
        .chain([wall("segment_ms", Shape::Estimate(2)), wall("segment_p99_ms", Shape::Number(2))]);
    Table {
        id: "t4_latency",
        title: "T4 time of one update, and of the slowest",
        note: LATENCY,
        columns: columns.collect(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}
