//! T4: what the corrections of runs in physics cost, in exact counters and in time.

use situ::edit::Edit;

use super::cell::{median, middle, seed};
use super::column::{Columns, Shape};
use super::counters::{MILLISECONDS_PER_SECOND, medians};
use super::method_name::{MethodName, Methods};
use super::row::{self, rows};
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{CorrectionRecord, Record, RunRecord, StepSummary};

const TITLE: Title = Title {
    id: "t4_physics",
    text: "T4 update cost in physics",
    note: "Corrections in physics, over all tasks, teachers and seeds whose run counts: |Z| applicable primitives and \
        |T| primitives at each local update (a full retraining has none), median exact work of a correction, and its \
        time. Medians of |Z|/|T| and of the time have 95 % bootstrap intervals.",
};

/// Protocol, method, and the edit that the variation needs.
type Row<'a> = row::Row<(&'a str, MethodName<'a>, Edit), &'a RunRecord>;

fn corrections<'a>(row: &Row<'a>) -> impl Iterator<Item = &'a CorrectionRecord> {
    row.of.iter().flat_map(|run| &run.corrections)
}

/// A number of each local update.
fn steps(row: &Row, of: fn(&StepSummary) -> u32) -> Vec<f64> {
    corrections(row).flat_map(|correction| &correction.steps).map(|step| f64::from(of(step))).collect()
}

fn row_seed(row: &Row, quantity: &str) -> u64 {
    let (protocol, method, edit) = row.key;
    seed(&format!("t4/physics/{protocol}/{}/{edit}", method.name), quantity)
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("method", |row| row.key.1.name)
        .text("edit_needed", |row| row.key.2.name())
        .count("corrections", |row| corrections(row).count())
        .count("steps", |row| steps(row, |step| step.applicable).len())
        .column("|Z|", Shape::Number(1), |row| middle(&steps(row, |step| step.applicable)))
        .column("|T|", Shape::Number(1), |row| middle(&steps(row, |step| step.model_size)))
        .column("|Z|/|T|", Shape::Estimate(2), |row| {
            let (z, t) = (steps(row, |step| step.applicable), steps(row, |step| step.model_size));
            // A step in a model without primitives has no ratio.
            let ratios: Vec<f64> = z.iter().zip(&t).filter(|(_, t)| **t > 0.0).map(|(z, t)| z / t).collect();
            median(&ratios, row_seed(row, "ratio"))
        });
    medians(columns, |row| corrections(row).map(|correction| correction.counters).collect()).wall(
        "update_ms",
        Shape::Estimate(3),
        |row| {
            let times = corrections(row).map(|correction| correction.update_seconds * MILLISECONDS_PER_SECOND);
            median(&times.collect::<Vec<_>>(), row_seed(row, "time"))
        },
    )
}

/// Cost of the corrections in physics.
pub(super) fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let runs = records.iter().filter_map(Record::single_run);
    let corrected = runs.filter(|run| run.outcome.counts() && !run.corrections.is_empty());
    let rows: Vec<Row> =
        rows(corrected.map(|run| ((&*run.key.protocol, methods.name(&run.key.method), run.key.edit), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
