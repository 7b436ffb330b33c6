//! T5: what a corrected model still does: the original task, and the variations it met before.

use situ::method::Role;

use super::column::{Columns, Shape};
use super::measure::{EFFORT, effort, success};
use super::rows::{self, CellKey, role, rows};
use super::sequences;
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};
use crate::tally::Rate;

/// The publication.
pub(super) const T5: Publication = Publication {
    name: "t5",
    question: "What does a corrected model still do: the original task, and the changes it met before?",
    tables: |records| {
        vec![table(records), sequences::stages(records), sequences::ageing(records), sequences::scores(records)]
    },
    figures: sequences::figures,
};

const TITLE: Title = Title {
    id: "t5",
    text: "T5 retention: what a corrected model still does",
    note: "A row is a cell over its seeds. `before` and `after` are success on the variation, `original before` and \
        `original after` on the original task, from the same fresh starts, by which nothing was decided. Means with \
        95 % bootstrap intervals over seeds, from two seeds on. Demonstrations: the budget, where the target was not \
        reached; ≥ marks a mean with such runs. Teaching from scratch and the control have no row.",
};

type Row<'a> = rows::Row<CellKey<'a>, &'a RunRecord>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let of = |row: &Row<'a>, rate: fn(&RunRecord) -> Option<Rate>| success(row.of.iter().copied(), rate);
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.protocol)
        .text("task", |row| row.key.task)
        .text("variation", |row| row.key.variation)
        .text("edit_needed", |row| row.key.edit.name())
        .text("teacher", |row| row.key.teacher)
        .text("method", |row| row.key.method.name)
        .count("runs", |row| row.of.len())
        .column("before", Shape::Pooled(2), move |row| of(row, |run| run.before))
        .column("after", Shape::Pooled(2), move |row| of(row, |run| run.after))
        .column("original_before", Shape::Pooled(2), move |row| of(row, |run| run.original_rate))
        .column("original_after", Shape::Pooled(2), move |row| of(row, |run| run.retained))
        .column("demonstrations", Shape::Pooled(1), |row| effort(row.of.iter().copied(), EFFORT[0].1))
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let counted =
        runs.filter(|run| run.outcome.counts() && run.retained.is_some() && role(&run.key.method) == Role::Correct);
    let rows: Vec<Row> = rows(counted.map(|run| (CellKey::from(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}
