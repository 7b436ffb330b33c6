//! T4: what the corrections of runs in physics cost, in exact counters and in time.

use super::column::{Columns, MILLISECONDS_PER_SECOND, Shape, medians, middle};
use super::growth;
use super::measure::{median, share_of};
use super::rows::{self, MethodKey, method_columns, method_key, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::correction_record::{CorrectionRecord, StepSummary};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

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
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t4_physics",
    text: "T4 update cost in physics",
    note: "Corrections in physics, over all tasks, teachers and seeds whose run counts: |Z| applicable primitives and \
        |T| primitives at each local update (a full retraining has none), median exact work of a correction, and its \
        time. `held` are the segments whose skill, as the teacher calls it, some primitive held; `A1.6 right` is the \
        share of them in which the applicable primitives, the index of line A1.6 alone, had such a one among them. A \
        step in a model without primitives has no |Z|/|T|. Medians of |Z|/|T| and of the time, and that share, have \
        two 95 % bootstrap intervals: by units (family × seed) and by variations.",
};

type Row<'a> = rows::Row<MethodKey<'a>, &'a RunRecord>;

fn corrections<'a>(row: &Row<'a>) -> impl Iterator<Item = &'a CorrectionRecord> {
    row.of.iter().flat_map(|run| &run.corrections)
}

/// A number of each local update.
fn steps(row: &Row, of: fn(&StepSummary) -> u32) -> Vec<f64> {
    corrections(row).flat_map(|correction| &correction.steps).map(|step| f64::from(of(step))).collect()
}

/// Something of each local update, with its run.
fn of_steps<'a, T>(row: &Row<'a>, of: impl Fn(&'a StepSummary) -> Option<T>) -> Vec<(&'a RunRecord, T)> {
    let steps = row
        .of
        .iter()
        .flat_map(|run| run.corrections.iter().flat_map(|correction| &correction.steps).map(move |step| (*run, step)));
    steps.filter_map(|(run, step)| Some((run, of(step)?))).collect()
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.key)
        .count("corrections", |row| corrections(row).count())
        .count("steps", |row| steps(row, |step| step.applicable).len())
        .column("|Z|", Shape::Number(1), |row| middle(steps(row, |step| step.applicable)))
        .column("|T|", Shape::Number(1), |row| middle(steps(row, |step| step.model_size)))
        .column("|Z|/|T|", Shape::Pooled(2), |row| {
            // A step in a model without primitives has no ratio.
            let ratio = |step: &StepSummary| {
                (step.model_size > 0).then(|| f64::from(step.applicable) / f64::from(step.model_size))
            };
            median(&of_steps(row, ratio))
        })
        .count("held", |row| of_steps(row, |step| step.retrieved).len())
        .column("A1.6_right", Shape::Pooled(2), |row| {
            let found = |step: &StepSummary| Some((f64::from(u8::from(step.retrieved?)), 1.0));
            share_of(&of_steps(row, found))
        });
    medians(columns, |row| corrections(row).map(|correction| correction.counters).collect()).wall(
        "update_ms",
        Shape::Pooled(3),
        |row| {
            let of = row.of.iter().flat_map(|run| run.corrections.iter().map(move |correction| (*run, correction)));
            let times = of.map(|(run, correction)| (run, correction.update_seconds * MILLISECONDS_PER_SECOND));
            median(&times.collect::<Vec<_>>())
        },
    )
}

/// Cost of the corrections in physics.
fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let corrected = runs.filter(|run| run.outcome.counts() && !run.corrections.is_empty());
    let rows: Vec<Row> = rows(corrected.map(|run| (method_key(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
