//! T4: what the corrections of runs in physics cost, in exact counters and in time.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::trace::Counters;

use super::{Cell, Column, MethodName, Methods, Shape, Table, column, median, number, seed, wall};
use crate::record::{Correction, Record};
use crate::stats;

pub(super) const MILLISECONDS_PER_SECOND: f64 = 1000.0;

const PHYSICS: &str = "Corrections in physics, over all tasks, teachers and seeds whose run counts: |Z| applicable primitives and |T| \
primitives at each local update (a full retraining has none), median exact work of a correction, and its time. Medians of |Z|/|T| \
and of the time have 95 % bootstrap intervals.";
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

pub(super) fn counter_columns(shape: Shape) -> impl Iterator<Item = Column> {
    COUNTERS.into_iter().map(move |name| column(name, shape))
}

/// The values of one counter.
fn counted(counters: &[Counters], index: usize) -> Vec<f64> {
    counters.iter().map(|counters| counters.named()[index].1 as f64).collect()
}

pub(super) fn medians(counters: &[Counters]) -> impl Iterator<Item = Cell> {
    (0..COUNTERS.len()).map(|index| number(stats::median(&counted(counters, index))))
}

type Row<'a> = (&'a str, MethodName, Edit);

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
            let row = (run.key.protocol.as_str(), methods.name(&run.key.method), run.key.edit);
            rows.entry(row).or_default().extend(&run.corrections);
            runs += 1;
        }
    }
    let rendered = rows.iter().map(|((protocol, method, edit), corrections)| {
        let label = format!("t4/physics/{protocol}/{}/{edit}", method.name);
        let steps = || corrections.iter().flat_map(|correction| &correction.steps);
        let (z, t) = (steps().map(|step| f64::from(step.applicable)), steps().map(|step| f64::from(step.model_size)));
        let (z, t): (Vec<f64>, Vec<f64>) = (z.collect(), t.collect());
        // A step in a model without primitives has no ratio.
        let ratios: Vec<f64> = z.iter().zip(&t).filter(|(_, t)| **t > 0.0).map(|(z, t)| z / t).collect();
        let counters: Vec<Counters> = corrections.iter().map(|correction| correction.counters).collect();
        let times: Vec<f64> =
            corrections.iter().map(|correction| correction.update_seconds * MILLISECONDS_PER_SECOND).collect();
        let mut cells = [*protocol, &method.name, edit.name()].map(|word| Cell::Text(word.to_owned())).to_vec();
        cells.extend([Cell::Count(corrections.len()), Cell::Count(z.len())]);
        cells.extend([number(stats::median(&z)), number(stats::median(&t)), median(&ratios, seed(&label, "ratio"))]);
        cells.extend(medians(&counters));
        cells.push(median(&times, seed(&label, "time")));
        cells
    });
    let sizes =
        [column("|Z|", Shape::Number(1)), column("|T|", Shape::Number(1)), column("|Z|/|T|", Shape::Estimate(2))];
    let columns = ["protocol", "method", "edit_needed"]
        .map(|name| column(name, Shape::Text))
        .into_iter()
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
