//! T4: what an update costs, in exact counters and in time, against the size of the task model.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::trace::Counters;

use super::{Cell, Column, MethodName, Methods, Shape, Table, column, estimate, made, median, number, seed, wall};
use crate::record::{Correction, Cost, Record};
use crate::stats;

/// The method that others' costs are divided by.
const SITU: &str = "situ";
const MILLISECONDS_PER_SECOND: f64 = 1000.0;

const PHYSICS: &str = "Corrections in physics, over all tasks, teachers and seeds whose run counts: |Z| applicable primitives and |T| \
primitives at each local update (a full retraining has none), median exact work of a correction, and its time. Medians of |Z|/|T| \
and of the time have 95 % bootstrap intervals.";
const SCALING: &str = "Synthetic automata of known size, one planted correction each: median exact work of the update, and its time. \
The ratio is that method's cost divided by that of `situ` on the same automata, paired by seed, with a 95 % bootstrap interval.";
const SLOPES: &str = "Slope of ln(cost) over ln(nodes) by least squares over all synthetic automata, with Student's 95 % interval: 0 is \
a cost that does not depend on the size of the task model, 1 one that grows in proportion. `classifier evaluations` is the linear scan \
of A1.6. A dash: too few sizes, or a cost of 0.";

/// The exact counters, in the order of [`Counters::named`].
const COUNTERS: [&str; 7] = [
    "hmm_fits",
    "em_iterations",
    "divergences",
    "classifier_fits",
    "classifier_evaluations",
    "nodes_touched",
    "segments_touched",
];

fn counter_columns(shape: Shape) -> impl Iterator<Item = Column> {
    COUNTERS.into_iter().map(move |name| column(name, shape))
}

/// The values of one counter.
fn counted(counters: &[Counters], index: usize) -> Vec<f64> {
    counters.iter().map(|counters| counters.named()[index].1 as f64).collect()
}

fn medians(counters: &[Counters]) -> impl Iterator<Item = Cell> {
    (0..COUNTERS.len()).map(|index| number(stats::median(&counted(counters, index))))
}

/// The row of a table: protocol, method, edit, and the nodes of the automaton where it is synthetic.
type Row<'a> = (&'a str, MethodName, Edit, u32);

fn label(table: &str, (protocol, method, edit, nodes): &Row) -> String {
    format!("t4/{table}/{protocol}/{}/{edit}/{nodes}", method.name)
}

fn words((protocol, method, edit, _): &Row) -> Vec<Cell> {
    [*protocol, &method.name, edit.name()].map(|word| Cell::Text(word.to_owned())).to_vec()
}

fn word_columns(edit: &'static str) -> impl Iterator<Item = Column> {
    ["protocol", "method", edit].into_iter().map(|name| column(name, Shape::Text))
}

/// Cost of the corrections in physics, from records in canonical order.
pub(super) fn physics(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<&Correction>> = BTreeMap::new();
    let mut runs = 0;
    for record in records {
        if let Some(run) = record.single_run()
            && run.outcome.counts()
            && !run.corrections.is_empty()
        {
            let row = (run.key.protocol.as_str(), methods.name(&run.key.method), run.key.edit, 0);
            rows.entry(row).or_default().extend(&run.corrections);
            runs += 1;
        }
    }
    let rendered = rows.iter().map(|(row, corrections)| {
        let label = label("physics", row);
        let steps = || corrections.iter().flat_map(|correction| &correction.steps);
        let (z, t) = (steps().map(|step| f64::from(step.applicable)), steps().map(|step| f64::from(step.model_size)));
        let (z, t): (Vec<f64>, Vec<f64>) = (z.collect(), t.collect());
        // A step in a model without primitives has no ratio.
        let ratios: Vec<f64> = z.iter().zip(&t).filter(|(_, t)| **t > 0.0).map(|(z, t)| z / t).collect();
        let counters: Vec<Counters> = corrections.iter().map(|correction| correction.counters).collect();
        let times: Vec<f64> =
            corrections.iter().map(|correction| correction.update_seconds * MILLISECONDS_PER_SECOND).collect();
        let mut cells = words(row);
        cells.extend([Cell::Count(corrections.len()), Cell::Count(z.len())]);
        cells.extend([number(stats::median(&z)), number(stats::median(&t)), median(&ratios, seed(&label, "ratio"))]);
        cells.extend(medians(&counters));
        cells.push(median(&times, seed(&label, "time")));
        cells
    });
    let sizes =
        [column("|Z|", Shape::Number(1)), column("|T|", Shape::Number(1)), column("|Z|/|T|", Shape::Estimate(2))];
    let columns = word_columns("edit_needed")
        .chain(["corrections", "steps"].map(|name| column(name, Shape::Count)))
        .chain(sizes)
        .chain(counter_columns(Shape::Number(1)))
        .chain([wall("update_ms", Shape::Estimate(3))]);
    Table {
        id: "t4_physics",
        title: "T4 update cost in physics",
        note: PHYSICS,
        columns: columns.collect(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: runs,
    }
}

fn by_size<'a>(records: &'a [Record], methods: &Methods, sized: bool) -> BTreeMap<Row<'a>, Vec<&'a Cost>> {
    let mut rows: BTreeMap<Row, Vec<&Cost>> = BTreeMap::new();
    for record in records {
        if let Record::Cost(cost) = record {
            let nodes = if sized { cost.nodes } else { 0 };
            let row = (cost.protocol.as_str(), methods.name(&cost.method), cost.edit, nodes);
            rows.entry(row).or_default().push(cost);
        }
    }
    rows
}

/// Cost of updates of synthetic automata by their size, from records in canonical order.
pub(super) fn scaling(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let rows = by_size(records, &methods, true);
    let rendered = rows.iter().map(|(row, costs)| {
        let label = label("scaling", row);
        let counters: Vec<Counters> = costs.iter().map(|cost| cost.counters).collect();
        let times: Vec<f64> = costs.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND).collect();
        let applicable: Vec<f64> = costs.iter().flat_map(|cost| &cost.applicable).map(|z| f64::from(*z)).collect();
        let own = row.1.name == SITU;
        let situ = (!own).then(|| rows.get(&(row.0, methods.name(SITU), row.2, row.3))).flatten();
        let ratio = |quantity, of: fn(&Cost) -> f64| {
            let pairs: Vec<(f64, f64)> = costs
                .iter()
                .filter_map(|cost| {
                    let other = situ?.iter().find(|other| other.seed == cost.seed)?;
                    Some((of(cost), of(other)))
                })
                .collect();
            estimate(stats::paired_ratio(&pairs, seed(&label, quantity)))
        };
        let mut cells = words(row);
        cells.extend([Cell::Count(row.3 as usize), Cell::Count(costs.len())]);
        cells.push(made(costs.iter().map(|cost| cost.edit_made)));
        cells.push(number(stats::median(&applicable)));
        cells.extend(medians(&counters));
        cells.push(ratio("hmm_fits", |cost| cost.counters.hmm_fits as f64));
        cells.push(median(&times, seed(&label, "time")));
        cells.push(ratio("time", |cost| cost.update_seconds));
        cells
    });
    let columns = word_columns("edit_planted")
        .chain(["nodes", "automata"].map(|name| column(name, Shape::Count)))
        .chain([column("edit_made", Shape::Text), column("|Z|", Shape::Number(1))])
        .chain(counter_columns(Shape::Number(1)))
        .chain([column("hmm_fits_ratio", Shape::Estimate(1))])
        .chain([wall("update_ms", Shape::Estimate(3)), wall("ratio", Shape::Estimate(1))]);
    Table {
        id: "t4_scaling",
        title: "T4 update cost by the size of the task model",
        note: SCALING,
        columns: columns.collect(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}

/// How the costs of updates grow with the size of synthetic automata, from records in canonical order.
pub(super) fn slopes(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let rows = by_size(records, &methods, false);
    let rendered = rows.iter().map(|(row, costs)| {
        let nodes: Vec<f64> = costs.iter().map(|cost| f64::from(cost.nodes)).collect();
        let slope = |of: &dyn Fn(&Cost) -> f64| {
            let points: Vec<(f64, f64)> = nodes.iter().zip(costs).map(|(nodes, cost)| (*nodes, of(cost))).collect();
            estimate(stats::log_log_slope(&points))
        };
        let mean = |z: &[u32]| stats::mean(&z.iter().map(|z| f64::from(*z)).collect::<Vec<_>>()).unwrap_or_default();
        let mut cells = words(row);
        cells.push(Cell::Count(costs.len()));
        cells.push(slope(&|cost| mean(&cost.applicable)));
        cells.extend((0..COUNTERS.len()).map(|index| slope(&|cost| cost.counters.named()[index].1 as f64)));
        cells.push(slope(&|cost| cost.update_seconds));
        cells
    });
    let columns = word_columns("edit_planted")
        .chain([column("automata", Shape::Count), column("|Z|", Shape::Estimate(2))])
        .chain(counter_columns(Shape::Estimate(2)))
        .chain([wall("update_time", Shape::Estimate(2))]);
    Table {
        id: "t4_slopes",
        title: "T4 growth of the update cost with the task model",
        note: SLOPES,
        columns: columns.collect(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}
