//! T5: what a corrected model still does: the original task, and the variations it met before.

use situ::method::Role;

use super::column::{Cell, Columns, Shape, mean, rate, some};
use super::rows::{self, CellKey, role, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

/// The publication.
pub(super) const T5: Publication = Publication {
    name: "t5",
    question: "What does a corrected model still do: the original task, and the changes it met before?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t5",
    text: "T5 retention: what a corrected model still does",
    note: "A row is a cell over its seeds, or a stage of a sequence, in which each variation is met with the model \
        that the one before left. `before` and `after` are success on the variation, `original before` and `original \
        after` on the original task, from the same starts; `earlier` is success on the variations of all earlier \
        stages after this one. Pooled over rollouts, with the Wilson 95 % interval; demonstrations are means over \
        seeds with a 95 % bootstrap interval, runs that used the budget up among them.",
};

type Row<'a> = rows::Row<CellKey<'a>, &'a RunRecord>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.protocol)
        .text("task", |row| row.key.task)
        .text("sequence", |row| some(row.key.stage, |stage| (&*stage.sequence).into()))
        .text("stage", |row| some(row.key.stage, |stage| Cell::Text(stage.number.to_string())))
        .text("variation", |row| row.key.variation)
        .text("edit_needed", |row| row.key.edit.name())
        .text("teacher", |row| row.key.teacher)
        .text("method", |row| row.key.method.name)
        .count("runs", |row| row.of.len())
        .column("before", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.before)))
        .column("after", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.after)))
        .column("original_before", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.original_rate)))
        .column("original_after", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.retained)))
        .column("earlier", Shape::Rate, |row| rate(row.of.iter().flat_map(|run| run.earlier.values().copied())))
        .column("demonstrations", Shape::Estimate(1), |row| {
            mean(row.of.iter().map(|run| f64::from(run.effort.demonstrations)), row.seed("demonstrations"))
        })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    let counted =
        runs.filter(|run| run.outcome.counts() && run.retained.is_some() && role(&run.key.method) != Role::FromScratch);
    let label = |key: &CellKey<'_>| {
        let CellKey { protocol, task, stage, variation, teacher, method, .. } = key;
        format!("t5/{protocol}/{task}/{stage:?}/{variation}/{teacher}/{method}")
    };
    let rows: Vec<Row> = rows(counted.map(|run| (CellKey::from(run), run)), label);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}
