//! T4: what the corrections of runs in physics cost, in exact counters and in time.

use super::column::{Columns, MILLISECONDS_PER_SECOND, Shape, median, medians, middle};
use super::growth;
use super::rows::{self, MethodKey, method_columns, method_key, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{CorrectionRecord, Record, RunRecord, StepSummary};

/// The publication.
pub(super) const T4: Publication = Publication {
    name: "t4",
    question: "What does an update cost, and how does that grow with the task model?",
    tables: |records| {
        vec![
            table(records),
            growth::scaling(records),
            growth::slopes(records),
            growth::crossover(records),
            growth::latency(records),
        ]
    },
};

const TITLE: Title = Title {
    id: "t4_physics",
    text: "T4 update cost in physics",
    note: "Corrections in physics, over all tasks, teachers and seeds whose run counts: |Z| applicable primitives and \
        |T| primitives at each local update (a full retraining has none), median exact work of a correction, and its \
        time. Medians of |Z|/|T| and of the time have 95 % bootstrap intervals.",
};

type Row<'a> = rows::Row<MethodKey<'a>, &'a RunRecord>;

fn corrections<'a>(row: &Row<'a>) -> impl Iterator<Item = &'a CorrectionRecord> {
    row.of.iter().flat_map(|run| &run.corrections)
}

/// A number of each local update.
fn steps(row: &Row, of: fn(&StepSummary) -> u32) -> Vec<f64> {
    corrections(row).flat_map(|correction| &correction.steps).map(|step| f64::from(of(step))).collect()
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.key)
        .count("corrections", |row| corrections(row).count())
        .count("steps", |row| steps(row, |step| step.applicable).len())
        .column("|Z|", Shape::Number(1), |row| middle(steps(row, |step| step.applicable)))
        .column("|T|", Shape::Number(1), |row| middle(steps(row, |step| step.model_size)))
        .column("|Z|/|T|", Shape::Estimate(2), |row| {
            let (z, t) = (steps(row, |step| step.applicable), steps(row, |step| step.model_size));
            // A step in a model without primitives has no ratio.
            median(z.iter().zip(&t).filter(|(_, t)| **t > 0.0).map(|(z, t)| z / t), row.seed("ratio"))
        });
    medians(columns, |row| corrections(row).map(|correction| correction.counters).collect()).wall(
        "update_ms",
        Shape::Estimate(3),
        |row| {
            let times = corrections(row).map(|correction| correction.update_seconds * MILLISECONDS_PER_SECOND);
            median(times, row.seed("time"))
        },
    )
}

/// Cost of the corrections in physics.
fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let corrected = runs.filter(|run| run.outcome.counts() && !run.corrections.is_empty());
    let label = |(protocol, method, edit): &MethodKey<'_>| format!("t4/physics/{protocol}/{method}/{edit}");
    let rows: Vec<Row> = rows(corrected.map(|run| (method_key(run), run)), label);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
